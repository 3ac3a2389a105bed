/* SPDX-License-Identifier: BSD-3-Clause */
/* Forces, shifting and the gradient for the next step's dissipation of P2 in one function, for particles among their own. */
#include "sim/fused.h"
#include "sim/terms/moments.h"
#include "sim/terms/push.h"
#include "sim/terms/terms.h"
#include "sim/terms/viscosity.h"

INLINE void interfacial_forces_of(const RowPlan *plan, Particles *s, size_t i, How how, bool viscous)
{
    enum { NEEDS = NEED_F | NEED_V | NEED_STATE | NEED_SHEPARD };
    uint32_t j[PICKED_MAX];
    double x[3];
    ShiftingSums carried = {0};
    Lanes push[3] = {0}, drag[3] = {0}, slope[3] = {0};
    Moments moments = {0};
    Block block, ahead[2];
    const Model *model = plan->model;
    const Picked picked = pick_neighbours(plan, i, j);
    const Pushed a = pushed_of(s, model, i);
    const Shifted c = shifted_of(s, model, i);
    const double mu = radial_viscosity_of(model, s->phase[i], s->phase[i]);
    const double p = s->p[i * s->p_step];
    position_of(s, i, how, x);
    approach(ahead, 0, plan, &picked, j, x, how);
    for (size_t b = 0; b < picked.n; b++) {
        approach(ahead, b + 1, plan, &picked, j, x, how);
        fetch_rest(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            pressure_pair(&a, model, &pair, false, 0, how, l, push, WEIGHTS_SQUARES);
            if (viscous) drag_pair(c.v, a.V, &pair, mu, how, l, drag);
            gradient_pair(p, &pair, 1, how, l, slope);
            moments_pair(&moments, &pair, 1, how, l);
            shifting_pair(&c, &pair, 1, 1, how, l, &carried);
        }
    }
    pressure_end(s, i, push, how);
    if (viscous) viscosity_end(s, i, drag, how);
    gradient_end(s, i, &moments, slope, model->own_gradients > 0 ? least_moments(how) : 0, how);
    shifting_end(&c, s, model, i, &carried, how);
}

INLINE void viscous_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    interfacial_forces_of(plan, s, i, how, true);
}
FUSED_FUNCTIONS(viscous_fused)

INLINE void inviscid_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    interfacial_forces_of(plan, s, i, how, false);
}
FUSED_FUNCTIONS(inviscid_fused)

const Fusion interfacial_viscous_forces = {
    .terms = {&volume_pressure_force, &radial_viscosity, &pressure_gradient, &shifting},
    .not_for = LIST_WALLS | LIST_OTHERS,
    .row = FUSED_TABLE(viscous_fused),
};

const Fusion interfacial_forces = {
    .terms = {&volume_pressure_force, &pressure_gradient, &shifting},
    .not_for = LIST_WALLS | LIST_OTHERS,
    .row = FUSED_TABLE(inviscid_fused),
};
