/* SPDX-License-Identifier: BSD-3-Clause */
/* How the particles of P1 lie, in one function, for particles among their own: these have no interface normal. */
#include "sim/fused.h"
#include "sim/terms/interface_normal.h"
#include "sim/terms/moments.h"
#include "sim/terms/terms.h"

INLINE void dissipation_shape_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    enum { NEEDS = NEED_W | NEED_F | NEED_STATE };
    uint32_t j[PICKED_MAX];
    _Alignas(64) double r[ROW_BLOCKS][LANES];
    double x[3];
    Lanes shepard = {0}, slope[3] = {0};
    Moments moments = {0};
    Block block, ahead[2];
    const Picked picked = pick_neighbours(plan, i, j);
    const double p = s->p[i * s->p_step];
    position_of(s, i, how, x);
    approach(ahead, 0, plan, &picked, j, x, how);
    for (size_t b = 0; b < picked.n; b++) {
        approach(ahead, b + 1, plan, &picked, j, x, how);
        fetch_rest(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            r[b][l] = pair.r;
            add_product(&shepard, l, pair.W, pair.V, how);
            gradient_pair(p, &pair, 1, how, l, slope);
            moments_pair(&moments, &pair, 1, how, l);
        }
    }
    note_reach(plan, i, &picked, r[0], LANES);
    s->shepard[i] = plan->at_zero * particles_volume(s, plan->model, i) + lanes_sum(&shepard);
    gradient_end(s, i, &moments, slope, plan->model->own_gradients > 0 ? least_moments(how) : 0, how);
    if (finds_normals(plan->model)) normal_none(s, i, how);
}
FUSED_FUNCTIONS(dissipation_shape_fused)

const Fusion dissipation_shape = {
    .terms = {&shepard_sum, &pressure_gradient},
    .also = {&interface_normal},
    .not_for = LIST_WALLS | LIST_OTHERS,
    .notes = true,
    .row = FUSED_TABLE(dissipation_shape_fused),
};
