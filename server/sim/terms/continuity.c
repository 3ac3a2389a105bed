/* SPDX-License-Identifier: BSD-3-Clause */
/* Density by what flows together. Walls count as the fluid that meets them, and move as they are told to: with P2's mirrored
 * velocities (eq. 38) air at the foot of a dam is compressed by the water's image, and its density leaves all bounds in 40 steps.
 *   P1 eq. 7:   d rho_i/dt = rho_i sum_j V_j v_ij . grad_i W
 *   P2 eq. 16:  d rho_i/dt = m_i / Gamma_i sum_j v_ij . grad_i W,   midway (midway.h) */
#include "sim/terms/continuity.h"
#include "sim/terms/terms.h"

/* of_neighbours: what flows counts by the neighbours' volumes, as in P1; else by the particle's own. */
INLINE void flow(const Row *row, Particles *s, const Model *model, How how, bool of_neighbours)
{
    const Flowing a = flowing_of(s, model, row->i);
    const Block *const walls = row->block + row->n_fluid, *const end = row->block + row->n;
    Lanes sum = {0};
    for (const Block *b = row->block; b < walls; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double inverse = flowing_inverse(&a, &pair);
            if (of_neighbours) continuity_pair(&a, model, &pair, inverse, how, l, &sum);
            else volume_continuity_pair(&a, model, &pair, inverse, how, l, &sum);
        }
    for (const Block *b = walls; b < end; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            if (of_neighbours) continuity_wall(&a, &pair, how, l, &sum);
            else volume_continuity_wall(&a, &pair, how, l, &sum);
        }
    if (of_neighbours) continuity_end(s, row->i, &sum);
    else volume_continuity_end(s, row->i, &sum);
}

INLINE void continuity_row(const Row *row, Particles *s, const Model *model, How how)
{
    flow(row, s, model, how, true);
}
ROW_FUNCTIONS(continuity_row)

INLINE void volume_continuity_row(const Row *row, Particles *s, const Model *model, How how)
{
    flow(row, s, model, how, false);
}
ROW_FUNCTIONS(volume_continuity_row)

const Term continuity = {
    .name = "continuity",
    .source = "P1 eq. 7",
    .equation = "d rho_i/dt = rho_i sum_j V_j (1 + t) v_ij . grad_i W",
    .on = ON_CONTINUITY,
    .needed = plain_gradients,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .row = ROW_TABLE(continuity_row),
};

const Term volume_continuity = {
    .name = "continuity of volumes",
    .source = "P2 eq. 16",
    .equation = "d rho_i/dt = m_i / Gamma_i sum_j (1 + t) v_ij . grad_i W,  at x_ij - dt/2 v_ij",
    .on = ON_CONTINUITY,
    .needed = plain_gradients,
    .needs = NEED_F | NEED_V | NEED_STATE | NEED_BEND,
    .row = ROW_TABLE(volume_continuity_row),
};
