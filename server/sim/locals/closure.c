/* SPDX-License-Identifier: BSD-3-Clause */
/* Liquids that fill a closed space have its volume. Where density follows continuity nothing else knows that: spreading moves
 * particles and not their density, so that the mean pressure of a full tank of 1 m climbs by 0.9 rho g H a second
 * (schemes/riemann.md). The same pressure everywhere, up or down, puts the volume right:
 *   rho_i += dp / c_i^2,   dp = (sum_i m_i/rho_i - n V_0) / sum_i m_i/(rho_i^2 c_i^2) */
#include "sim/fluid_sum.h"
#include "sim/locals/locals.h"

static double compliance(const Particles *s, const Model *model, size_t i)
{
    const double c = model->phase[s->phase[i]].c;
    return s->m[i] / (s->rho[i] * s->rho[i] * c * c);
}

static bool is_full_of_liquids(const Model *model)
{
    for (size_t k = 0; k < model->n_phases; k++)
        if (model->phase[k].summation) return false;
    return model->closed;
}

static void keep_volume(Particles *s, const Model *model, int threads)
{
    const size_t n = particles_fluid(s);
    const double excess = fluid_sum(s, model, particles_volume, threads) - (double)n * model->cell_volume;
    const double dp = excess / fluid_sum(s, model, compliance, threads);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < n; i++) {
        const double c = model->phase[s->phase[i]].c;
        s->rho[i] += dp / (c * c);
    }
}

const Local closed_volume = {
    .name = "closed volume",
    .source = "schemes/riemann.md",
    .equation = "rho_i += dp/c_i^2, so that sum m_i/rho_i is the volume of a space that liquids fill",
    .on = ON_CONTINUITY,
    .needed = is_full_of_liquids,
    .whole = keep_volume,
    .writes = FIELD(RHO),
};
