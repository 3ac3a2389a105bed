/* SPDX-License-Identifier: BSD-3-Clause */
/* Figures of a run for whoever watches it from outside. The runner puts them at each step boundary and never waits; one other
 * thread looks, as often or as seldom as it likes, and has whole figures of one boundary in its hands until it looks again. */
#ifndef RUN_FIGURES_H
#define RUN_FIGURES_H

#include "run/document.h"
#include "run/lease.h"
#include "run/state.h"
#include <meniscus/sim.h>

enum { FIGURES_TIMERS = 32, FIGURES_REASONS = MNS_E_INTERNAL + 1 };

typedef struct RunFigures {
    RunState state;
    MnsError fault; /* in FAULT; EMPTY: why a run could not be brought back */
    Lease lease;

    /* Since the daemon began, whatever was loaded: */
    uint64_t steps;
    double stepping; /* wall-clock time in them [s] */
    uint64_t faults[FIGURES_REASONS];

    /* Of the present run; its document is NULL without one, and then the others mean nothing: */
    Document *document; /* a share of it */
    MnsProgress progress;
    double end_time, eta; /* [s]; NAN: not known */
    unsigned threads;
    size_t bytes;                                     /* of particles and neighbour lists */
    uint64_t uncorrected;                             /* as mns_sim_uncorrected()         */
    double energy_excess;                             /* as mns_sim_energy_excess()       */
    size_t particles[MNS_MAX_FLUIDS + MNS_MAX_WALLS]; /* by phase: fluids, then walls */
    size_t n_timers;
    MnsTimer timers[FIGURES_TIMERS];
    bool sampled;      /* the probes have been measured */
    double sampled_at; /* [s] */
    double probes[MNS_MAX_PROBES];
} RunFigures;

typedef struct Figures Figures;

/* NULL if there is no memory. What is looked at before anything was put is all 0. */
Figures *figures_new(void);
void figures_free(Figures *figures);

/* For one thread: these are the latest now. Shares the document. */
void figures_put(Figures *figures, const RunFigures *now);

/* For one other thread: the latest, borrowed until it looks again. */
const RunFigures *figures_look(Figures *figures);

#endif
