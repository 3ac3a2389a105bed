/* SPDX-License-Identifier: BSD-3-Clause */
/* What differences of any field are made with, and what the neighbours of a particle are a mixture of.             P5 eq. 5-11
 *   C_i = sum_j W over the first fluid / sum_j W, itself included,  f_i = f_1 + (f_0 - f_1) C_i  of density and viscosity
 * Walls are points like others, where fields are continued (wall_differences.c); they are mixtures of the fluids before them. */
#include "sim/terms/differences.h"
#include "sim/terms/terms.h"

INLINE void truncation_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    Moments moments = {0};
    Lanes first[3] = {0}, second = {0}, third[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double Wr2 = pair.W * DOT(pair.x, pair.x, how);
            moments_add(&moments, &pair, pair.W, how, l);
            second.of[l] += Wr2;
            for (int d = 0; d < how.dim; d++) {
                add_product(&first[d], l, pair.W, pair.x[d], how);
                add_product(&third[d], l, Wr2, pair.x[d], how);
            }
        }
    const Correction B = moments_inverse_of(&moments, 1 / model->differences.scale, how);
    keep_correction(s, i, &B, how);
    double o[3], D = lanes_sum(&second);
    gradient_of(s, i, model, first, how, o);
    for (int d = 0; d < how.dim; d++) {
        s->offset[d][i * s->offset_step] = o[d];
        D -= o[d] * lanes_sum(&third[d]);
    }
    s->laplacian[i] = D > 0 ? 2 * how.dim / D : 0;
}
ROW_FUNCTIONS(truncation_row)

INLINE void mixture_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)how;
    const size_t i = row->i;
    const bool fluid = i < particles_fluid(s);
    const double self = fluid ? kernel_at_zero(&model->kernel) : 0;
    Lanes all = {0}, first = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        const uint32_t *j = row_j(row, b);
        double counts[LANES];
        for (int l = 0; l < LANES; l++) counts[l] = s->phase[j[l]] == 0 ? 1 : 0;
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            all.of[l] += b->W[l];
            first.of[l] += counts[l] * b->W[l];
        }
    }
    const double sum = lanes_sum(&all) + self, mine = lanes_sum(&first) + (s->phase[i] == 0 ? self : 0);
    s->colour[i] = sum > 0 ? mine / sum : 1;
}
ROW_FUNCTIONS(mixture_row)

const Term truncation = {
    .name = "truncation and offset",
    .source = "P5 eq. 9-11",
    .equation = "B_i = (sum_j W x (x) x)^-1,  o_i = B_i sum_j W x,  k_ij = W (1 - x . o_i),  D_i = sum_j r^2 k_ij",
    .on = ON_FLUID,
    .needs = NEED_W,
    .writes = FIELD(CORRECTION) | FIELD(CORRECTION_OFF) | FIELD(OFFSET) | FIELD(LAPLACIAN),
    .row = ROW_TABLE(truncation_row),
};

const Term mixture = {
    .name = "mixture",
    .source = "P5 eq. 5-7",
    .equation = "C_i = sum_j W over the first fluid / sum_j W;  rho~, mu~ = f_1 + (f_0 - f_1) C_i",
    .on = ON_ALL,
    .needs = NEED_W,
    .writes = FIELD(COLOUR) | FIELD(RHO_MIXED) | FIELD(MU_MIXED),
    .row = ROW_TABLE(mixture_row),
};
