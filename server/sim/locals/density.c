/* SPDX-License-Identifier: BSD-3-Clause */
/* From the sums of the density pass to densities, when no neighbour reads the old ones any more. */
#include "sim/locals/locals.h"

static void advance(Particles *s, const Model *model, size_t first, size_t last)
{
    const double dt = model->dt;
#pragma omp simd
    for (size_t i = first; i < last; i++) s->rho[i] += dt * s->rate[i];
}

/* Gamma was summed with the volumes of the densities before. As all around a particle are compressed about alike, it goes with 1/rho. */
static void follow(Particles *s, const Model *model, size_t first, size_t last)
{
    const double dt = model->dt;
#pragma omp simd
    for (size_t i = first; i < last; i++) s->shepard[i] *= s->rho[i] / (s->rho[i] + dt * s->rate[i]);
}

static void multiply(Particles *s, const Model *model, size_t first, size_t last)
{
    (void)model;
#pragma omp simd
    for (size_t i = first; i < last; i++) s->rho[i] = s->m[i] * s->rate[i];
}

const Local advance_density = {
    .name = "advance density",
    .source = "P3 eq. 17",
    .equation = "rho_i += dt d rho_i/dt",
    .on = ON_CONTINUITY,
    .apply = advance,
    .writes = FIELD(RHO),
};

const Local advance_shepard_sum = {
    .name = "advance Shepard sum",
    .source = "schemes/interfacial.md",
    .equation = "Gamma_i *= rho_i / (rho_i + dt d rho_i/dt)",
    .on = ON_CONTINUITY,
    .apply = follow,
    .writes = FIELD(SHEPARD),
};

const Local summed_density = {
    .name = "summed density",
    .source = "P3 eq. 4",
    .equation = "rho_i = m_i (W(0) + sum_j W_ij)",
    .on = ON_SUMMATION,
    .apply = multiply,
    .writes = FIELD(RHO),
};
