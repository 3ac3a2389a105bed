/* SPDX-License-Identifier: BSD-3-Clause */
/* The sums of P1 for viscous particles beside walls or another fluid: how they lie, and all rates. */
#include "sim/fused.h"
#include "sim/terms/continuity.h"
#include "sim/terms/gas.h"
#include "sim/terms/interface_normal.h"
#include "sim/terms/jump.h"
#include "sim/terms/moments.h"
#include "sim/terms/terms.h"
#include "sim/terms/viscosity.h"

INLINE void shape_beside(const RowPlan *plan, Particles *s, size_t i, How how)
{
    enum { NEEDS = NEED_W | NEED_F | NEED_STATE };
    uint32_t j[PICKED_MAX];
    _Alignas(64) double r[ROW_BLOCKS][LANES];
    double x[3];
    Lanes shepard = {0}, slope[3] = {0}, towards[3] = {0};
    Moments moments = {0};
    Block block, ahead[2];
    Marks other;
    const Picked picked = pick_neighbours(plan, i, j);
    const bool mixed = mark_others(plan, i, j, &picked, &other);
    const double p = s->p[i * s->p_step], own = plan->model->own_gradients;
    position_of(s, i, how, x);
    approach(ahead, 0, plan, &picked, j, x, how);
    for (size_t b = 0; b < picked.n_fluid; b++) {
        approach(ahead, b + 1, plan, &picked, j, x, how);
        const double *others = other.of[b];
        fetch_rest(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            r[b][l] = pair.r;
            add_product(&shepard, l, pair.W, pair.V, how);
            const double counts = 1 - own * others[l];
            gradient_pair(p, &pair, counts, how, l, slope);
            moments_pair(&moments, &pair, counts, how, l);
            towards_pair(&pair, others[l], how, l, towards);
        }
    }
    for (size_t b = picked.n_fluid; b < picked.n; b++) {
        approach(ahead, b + 1, plan, &picked, j, x, how);
        fetch_rest(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            r[b][l] = pair.r;
            add_product(&shepard, l, pair.W, pair.V, how);
        }
    }
    note_reach(plan, i, &picked, r[0], LANES);
    s->shepard[i] = plan->at_zero * particles_volume(s, plan->model, i) + lanes_sum(&shepard);
    gradient_end(s, i, &moments, slope, own > 0 ? least_moments(how) : 0, how);
    if (!finds_normals(plan->model)) return;
    if (mixed) normal_end(s, plan->model, i, &NO_CORRECTION, towards, how);
    else normal_none(s, i, how);
}
BESIDE_FUNCTIONS(shape_beside)

INLINE void rates_beside_of(const RowPlan *plan, Particles *s, size_t i, How how, bool viscous, bool gas)
{
    enum { WALL_NEEDS = NEED_F | NEED_V | NEED_STATE, NEEDS = WALL_NEEDS | NEED_SHEPARD | NEED_GRADIENT };
    uint32_t j[PICKED_MAX];
    double x[3], mu[MNS_MAX_FLUIDS], resists[MNS_MAX_FLUIDS];
    Lanes flow = {0}, dissipated = {0}, push[3] = {0}, drag[3] = {0}, friction[3] = {0}, damping[3] = {0};
    Block block, ahead[2];
    Marks other;
    const Model *model = plan->model;
    const Picked picked = pick_neighbours(plan, i, j);
    const bool jumps = mark_others(plan, i, j, &picked, &other) && model->tense;
    const Jump jump = jumps ? jump_of(s, model, i, 1) : NO_JUMP;
    const Flowing a = flowing_of(s, model, i);
    const Pushed c = pushed_of(s, model, i);
    const WallPressure shown = wall_pressure_of(s, i);
    const double beta = model->repulsion, tiny = gas_tiny(model), lift = gas ? gas_lift(model, s->phase[i], &c) : 0;
    radial_viscosities_of(model, s->phase[i], mu);
    resistances(model, s->phase[i], resists);
    position_of(s, i, how, x);
    approach(ahead, 0, plan, &picked, j, x, how);
    for (size_t b = 0; b < picked.n_fluid; b++) {
        approach(ahead, b + 1, plan, &picked, j, x, how);
        const double *others = other.of[b];
        double against[LANES], resisting[LANES], lacks[LANES] = {0};
        by_fluid(s, j + b * LANES, mu, against);
        if (jumps) jumps_of(&jump, s, j + b * LANES, lacks);
        if (gas) by_fluid(s, j + b * LANES, resists, resisting);
        fetch_rest(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            const double inverse = flowing_inverse(&a, &pair);
            pair.jump = lacks[l];
            continuity_pair(&a, model, &pair, inverse, how, l, &flow);
            dissipation_pair(&a, &pair, inverse, how, l, &dissipated);
            pressure_pair(&c, model, &pair, true, beta * others[l], how, l, push, WEIGHTS_PRODUCT);
            if (viscous) drag_pair(a.v, c.V, &pair, against[l], how, l, drag);
            if (gas) gas_pair(&c, a.v, lift, &pair, resisting[l], tiny, how, l, damping);
        }
    }
    for (size_t b = picked.n_fluid; b < picked.n; b++) {
        const uint32_t *wall = j + b * LANES;
        approach(ahead, b + 1, plan, &picked, j, x, how);
        Sticking sticking;
        if (viscous) sticking_of(s, model, wall, mu[s->phase[i]], how, &sticking);
        fetch_rest(&block, wall, &plan->nb->bundles, WALL_NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, WALL_NEEDS, how);
            continuity_wall(&a, &pair, how, l, &flow);
            pressure_wall(&c, &pair, shown_by(&shown, wall[l]), how, l, push, WEIGHTS_PRODUCT);
            if (gas) gas_wall(&c, lift, &pair, how, l, damping);
            if (viscous) radial_friction_pair(a.v, c.V, &pair, &sticking, how, l, friction);
        }
    }
    continuity_end(s, i, &flow);
    dissipation_end(s, model, i, &dissipated);
    pressure_end(s, i, push, how);
    if (viscous) viscosity_end(s, i, drag, how);
    if (gas) pressure_end(s, i, damping, how);
    if (gas) gas_end(s, model, i);
    if (viscous && picked.walls) viscosity_end(s, i, friction, how);
}

INLINE void rates_beside(const RowPlan *plan, Particles *s, size_t i, How how)
{
    rates_beside_of(plan, s, i, how, true, false);
}
BESIDE_FUNCTIONS(rates_beside)

INLINE void gas_rates_beside(const RowPlan *plan, Particles *s, size_t i, How how)
{
    if (plan->model->viscous) rates_beside_of(plan, s, i, how, true, true);
    else rates_beside_of(plan, s, i, how, false, true);
}
BESIDE_FUNCTIONS(gas_rates_beside)

const Fusion dissipation_shape_beside = {
    .terms = {&shepard_sum, &pressure_gradient},
    .also = {&interface_normal},
    .not_together = LIST_WALLS | LIST_OTHERS, /* where walls mirror interfaces (images.c) */
    .notes = true,
    .row = BESIDE_TABLE(shape_beside),
};

const Fusion dissipation_rates_beside = {
    .terms = {&continuity, &density_dissipation, &pressure_force, &radial_viscosity},
    .also = {&radial_friction},
    .row = BESIDE_TABLE(rates_beside),
};

const Fusion dissipation_gas_rates_beside = {
    .terms = {&continuity, &density_dissipation, &pressure_force, &gas_dissipation},
    .also = {&radial_viscosity, &radial_friction},
    .row = BESIDE_TABLE(gas_rates_beside),
};
