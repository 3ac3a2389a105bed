/* SPDX-License-Identifier: BSD-3-Clause */
/* Kinds of probes: each is a function here and a row of the table in probe.c. A probe is one number, from the particles as
 * they are now, and the number of threads does not change a bit of it. */
#ifndef SIM_PROBES_PROBES_H
#define SIM_PROBES_PROBES_H

#include "sim/probes/measure.h"

/* What a kind makes use of, and what is checked of it for that. */
enum {
    PROBE_AT_POINT = 1, /* at   */
    PROBE_ON_LINE = 2,  /* at, without its coordinate along the axis */
    PROBE_FIELD = 4,    /* field */
    PROBE_FORMULA = 8,  /* formula of x y z t */
    PROBE_INSIDE = 16   /* fluid, and radius, which is at most the kernel's support */
};

typedef struct ProbeKind {
    const char *name; /* in case.proto */
    const char *unit; /* NULL: that of its field */
    double (*measure)(Measure *m);
    unsigned uses;
} ProbeKind;

/* Row of the table; NULL if there is no such kind. */
const ProbeKind *probe_kind(const MnsProbe *probe);

/* sums.c */
double probe_kinetic_energy(Measure *m);
double probe_potential_energy(Measure *m);
double probe_mass_centre(Measure *m);
double probe_momentum(Measure *m);
double probe_mass(Measure *m);
double probe_velocity(Measure *m);
double probe_volume(Measure *m);
double probe_escaped(Measure *m);
double probe_pressure_deviation(Measure *m);

/* extremes.c */
double probe_front(Measure *m);
double probe_extremum(Measure *m);

/* places.c */
double probe_pressure(Measure *m);
double probe_height(Measure *m);
double probe_coverage(Measure *m);

/* surface.c */
double probe_elevation(Measure *m);
double probe_extent(Measure *m);

/* contour.c */
double probe_roundness(Measure *m);
double probe_surface_area(Measure *m);

/* jump.c */
double probe_pressure_jump(Measure *m);

/* solver.c */
double probe_solver(Measure *m);

#endif
