/* SPDX-License-Identifier: BSD-3-Clause */
/* Density by summation over all neighbours, of any fluid or wall.                                               P3 eq. 4
 *   rate_i = W(0) + sum_j W_ij,   rho_i = m_i rate_i
 * The kernel is calibrated, so that the lattice of the start has one particle in each of its cells. */
#include "sim/terms/terms.h"

static void number_density_row(Row *row, Particles *s, const Model *model)
{
    const size_t n = row_whole(row->n);
    const double *restrict W = row->W;
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t k = 0; k < n; k++) sum += W[k];
    s->rate[row->i] = kernel_at_zero(&model->kernel) + sum;
}

const Term number_density = {
    .name = "number density",
    .source = "P3 eq. 4",
    .equation = "rho_i = m_i (W(0) + sum_j W_ij) ",
    .on = ON_SUMMATION,
    .row = number_density_row,
};
