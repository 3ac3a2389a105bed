/* SPDX-License-Identifier: BSD-3-Clause */
/* How fast a run goes: over the last seconds for people who wait, and over all of it for the record. */
#ifndef RUN_METER_H
#define RUN_METER_H

#include <meniscus/sim.h>

typedef struct Meter {
    double stepping;       /* wall-clock time inside mns_sim_step() [s]             */
    double particle_steps; /* particles times steps                                 */
    uint64_t steps;
    double mark, mark_t; /* where the last stretch of measurement began: wall, t  */
    uint64_t mark_step;
    double steps_rate, time_rate; /* steps and simulated seconds per wall second; 0: not known yet */
    bool measured;                /* over a whole stretch at least */
    double ran;                   /* wall-clock time in motion, up to the last halt [s] */
    double since;                 /* when it was set in motion; while it is             */
    bool moving;
} Meter;

/* The clock starts, or starts again after a pause. */
void meter_begin(Meter *meter, MnsProgress progress, double now);

/* It stands, or still does. */
void meter_halt(Meter *meter, double now);

/* Wall-clock time in motion so far, without pauses [s]. */
double meter_ran(const Meter *meter, double now);

/* Steps a wall-clock second; NAN before the first step. */
double meter_rate(const Meter *meter);

/* A step has been done that took `seconds` of wall-clock time. */
void meter_step(Meter *meter, MnsProgress progress, size_t particles, double seconds, double now);

/* Wall-clock time to get from t to end, without pauses [s]; NAN before the first step. */
double meter_eta(const Meter *meter, double t, double end);

/* Cost of a step [ns per particle]; NAN before the first. */
double meter_ns(const Meter *meter);

#endif
