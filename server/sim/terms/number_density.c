/* SPDX-License-Identifier: BSD-3-Clause */
/* Density by summation over all neighbours, of any fluid or wall.                                               P3 eq. 4
 *   rate_i = W(0) + sum_j W_ij,   rho_i = m_i rate_i
 * The kernel is calibrated, so that the lattice of the start has one particle in each of its cells. */
#include "sim/fused.h"
#include "sim/terms/terms.h"

INLINE void number_density_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)how;
    Lanes sum = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) sum.of[l] += b->W[l];
    s->rate[row->i] = kernel_at_zero(&model->kernel) + lanes_sum(&sum);
}
ROW_FUNCTIONS(number_density_row)

INLINE void number_density_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    uint32_t j[PICKED_MAX];
    _Alignas(64) double r[ROW_BLOCKS][LANES];
    double x[3];
    Lanes sum = {0};
    Block block;
    const Picked picked = pick_neighbours(plan, i, j);
    position_of(s, i, how, x);
    for (size_t b = 0; b < picked.n; b++) {
        const double *beyond = beyond_reach(plan, &picked, b);
        fetch_block(&block, j + b * LANES, &plan->nb->bundles, NEED_W, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = fetched_pair(&block, l, beyond, x, plan, NEED_W, how);
            r[b][l] = pair.r;
            sum.of[l] += pair.W;
        }
    }
    note_reach(plan, i, &picked, r[0], LANES);
    s->rate[i] = plan->at_zero + lanes_sum(&sum);
}
FUSED_FUNCTIONS(number_density_fused)

const Term number_density = {
    .name = "number density",
    .source = "P3 eq. 4",
    .equation = "sigma_i = W(0) + sum_j W_ij",
    .on = ON_SUMMATION,
    .needs = NEED_W,
    .row = ROW_TABLE(number_density_row),
};

const Fusion number_density_alone = {
    .terms = {&number_density},
    .notes = true,
    .row = FUSED_TABLE(number_density_fused),
};
