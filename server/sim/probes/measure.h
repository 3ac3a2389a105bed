/* SPDX-License-Identifier: BSD-3-Clause */
/* What probes share: sums and extremes over the fluid particles that count. Sums run over fixed blocks of particles, so that
 * the number of threads does not change a bit. */
#ifndef SIM_PROBES_MEASURE_H
#define SIM_PROBES_MEASURE_H

#include "sim/sample.h"

/* One probe, and what it takes to evaluate it at a particle. */
typedef struct Measure {
    const MnsSim *sim;
    const MnsProbe *probe;
    const MnsFieldInfo *field;  /* of an extremum */
    ShownView array[3];         /* its components */
    const FormulaTeam *formula; /* of a deviation */
    double limit, layer;        /* of an extent: particles nearer than limit, not nearer than layer */
    double known;               /* and how far out its fluid is known to go */
    int threads;
} Measure;

typedef double Summand(const Measure *m, size_t i);

/* Of the fluid of the probe, and within its box. */
bool measure_counts(const Measure *m, size_t i);

/* Over the particles that count: the sum; the largest value, NAN where there is none. */
double measure_sum(const Measure *m, Summand *f);
double measure_largest(const Measure *m, Summand *f);

/* Coordinate of a particle along the probe's axis, larger farther out. */
static inline double measure_outward(const Measure *m, size_t i)
{
    const double x = m->sim->s.x[m->probe->axis][i * m->sim->s.x_step];
    return m->probe->least ? -x : x;
}

/* The fluids of the probe, a bit for each: sample_share(). */
unsigned measure_fluids(const Measure *m);

/* Several sums at once over items of any kind, in their order whatever thread has worked one out. */
enum { TALLIES = 4 };
typedef void Tally(const void *of, size_t item, double sums[static TALLIES]); /* adds what the item has */
void measure_tally(const Measure *m, Tally *f, const void *of, size_t items, double ret[static TALLIES]);

/* Displacement along d of the wall the probe moves with. */
double measure_shift(const Measure *m, int d);

#endif
