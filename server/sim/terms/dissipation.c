/* SPDX-License-Identifier: BSD-3-Clause */
/* Dissipation of density increments across interfaces.                                                     P1 eq. 45-49
 *   G_i = sum_j (p_j - p_i) M_i grad_i W V_j
 *   d rho_i/dt += -delta sum_j 2 rho_i / (z_i + z_j) psi_ij (x_ij . grad_i W)/r V_j,   z = rho c
 *   psi_ij = p_j + J_ij - p_i + (G_i + G_j)/2 . x_ij,   0 in a linear field that jumps by the tension (jump.h)
 * Beside a fluid that fills what room there is, and where there is tension, G and its M are of one's own fluid: the gradient has a kink at its surface,
 * over which a mean would drive mass through it. In a spray G has few neighbours, and psi can get the opposite sign of p_j + J_ij - p_i: the term would then add
 * energy. Such a pair dissipates nothing (dambreak2d made 17 % of its energy where a drop left the far wall).
 * Eq. 49 lacks 1/r, which its dimension asks for, and eq. 46 has the sign of G_j wrong: as printed a layer of water sinks through
 * its floor. The factor 2 rho_i/(rho_i + rho_j) keeps the volume of a pair; it and 1/c are one here, so that fluids may differ in their
 * speeds of sound, and it is what a Riemann problem dissipates (P3 eq. 10). Pairs with walls dissipate nothing: their pressures are
 * extrapolated. */
#include "sim/terms/continuity.h"
#include "sim/terms/jump.h"
#include "sim/terms/moments.h"
#include "sim/terms/terms.h"

static bool dissipates(const Model *model)
{
    return model->delta > 0;
}

static bool needs_gradient(const Model *model)
{
    return model->delta > 0 && model->dissipates_rest;
}

INLINE void pressure_gradient_row(const Row *row, Particles *s, const Model *model, How how)
{
    const double p = s->p[row->i * s->p_step], own = row->mixed ? model->own_gradients : 0;
    Moments moments = {0};
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double counts = own > 0 ? 1 - own * pair.other : 1;
            gradient_pair(p, &pair, counts, how, l, sum);
            moments_pair(&moments, &pair, counts, how, l);
        }
    gradient_end(s, row->i, &moments, sum, model->own_gradients > 0 ? least_moments(how) : 0, how);
}
ROW_FUNCTIONS(pressure_gradient_row)

INLINE void density_dissipation_row(const Row *row, Particles *s, const Model *model, How how)
{
    const Flowing a = flowing_of(s, model, row->i);
    const Jump jump = model->tense ? jump_of(s, model, row->i, 1) : NO_JUMP;
    Lanes sum = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        double lacks[LANES] = {0};
        if (row->mixed && model->tense) jumps_of(&jump, s, row_j(row, b), lacks);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            Pair pair = block_pair(b, l, how);
            pair.jump = lacks[l];
            dissipation_pair(&a, &pair, flowing_inverse(&a, &pair), how, l, &sum);
        }
    }
    dissipation_end(s, model, row->i, &sum);
}
ROW_FUNCTIONS(density_dissipation_row)

const Term pressure_gradient = {
    .name = "pressure gradient",
    .source = "P1 eq. 45",
    .equation = "G_i = sum_j (p_j - p_i) M_i grad_i W V_j",
    .on = ON_CONTINUITY,
    .needed = needs_gradient,
    .needs = NEED_F | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(GRADIENT),
    .row = ROW_TABLE(pressure_gradient_row),
};

const Term density_dissipation = {
    .name = "density dissipation",
    .source = "P1 eq. 49",
    .equation = "d rho_i/dt -= delta sum_j 2 rho_i/(z_i + z_j) psi_ij (x_ij . grad_i W)/r V_j",
    .on = ON_CONTINUITY,
    .needed = dissipates,
    .needs = NEED_F | NEED_STATE | NEED_GRADIENT | NEED_OTHERS,
    .row = ROW_TABLE(density_dissipation_row),
};
