/* SPDX-License-Identifier: BSD-3-Clause */
/* Density by summation over all neighbours, of any fluid or wall.                                               P3 eq. 4
 *   rate_i = W(0) + sum_j W_ij,   rho_i = m_i rate_i
 * The kernel is calibrated, so that the lattice of the start has one particle in each of its cells. */
#include "sim/terms/terms.h"

INLINE void number_density_row(const Row *row, Particles *s, const Model *model, int dim)
{
    (void)dim;
    Lanes sum = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) sum.of[l] += b->W[l];
    s->rate[row->i] = kernel_at_zero(&model->kernel) + lanes_sum(&sum);
}
ROW_FUNCTIONS(number_density_row)

const Term number_density = {
    .name = "number density",
    .source = "P3 eq. 4",
    .equation = "rho_i = m_i (W(0) + sum_j W_ij) ",
    .on = ON_SUMMATION,
    .needs = NEED_W,
    .row = ROW_TABLE(number_density_row),
};
