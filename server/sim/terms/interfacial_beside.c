/* SPDX-License-Identifier: BSD-3-Clause */
/* Forces, shifting and the gradient of P2 for viscous particles beside walls or another fluid. */
#include "sim/fused.h"
#include "sim/terms/jump.h"
#include "sim/terms/moments.h"
#include "sim/terms/push.h"
#include "sim/terms/terms.h"
#include "sim/terms/viscosity.h"

INLINE void forces_beside(const RowPlan *plan, Particles *s, size_t i, How how)
{
    enum { WALL_NEEDS = NEED_F | NEED_V | NEED_STATE, NEEDS = WALL_NEEDS | NEED_SHEPARD };
    double x[3], mu[MNS_MAX_FLUIDS], like[MNS_MAX_FLUIDS];
    ShiftingSums carried = {0};
    Lanes push[3] = {0}, drag[3] = {0}, friction[3] = {0}, slope[3] = {0};
    Block block, ahead[2];
    uint32_t j[PICKED_MAX];
    Marks other;
    Moments moments = {0};
    const Model *model = plan->model;
    const Picked picked = pick_neighbours(plan, i, j);
    const bool mixed = mark_others(plan, i, j, &picked, &other), jumps = mixed && model->tense;
    const double own_only = mixed && model->shifts_along_interfaces ? 1 : 0, own = model->own_gradients;
    const Jump jump = jumps ? jump_of(s, model, i, 1) : NO_JUMP;
    const Pushed a = pushed_of(s, model, i);
    const WallPressure shown = wall_pressure_of(s, i);
    const Shifted c = shifted_of(s, model, i);
    const double beta = model->repulsion, p = s->p[i * s->p_step];
    radial_viscosities_of(model, s->phase[i], mu);
    likenesses(model, s->phase[i], like);
    position_of(s, i, how, x);
    approach(ahead, 0, plan, &picked, j, x, how);
    for (size_t b = 0; b < picked.n_fluid; b++) {
        approach(ahead, b + 1, plan, &picked, j, x, how);
        const double *others = other.of[b];
        double against[LANES], alike[LANES], lacks[LANES] = {0};
        if (jumps) jumps_of(&jump, s, j + b * LANES, lacks);
        by_fluid(s, j + b * LANES, mu, against);
        by_fluid(s, j + b * LANES, like, alike);
        fetch_rest(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            const double of_own = 1 - own * others[l];
            pair.jump = lacks[l];
            pressure_pair(&a, model, &pair, true, beta * others[l], how, l, push, WEIGHTS_SQUARES);
            drag_pair(c.v, a.V, &pair, against[l], how, l, drag);
            gradient_pair(p, &pair, of_own, how, l, slope);
            moments_pair(&moments, &pair, of_own, how, l);
            shifting_pair(&c, &pair, 1 - own_only * others[l], alike[l], how, l, &carried);
        }
    }
    for (size_t b = picked.n_fluid; b < picked.n; b++) {
        const uint32_t *wall = j + b * LANES;
        approach(ahead, b + 1, plan, &picked, j, x, how);
        Sticking sticking;
        sticking_of(s, model, wall, mu[s->phase[i]], how, &sticking);
        fetch_rest(&block, wall, &plan->nb->bundles, WALL_NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, WALL_NEEDS, how);
            pressure_wall(&a, &pair, shown_by(&shown, wall[l]), how, l, push, WEIGHTS_SQUARES);
            radial_friction_pair(c.v, a.V, &pair, &sticking, how, l, friction);
        }
    }
    pressure_end(s, i, push, how);
    viscosity_end(s, i, drag, how);
    if (picked.walls) viscosity_end(s, i, friction, how);
    gradient_end(s, i, &moments, slope, own > 0 ? least_moments(how) : 0, how);
    shifting_end(&c, s, model, i, &carried, how);
}
BESIDE_FUNCTIONS(forces_beside)

const Fusion interfacial_forces_beside = {
    .terms = {&volume_pressure_force, &radial_viscosity, &pressure_gradient, &shifting},
    .also = {&radial_friction},
    .row = BESIDE_TABLE(forces_beside),
};
