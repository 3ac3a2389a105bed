/* SPDX-License-Identifier: BSD-3-Clause */
/* All rates of P1 in one function, for particles among their own. */
#include "sim/fused.h"
#include "sim/terms/continuity.h"
#include "sim/terms/gas.h"
#include "sim/terms/terms.h"
#include "sim/terms/viscosity.h"

/* gas: all pairs dissipate, as they do of a gas. */
INLINE void dissipation_rates_of(const RowPlan *plan, Particles *s, size_t i, How how, bool viscous, bool gas)
{
    enum { NEEDS = NEED_F | NEED_V | NEED_STATE | NEED_SHEPARD | NEED_GRADIENT };
    uint32_t j[PICKED_MAX];
    double x[3];
    Lanes flow = {0}, dissipated = {0}, push[3] = {0}, drag[3] = {0}, damping[3] = {0};
    Block block, ahead[2];
    const Model *model = plan->model;
    const Picked picked = pick_neighbours(plan, i, j);
    const Flowing a = flowing_of(s, model, i);
    const Pushed c = pushed_of(s, model, i);
    const double mu = radial_viscosity_of(model, s->phase[i], s->phase[i]), tiny = gas_tiny(model),
                 resists = model->phase[s->phase[i]].resists, lift = gas ? gas_lift(model, s->phase[i], &c) : 0;
    position_of(s, i, how, x);
    approach(ahead, 0, plan, &picked, j, x, how);
    for (size_t b = 0; b < picked.n; b++) {
        approach(ahead, b + 1, plan, &picked, j, x, how);
        fetch_rest(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            const double inverse = flowing_inverse(&a, &pair);
            continuity_pair(&a, model, &pair, inverse, how, l, &flow);
            dissipation_pair(&a, &pair, inverse, how, l, &dissipated);
            pressure_pair(&c, model, &pair, false, 0, how, l, push, WEIGHTS_PRODUCT);
            if (viscous) drag_pair(a.v, c.V, &pair, mu, how, l, drag);
            if (gas) gas_pair(&c, a.v, lift, &pair, resists, tiny, how, l, damping);
        }
    }
    continuity_end(s, i, &flow);
    dissipation_end(s, model, i, &dissipated);
    pressure_end(s, i, push, how);
    if (viscous) viscosity_end(s, i, drag, how);
    if (gas) pressure_end(s, i, damping, how);
    if (gas) gas_end(s, model, i);
}

INLINE void viscous_rates_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    dissipation_rates_of(plan, s, i, how, true, false);
}
FUSED_FUNCTIONS(viscous_rates_fused)

INLINE void inviscid_rates_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    dissipation_rates_of(plan, s, i, how, false, false);
}
FUSED_FUNCTIONS(inviscid_rates_fused)

/* Of a case with a gas or a light liquid: most of its particles. */
INLINE void gas_rates_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    if (plan->model->phase[s->phase[i]].fills) dissipation_rates_of(plan, s, i, how, true, true);
    else dissipation_rates_of(plan, s, i, how, true, false);
}
FUSED_FUNCTIONS(gas_rates_fused)

const Fusion dissipation_viscous_rates = {
    .terms = {&continuity, &density_dissipation, &pressure_force, &radial_viscosity},
    .not_for = LIST_WALLS | LIST_OTHERS,
    .row = FUSED_TABLE(viscous_rates_fused),
};

const Fusion dissipation_rates = {
    .terms = {&continuity, &density_dissipation, &pressure_force},
    .not_for = LIST_WALLS | LIST_OTHERS,
    .row = FUSED_TABLE(inviscid_rates_fused),
};

const Fusion dissipation_gas_rates = {
    .terms = {&continuity, &density_dissipation, &pressure_force, &gas_dissipation},
    .also = {&radial_viscosity},
    .not_for = LIST_WALLS | LIST_OTHERS,
    .row = FUSED_TABLE(gas_rates_fused),
};
