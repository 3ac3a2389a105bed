/* SPDX-License-Identifier: BSD-3-Clause */
/* Density of P2 and how particles lie, for those beside walls, and normals of those beside another fluid. */
#include "sim/fused.h"
#include "sim/terms/continuity.h"
#include "sim/terms/interface_normal.h"
#include "sim/terms/jump.h"
#include "sim/terms/push.h"
#include "sim/terms/terms.h"

INLINE void density_beside(const RowPlan *plan, Particles *s, size_t i, How how)
{
    enum { WALL_NEEDS = NEED_W | NEED_F | NEED_BEND | NEED_V | NEED_STATE, NEEDS = WALL_NEEDS | NEED_GRADIENT };
    uint32_t j[PICKED_MAX];
    _Alignas(64) double r[ROW_BLOCKS][LANES];
    double x[3];
    Lanes shepard = {0}, crowd[3] = {0}, flow = {0}, dissipated = {0};
    Block block;
    const Model *model = plan->model;
    const Picked picked = pick_neighbours(plan, i, j);
    const Flowing a = flowing_of(s, model, i);
    const bool jumps = model->tense && plan->nb->has[i] & LIST_OTHERS;
    const Jump jump = jumps ? jump_of(s, model, i, 1) : NO_JUMP;
    position_of(s, i, how, x);
    for (size_t b = 0; b < picked.n_fluid; b++) {
        const double *beyond = beyond_reach(plan, &picked, b);
        double lacks[LANES] = {0};
        if (jumps) jumps_of(&jump, s, j + b * LANES, lacks);
        fetch_block(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            Pair pair = fetched_pair(&block, l, beyond, x, plan, NEEDS, how);
            pair.jump = lacks[l];
            const double inverse = flowing_inverse(&a, &pair);
            r[b][l] = pair.r;
            add_product(&shepard, l, pair.W, pair.V, how);
            add_along(&pair, pair.V * pair.F, how, l, crowd);
            volume_continuity_pair(&a, model, &pair, inverse, how, l, &flow);
            dissipation_pair(&a, &pair, inverse, how, l, &dissipated);
        }
    }
    for (size_t b = picked.n_fluid; b < picked.n; b++) {
        const double *beyond = beyond_reach(plan, &picked, b);
        fetch_block(&block, j + b * LANES, &plan->nb->bundles, WALL_NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = fetched_pair(&block, l, beyond, x, plan, WALL_NEEDS, how);
            r[b][l] = pair.r;
            add_product(&shepard, l, pair.W, pair.V, how);
            add_along(&pair, pair.V * pair.F, how, l, crowd);
            volume_continuity_wall(&a, &pair, how, l, &flow);
        }
    }
    note_reach(plan, i, &picked, r[0], LANES);
    s->shepard[i] = plan->at_zero * particles_volume(s, plan->model, i) + lanes_sum(&shepard);
    for (int d = 0; d < how.dim; d++) s->concentration[d][i] = lanes_sum(&crowd[d]);
    volume_continuity_end(s, i, &flow);
    dissipation_end(s, model, i, &dissipated);
}
BESIDE_FUNCTIONS(density_beside)

INLINE void normal_beside(const RowPlan *plan, Particles *s, size_t i, How how)
{
    enum { NEEDS = NEED_F | NEED_STATE };
    uint32_t j[PICKED_MAX];
    double x[3];
    Lanes towards[3] = {0};
    Moments moments = {0};
    Block block;
    Marks other;
    const Picked picked = pick_neighbours(plan, i, j);
    if (!mark_others(plan, i, j, &picked, &other)) {
        normal_none(s, i, how);
        return;
    }
    position_of(s, i, how, x);
    for (size_t b = 0; b < picked.n; b++) {
        const bool is_wall = b >= picked.n_fluid;
        const double *beyond = beyond_reach(plan, &picked, b), *others = is_wall ? NO_OTHERS : other.of[b];
        fetch_block(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = fetched_pair(&block, l, beyond, x, plan, NEEDS, how);
            moments_pair(&moments, &pair, 1, how, l);
            towards_pair(&pair, others[l], how, l, towards);
        }
    }
    const Correction M = moments_inverse(&moments, how);
    normal_end(s, plan->model, i, &M, towards, how);
}
BESIDE_FUNCTIONS(normal_beside)

const Fusion interfacial_density_beside = {
    .terms = {&shepard_sum, &concentration, &volume_continuity, &density_dissipation},
    .notes = true,
    .row = BESIDE_TABLE(density_beside),
};

const Fusion interfacial_normal = {
    .terms = {&corrected_normal},
    .not_together = LIST_WALLS | LIST_OTHERS, /* where walls mirror interfaces (images.c) */
    .row = BESIDE_TABLE(normal_beside),
};
