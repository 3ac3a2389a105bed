/* SPDX-License-Identifier: BSD-3-Clause */
/* A fluid that fills what room there is, pair by pair: what its pairs dissipate, and what keeps it from tearing (gas.c). */
#ifndef SIM_TERMS_GAS_H
#define SIM_TERMS_GAS_H

#include "sim/terms/push.h"

/* Of sums of W V. In a gas that a splash stirs they are at most 1.06. */
static const double CROWDED = 1.25;

/* How much closing pairs of a particle of this fluid resist, by the fluid of the other. */
INLINE void resistances(const Model *model, unsigned fluid, double ret[MNS_MAX_FLUIDS])
{
    for (size_t k = 0; k < model->n_phases; k++) ret[k] = fmax(model->phase[k].resists, model->phase[fluid].resists);
}

/* What a fluid that fills leaves out of each pair: twice its own P where it is below zero, so that only differences are left. Elsewhere 0. */
INLINE double gas_lift(const Model *model, unsigned fluid, const Pushed *a)
{
    return model->phase[fluid].fills && !model->corrects_gradients && a->P < 0 ? -2 * a->P : 0;
}

/* Of sum_j V_i V_j (resists 2 z_i z_j/(z_i + z_j) dU + lift) grad_i W. The first is symmetric in the two, so that forces are opposite to the last
 * bit. */
INLINE void gas_pair(const Pushed *a, const double v[3], double lift, const Pair *pair, double resists, double tiny,
                     How how, int l, Lanes sum[3])
{
    const double closing = positive(-DOT_DIFFERENCE(v, pair->v, pair->x, how)) / (pair->r + tiny);
    const double z = a->z * pair->z / (a->z + pair->z);
    add_along(pair, a->V * pair->V * (2 * resists * z * closing + lift) * pair->F, how, l, sum);
}

INLINE void gas_wall(const Pushed *a, double lift, const Pair *pair, How how, int l, Lanes sum[3])
{
    add_along(pair, a->V * pair->V * lift * pair->F, how, l, sum);
}

/* d rho_i/dt += rho_i c/h max(0, Gamma_i - 1.25) of a fluid that fills. */
INLINE void gas_end(Particles *s, const Model *model, size_t i)
{
    const Phase *fluid = &model->phase[s->phase[i]];
    const double over = s->shepard[i] - CROWDED;
    if (fluid->fills && over > 0) s->rate[i] += s->rho[i] * over * fluid->c / model->kernel.h;
}

/* What keeps 0/0 away [m]. */
INLINE double gas_tiny(const Model *model)
{
    return 1e-12 * model->dx;
}

#endif
