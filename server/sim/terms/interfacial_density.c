/* SPDX-License-Identifier: BSD-3-Clause */
/* Density of P2, and how particles lie, in one function, for particles among their own. */
#include "sim/fused.h"
#include "sim/terms/continuity.h"
#include "sim/terms/jump.h"
#include "sim/terms/push.h"
#include "sim/terms/terms.h"

/* jumps: beside another fluid, with tension. */
INLINE void density_of(const RowPlan *plan, Particles *s, size_t i, How how, bool jumps)
{
    enum { NEEDS = NEED_W | NEED_F | NEED_BEND | NEED_V | NEED_STATE | NEED_GRADIENT };
    uint32_t j[PICKED_MAX];
    _Alignas(64) double r[ROW_BLOCKS][LANES];
    double x[3];
    Lanes shepard = {0}, crowd[3] = {0}, flow = {0}, dissipated = {0};
    Block block, ahead[2];
    const Model *model = plan->model;
    const Picked picked = pick_neighbours(plan, i, j);
    const Flowing a = flowing_of(s, model, i);
    const Jump jump = jumps ? jump_of(s, model, i, 1) : NO_JUMP;
    position_of(s, i, how, x);
    approach(ahead, 0, plan, &picked, j, x, how);
    for (size_t b = 0; b < picked.n; b++) {
        approach(ahead, b + 1, plan, &picked, j, x, how);
        double lacks[LANES];
        if (jumps) jumps_of(&jump, s, j + b * LANES, lacks);
        fetch_rest(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            if (jumps) pair.jump = lacks[l];
            const double inverse = flowing_inverse(&a, &pair);
            r[b][l] = pair.r;
            add_product(&shepard, l, pair.W, pair.V, how);
            add_along(&pair, pair.V * pair.F, how, l, crowd);
            volume_continuity_pair(&a, model, &pair, inverse, how, l, &flow);
            dissipation_pair(&a, &pair, inverse, how, l, &dissipated);
        }
    }
    note_reach(plan, i, &picked, r[0], LANES);
    s->shepard[i] = plan->at_zero * particles_volume(s, plan->model, i) + lanes_sum(&shepard);
    for (int d = 0; d < how.dim; d++) s->concentration[d][i] = lanes_sum(&crowd[d]);
    volume_continuity_end(s, i, &flow);
    dissipation_end(s, model, i, &dissipated);
}

INLINE void interfacial_density_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    density_of(plan, s, i, how, false);
}
FUSED_FUNCTIONS(interfacial_density_fused)

INLINE void jumping_density_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    density_of(plan, s, i, how, true);
}
FUSED_FUNCTIONS(jumping_density_fused)

static bool is_slack(const Model *model)
{
    return !model->tense;
}

/* Away from walls: where no pressure jumps, as there is no tension or no other fluid, and where some do. */
#define DENSITY(besides, when, body)                                                                                   \
    {                                                                                                                  \
        .terms = {&shepard_sum, &concentration, &volume_continuity, &density_dissipation},                             \
        .not_for = LIST_WALLS | (besides), .needed = when, .notes = true, .row = FUSED_TABLE(body),                    \
    }
const Fusion interfacial_density = DENSITY(0, is_slack, interfacial_density_fused);
const Fusion interfacial_density_within = DENSITY(LIST_OTHERS, is_tense, interfacial_density_fused);
const Fusion interfacial_density_across = DENSITY(0, is_tense, jumping_density_fused);
