/* SPDX-License-Identifier: BSD-3-Clause */
/* The transport velocity and its stress, as terms. */
#include "sim/terms/transport.h"
#include "sim/fused.h"
#include "sim/terms/terms.h"

INLINE void background_row(const Row *row, Particles *s, const Model *model, How how)
{
    Lanes sums[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            background_pair(&pair, how, l, sums);
        }
    background_end(s, model, row->i, sums, how);
}
ROW_FUNCTIONS(background_row)

INLINE void transport_stress_row(const Row *row, Particles *s, const Model *model, How how)
{
    const Moved a = moved_of(s, model, row->i, how);
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        const double *others = row->mixed ? b->other : NO_OTHERS;
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            transport_stress_pair(&a, &pair, others[l], how, l, sum);
        }
    }
    transport_stress_end(s, row->i, sum, how);
}
ROW_FUNCTIONS(transport_stress_row)

const Term background = {
    .name = "background pressure",
    .source = "P3 eq. 11, 12",
    .equation = "b_i = -2 p_b / rho_i sum_j V_j grad_i W",
    .on = ON_FLUID,
    .needs = NEED_F | NEED_STATE,
    .writes = FIELD(B),
    .row = ROW_TABLE(background_row),
};

const Term transport_stress = {
    .name = "transport stress",
    .source = "P3 eq. 12 without its drag",
    .equation = "dv_i/dt += sum_j V_j (v_j - v_i) w_i . grad_i W,  w = dt/2 b",
    .on = ON_FLUID,
    .needed = is_transported,
    .needs = NEED_F | NEED_V | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(A),
    .row = ROW_TABLE(transport_stress_row),
};
