/* SPDX-License-Identifier: BSD-3-Clause */
/* Pressure forces, opposite to the last bit for the two of a pair, with P = p / Gamma, t of average.h, and between unlike fluids a
 * repulsion beta (|P_i| + |P_j|), so that they do not mix:
 *   P1 eq. 9:   m_i dv_i/dt = -sum_j V_i V_j ((1 + t) P_i + (1 - t) P_j) grad_i W,   p_j + J_ij for p_j across an interface with tension (jump.h)
 *   P2 eq. 24:  m_i dv_i/dt = -sum_j (V_i^2 (1 + t) P_i + V_j^2 (1 - t) P_j) grad_i W
 * The repulsion takes |p|, as it would attract where p < 0. Against a wall Gamma is 1 and t is 0: it shows the fluid a pressure of its own. */
#include "sim/terms/jump.h"
#include "sim/terms/push.h"
#include "sim/terms/terms.h"

/* mixed: there may be other fluids. Two loops, as the compiler gives up one that asks. */
INLINE void push_fluid(const Row *row, const Particles *s, const Pushed *a, const Model *model, bool mixed, How how,
                       Weights weights, Lanes sum[3])
{
    const bool jumps = mixed && model->tense;
    const Jump jump = jumps ? jump_of(s, model, row->i, 1) : NO_JUMP;
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        double lacks[LANES] = {0};
        if (jumps) jumps_of(&jump, s, row_j(row, b), lacks);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            Pair pair = block_pair(b, l, how);
            if (mixed) pair.jump = lacks[l];
            pressure_pair(a, model, &pair, mixed, model->repulsion * pair.other, how, l, sum, weights);
        }
    }
}

INLINE void push(const Row *row, Particles *s, const Model *model, How how, Weights weights)
{
    const size_t i = row->i;
    const Block *const walls = row->block + row->n_fluid, *const end = row->block + row->n;
    const Pushed a = pushed_of(s, model, i);
    const WallPressure shown = wall_pressure_of(s, i);
    Lanes sum[3] = {0};
    if (row->mixed) push_fluid(row, s, &a, model, true, how, weights, sum);
    else push_fluid(row, s, &a, model, false, how, weights, sum);
    for (const Block *b = walls; b < end; b++) {
        const uint32_t *j = row_j(row, b);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            pressure_wall(&a, &pair, shown_by(&shown, j[l]), how, l, sum, weights);
        }
    }
    pressure_end(s, i, sum, how);
}

INLINE void pressure_force_row(const Row *row, Particles *s, const Model *model, How how)
{
    push(row, s, model, how, WEIGHTS_PRODUCT);
}
ROW_FUNCTIONS(pressure_force_row)

INLINE void volume_pressure_force_row(const Row *row, Particles *s, const Model *model, How how)
{
    push(row, s, model, how, WEIGHTS_SQUARES);
}
ROW_FUNCTIONS(volume_pressure_force_row)

const Term pressure_force = {
    .name = "pressure force",
    .source = "P1 eq. 9",
    .equation = "m_i dv_i/dt -= sum_j V_i V_j ((1 + t) p_i/Gamma_i + (1 - t) p_j/Gamma_j) grad_i W, and a repulsion of "
                "unlike fluids",
    .on = ON_FLUID,
    .needed = plain_gradients,
    .needs = NEED_F | NEED_STATE | NEED_SHEPARD | NEED_OTHERS,
    .writes = FIELD(A),
    .row = ROW_TABLE(pressure_force_row),
};

const Term volume_pressure_force = {
    .name = "pressure force",
    .source = "P2 eq. 24, 65",
    .equation =
        "m_i dv_i/dt -= sum_j (V_i^2 (1 + t) p_i/Gamma_i + V_j^2 (1 - t) p_j/Gamma_j) grad_i W, and a repulsion",
    .on = ON_FLUID,
    .needed = plain_gradients,
    .needs = NEED_F | NEED_STATE | NEED_SHEPARD | NEED_OTHERS,
    .writes = FIELD(A),
    .row = ROW_TABLE(volume_pressure_force_row),
};
