/* SPDX-License-Identifier: BSD-3-Clause */
/* Gradients of pressures, beside which P3's v* has none of them. Found once pressures are, for the densities of the step that follows. */
#include "sim/terms/slope.h"
#include "sim/fused.h"
#include "sim/terms/terms.h"

static bool spares_slopes(const Model *model)
{
    return model->spared == SPARED_SLOPES;
}

static bool is_of_gas(const Particles *s, const Model *model, size_t i)
{
    return model_is_gas(model, model->phase[s->phase[i]].rho0);
}

INLINE void pressure_slope_row(const Row *row, Particles *s, const Model *model, How how)
{
    const double p = s->p[row->i * s->p_step];
    Moments moments = {0};
    Lanes sum[3] = {0};
    if (is_of_gas(s, model, row->i)) return;
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        const double *others = row->mixed ? b->other : NO_OTHERS;
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            moments_pair(&moments, &pair, 1 - others[l], how, l);
            gradient_pair(p, &pair, 1 - others[l], how, l, sum);
        }
    }
    gradient_end(s, row->i, &moments, sum, least_moments(how), how);
}
ROW_FUNCTIONS(pressure_slope_row)

INLINE void pressure_slope_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    enum { NEEDS = NEED_F | NEED_STATE };
    uint32_t j[PICKED_MAX];
    double x[3];
    const double p = s->p[i * s->p_step];
    Moments moments = {0};
    Lanes sum[3] = {0};
    Marks other;
    Block block;
    if (is_of_gas(s, plan->model, i)) return;
    const Picked picked = pick_neighbours(plan, i, j);
    mark_others(plan, i, j, &picked, &other);
    position_of(s, i, how, x);
    for (size_t b = 0; b < picked.n_fluid; b++) {
        const double *beyond = beyond_reach(plan, &picked, b);
        fetch_block(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = fetched_pair(&block, l, beyond, x, plan, NEEDS, how);
            moments_pair(&moments, &pair, 1 - other.of[b][l], how, l);
            gradient_pair(p, &pair, 1 - other.of[b][l], how, l, sum);
        }
    }
    gradient_end(s, i, &moments, sum, least_moments(how), how);
}
INTERLEAVED_FUNCTIONS(pressure_slope_fused)

const Term pressure_slope = {
    .name = "pressure slope",
    .source = "schemes/riemann.md",
    .equation = "g_i = M_i sum_j V_j (p_j - p_i) grad_i W over its own fluid",
    .on = ON_CONTINUITY,
    .needed = spares_slopes,
    .needs = NEED_F | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(GRADIENT),
    .row = ROW_TABLE(pressure_slope_row),
};

const Fusion pressure_slope_alone = {
    .terms = {&pressure_slope},
    .row = FUSED_TABLE(pressure_slope_fused),
};
