/* SPDX-License-Identifier: BSD-3-Clause */
/* What the divergence of mu (grad v + grad v^T) has besides that of mu grad v (viscosity.c), where fluids of unlike viscosity meet:
 *   rho_i dv_i/dt += grad mu . grad v^T,   grad mu_i = 2 sum_j V_j (mu_ij - mu_i) grad_i W,   mu_ij the harmonic mean
 * Without it a fluid that turns as a solid body is slowed, and a drop of a tenth of the viscosity in a shear is drawn out three quarters as
 * far. P4's eq. 3 has nu lap v, which is that of one fluid. The mean of the two viscosities is met half way, from either side, so
 * that the lighter fluid is not moved by the viscosity of the heavier one, and each pair weighs as much as in the other sum: on a lattice a solid
 * body feels nothing, to rounding. grad v is exact for linear flows; all that is asked of it is how the normal velocity changes, which it does without a jump. */
#include "sim/terms/moments.h"
#include "sim/terms/terms.h"
#include "sim/terms/viscosity.h"

static bool is_unlike(const Model *model)
{
    for (size_t k = 1; k < model->n_phases; k++)
        if (model->phase[k].mu != model->phase[0].mu) return true;
    return false;
}

/* 2 (mu_ij - mu_i), with the constant of the other sum. */
static double step_to(const Model *model, unsigned mine, unsigned its)
{
    return viscosity_of(model, mine, its, 4) - viscosity_of(model, mine, mine, 4);
}

INLINE void transposed_viscosity_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    if (!row->mixed) return;
    const double soft = viscosity_softening(&model->kernel);
    double steps[MNS_MAX_FLUIDS], v[3];
    Moments moments = {0};
    Lanes rise[3] = {0}, change[3][3] = {0};
    for (unsigned k = 0; k < model->n_phases; k++) steps[k] = step_to(model, s->phase[i], k);
    for (int d = 0; d < how.dim; d++) v[d] = s->v[d][i * s->v_step];
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        const uint32_t *j = row_j(row, b);
        double step[LANES];
        by_fluid(s, j, steps, step);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double r2 = pair.r * pair.r, c = pair.V * pair.F, weight = step[l] * (r2 / (r2 + soft));
            moments_pair(&moments, &pair, 1, how, l);
            for (int d = 0; d < how.dim; d++) {
                const double slope = c * pair.x[d];
                add_product(&rise[d], l, weight, slope, how);
                for (int e = 0; e < how.dim; e++) add_product(&change[e][d], l, pair.v[e] - v[e], slope, how);
            }
        }
    }
    const Correction M = moments_inverse(&moments, how);
    const double volume = particles_volume(s, model, i) / s->m[i];
    for (int e = 0; e < how.dim; e++) {
        double gradient[3];
        correct(&M, change[e], how, gradient);
        for (int d = 0; d < how.dim; d++) s->a[d][i] += volume * lanes_sum(&rise[e]) * gradient[d];
    }
}
ROW_FUNCTIONS(transposed_viscosity_row)

const Term transposed_viscosity = {
    .name = "viscosity, transposed",
    .source = "schemes/incompressible.md",
    .equation = "rho_i dv_i/dt += grad mu . grad v^T,  grad mu_i = 2 sum_j V_j (mu_ij - mu_i) grad_i W",
    .on = ON_FLUID,
    .needed = is_unlike,
    .needs = NEED_F | NEED_V | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(A),
    .beside = LIST_OTHERS,
    .row = ROW_TABLE(transposed_viscosity_row),
};
