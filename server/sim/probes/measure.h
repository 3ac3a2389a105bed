/* SPDX-License-Identifier: BSD-3-Clause */
/* What probes share: sums and extremes over the fluid particles that count. Sums run over fixed blocks of particles, so that
 * the number of threads does not change a bit. */
#ifndef SIM_PROBES_MEASURE_H
#define SIM_PROBES_MEASURE_H

#include "sim/sim.h"

/* One probe, and what it takes to evaluate it at a particle. */
typedef struct Measure {
    const MnsSim *sim;
    const MnsProbe *probe;
    const MnsFieldInfo *field;  /* of an extremum */
    const void *array[3];       /* its components */
    const FormulaTeam *formula; /* of a deviation */
    int threads;
} Measure;

typedef double Summand(const Measure *m, size_t i);

/* Of the fluid of the probe, and within its box. */
bool measure_counts(const Measure *m, size_t i);

/* Over the particles that count: the sum; the largest value, NAN where there is none. */
double measure_sum(const Measure *m, Summand *f);
double measure_largest(const Measure *m, Summand *f);

/* Displacement along d of the wall the probe moves with. */
double measure_shift(const Measure *m, int d);

#endif
