/* SPDX-License-Identifier: BSD-3-Clause */
/* Sums and extremes over the fluid particles that a probe counts. */
#include "sim/probes/measure.h"
#include <math.h>
#include <string.h>

bool measure_counts(const Measure *m, size_t i)
{
    const MnsProbe *probe = m->probe;
    if (probe->fluid >= 0 && m->sim->s.phase[i] != probe->fluid) return false;
    for (int d = 0; probe->within && d < m->sim->s.dim; d++)
        if (m->sim->s.x[d][i * m->sim->s.x_step] < probe->min[d] ||
            m->sim->s.x[d][i * m->sim->s.x_step] > probe->max[d])
            return false;
    return true;
}

/* Combine f over the fluid particles that count: sum, or the largest value where `largest`; NAN where there is none. Blocks take
 * unequal time, as of an extent only a layer is looked at. */
static double over_fluid(const Measure *m, Summand *f, bool largest)
{
    const size_t n = particles_fluid(&m->sim->s), blocks = sim_blocks(n);
    const double none = largest ? -INFINITY : 0;
    double *partial = m->sim->partial, result = none;
#pragma omp parallel for schedule(dynamic) num_threads(m->threads)
    for (size_t b = 0; b < blocks; b++) {
        double value = none;
        for (size_t i = b * SIM_BLOCK; i < n && i < (b + 1) * SIM_BLOCK; i++) {
            if (!measure_counts(m, i)) continue;
            const double term = f(m, i);
            value = largest ? (term > value ? term : value) : value + term;
        }
        partial[b] = value;
    }
    for (size_t b = 0; b < blocks; b++)
        result = largest ? (partial[b] > result ? partial[b] : result) : result + partial[b];
    return largest && !(result > -INFINITY) ? NAN : result;
}

double measure_sum(const Measure *m, Summand *f)
{
    return over_fluid(m, f, false);
}

double measure_largest(const Measure *m, Summand *f)
{
    return over_fluid(m, f, true);
}

unsigned measure_fluids(const Measure *m)
{
    if (m->probe->fluids) return m->probe->fluids;
    return m->probe->fluid < 0 ? EVERY_FLUID : 1u << m->probe->fluid;
}

/* In batches, as there is no room for the sums of all items. */
void measure_tally(const Measure *m, Tally *f, const void *of, size_t items, double ret[static TALLIES])
{
    enum { BATCH = 256 };
    double sums[BATCH][TALLIES];
    for (int k = 0; k < TALLIES; k++) ret[k] = 0;
    for (size_t first = 0; first < items; first += BATCH) {
        const size_t n = items - first < BATCH ? items - first : BATCH;
        memset(sums, 0, sizeof sums);
#pragma omp parallel for schedule(dynamic) num_threads(m->threads)
        for (size_t item = 0; item < n; item++) f(of, first + item, sums[item]);
        for (size_t item = 0; item < n; item++)
            for (int k = 0; k < TALLIES; k++) ret[k] += sums[item][k];
    }
}

double measure_shift(const Measure *m, int d)
{
    const int wall = m->probe->wall;
    return wall >= 0 ? m->sim->model.wall[wall].x[d] : 0;
}
