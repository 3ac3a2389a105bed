/* SPDX-License-Identifier: BSD-3-Clause */
/* The jump of the pressure across the surface of a fluid. */
#include "sim/probes/probes.h"
#include <math.h>

enum { PRESSURE_INSIDE, NUMBER_INSIDE, PRESSURE_OUTSIDE, NUMBER_OUTSIDE };

/* Lists hold all that is within the kernel's support, and a margin is not wider. */
static bool is_near_surface(const Measure *m, size_t i)
{
    const MnsSim *sim = m->sim;
    const Particles *s = &sim->s;
    const double margin = m->probe->radius > 0 ? m->probe->radius : sim->model.kernel.support;
    const uint32_t *list = neighbours_of(&sim->nb, i);
    const bool inside = s->phase[i] == m->probe->fluid;
    for (size_t k = 0; k < sim->nb.end[i][END_FLUID]; k++) {
        const uint32_t j = list[k];
        if ((s->phase[j] == m->probe->fluid) == inside) continue;
        double r2 = 0;
        for (int d = 0; d < s->dim; d++)
            r2 += pow(model_nearest(&sim->model, d, s->x[d][i * s->x_step] - s->x[d][j * s->x_step]), 2);
        if (r2 <= margin * margin) return true;
    }
    return false;
}

static void add_block(const void *of, size_t block, double sums[static TALLIES])
{
    const Measure *m = of;
    const Particles *s = &m->sim->s;
    const size_t n = particles_fluid(s);
    for (size_t i = block * SIM_BLOCK; i < n && i < (block + 1) * SIM_BLOCK; i++) {
        if (is_near_surface(m, i)) continue;
        const bool inside = s->phase[i] == m->probe->fluid;
        sums[inside ? PRESSURE_INSIDE : PRESSURE_OUTSIDE] += s->p[i * s->p_step];
        sums[inside ? NUMBER_INSIDE : NUMBER_OUTSIDE] += 1;
    }
}

double probe_pressure_jump(Measure *m)
{
    double sums[TALLIES];
    measure_tally(m, add_block, m, sim_blocks(particles_fluid(&m->sim->s)), sums);
    return sums[PRESSURE_INSIDE] / sums[NUMBER_INSIDE] - sums[PRESSURE_OUTSIDE] / sums[NUMBER_OUTSIDE];
}
