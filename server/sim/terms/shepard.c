/* SPDX-License-Identifier: BSD-3-Clause */
/* Gamma_i = W(0) V_i + sum_j W_ij V_j over fluids and walls: 1 inside, less at a free surface.                  P1 eq. 9 */
#include "sim/terms/terms.h"

INLINE void shepard_row(const Row *row, Particles *s, const Model *model, How how)
{
    Lanes sum = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) add_product(&sum, l, b->W[l], b->V[l], how);
    s->shepard[row->i] = kernel_at_zero(&model->kernel) * particles_volume(s, model, row->i) + lanes_sum(&sum);
}
ROW_FUNCTIONS(shepard_row)

const Term shepard_sum = {
    .name = "Shepard sum",
    .source = "P1 eq. 9, P2 eq. 12",
    .equation = "Gamma_i = W(0) V_i + sum_j W_ij V_j",
    .on = ON_FLUID,
    .needs = NEED_W | NEED_STATE,
    .writes = FIELD(SHEPARD),
    .row = ROW_TABLE(shepard_row),
};
