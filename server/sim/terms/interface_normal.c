/* SPDX-License-Identifier: BSD-3-Clause */
/* Normals of interfaces, towards other fluids.                                                                  P1 eq. 11, 12, P2 eq. 35
 *   q_i = sum_j grad_i W V_j over other fluids,   n_i = q_i / |q_i| where |q_i| h > 0.01, else none
 * of P2 with M_i grad_i W, of fluids and walls. The papers weigh by density: with such weights no particle of air ever has a normal.
 * Walls have no colour: where they are flat, what lies beside them is mirrored instead (images.c). */
#include "sim/terms/interface_normal.h"
#include "sim/terms/images.h"
#include "sim/terms/terms.h"
#include <math.h>

double magnitude_of(double square)
{
    return sqrt(square);
}

INLINE Correction moments_of(const Row *row, How how)
{
    Moments moments = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            moments_pair(&moments, &pair, 1, how, l);
        }
    return moments_inverse(&moments, how);
}

INLINE void towards_others(const Row *row, How how, Lanes sum[3])
{
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            towards_pair(&pair, pair.other, how, l, sum);
        }
}

INLINE void find_normal(const Row *row, Particles *s, const Model *model, How how, bool corrected)
{
    if (!row->mixed) {
        normal_none(s, row->i, how);
        return;
    }
    Row room;
    const Row *seen = row_with_images(row, s, model, &room);
    Lanes sum[3] = {0};
    const Correction M = corrected ? moments_of(seen, how) : NO_CORRECTION;
    towards_others(seen, how, sum);
    normal_end(s, model, row->i, &M, sum, how);
}

INLINE void interface_normal_row(const Row *row, Particles *s, const Model *model, How how)
{
    find_normal(row, s, model, how, false);
}
ROW_FUNCTIONS(interface_normal_row)

INLINE void corrected_normal_row(const Row *row, Particles *s, const Model *model, How how)
{
    find_normal(row, s, model, how, true);
}
ROW_FUNCTIONS(corrected_normal_row)

const Term interface_normal = {
    .name = "interface normal",
    .source = "P1 eq. 12, not weighted",
    .equation = "n_i = q_i/|q_i|,  q_i = sum_j grad_i W V_j over other fluids",
    .on = ON_FLUID,
    .needed = finds_normals,
    .needs = NEED_F | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(NORMAL),
    .row = ROW_TABLE(interface_normal_row),
};

static void no_normal(const RowPlan *plan, Particles *s, size_t i)
{
    (void)plan;
    normal_none(s, i, (How){.dim = s->dim});
}

const Fusion no_interface = {
    .terms = {&corrected_normal},
    .not_for = LIST_OTHERS,
    .row = {[0 ... LEVELS - 1] = {no_normal, no_normal}},
};

const Term corrected_normal = {
    .name = "interface normal",
    .source = "P2 eq. 35, not weighted",
    .equation = "n_i = q_i/|q_i|,  q_i = sum_j M_i grad_i W V_j over other fluids",
    .on = ON_FLUID,
    .needed = finds_normals,
    .needs = NEED_F | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(NORMAL),
    .row = ROW_TABLE(corrected_normal_row),
};
