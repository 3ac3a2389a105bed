/* SPDX-License-Identifier: BSD-3-Clause */
/* Transport velocity: particles are advected with v + w, where w comes from a constant background pressure and keeps them
 * evenly spread; what they find by being elsewhere than their material accounts for the difference.          P3 eq. 11, 12
 *   b_i = -2 p_b / rho_i sum_j V_j grad_i W,   w_i = dt/2 b_i
 *   dv_i/dt += (w . grad v)_i = sum_j V_j (v_j - v_i) (w_i . grad_i W),   over fluid
 * P3 prints sum_j V_i V_j (A_i + A_j) . grad_i W, A = rho v (x) w. Of div(rho v w) that has v div(rho w) too, whose own part is a drag against the
 * frame, -dt p_b/rho |sum_j V_j grad_i W|^2 v_i, that grows with refinement: a lid's cavity is 7 to 8 % too slow by it. All fluids that are spread have
 * it, also those whose density follows continuity: nothing else closes the holes that open in a falling jet, as their
 * density does not know how far apart their particles are (schemes/riemann.md). */
#ifndef SIM_TERMS_TRANSPORT_H
#define SIM_TERMS_TRANSPORT_H

#include "sim/row.h"

/* Of sum_j V_j grad_i W, over fluid and walls. */
INLINE void background_pair(const Pair *pair, How how, int l, Lanes sum[3])
{
    add_along(pair, pair->V * pair->F, how, l, sum);
}

INLINE void background_end(Particles *s, const Model *model, size_t i, const Lanes sums[3], How how)
{
    const double scale = -2 * model->phase[s->phase[i]].p_b / s->rho[i];
    for (int d = 0; d < how.dim; d++) s->b[d][i] = scale * lanes_sum(&sums[d]);
}

/* A particle, and w of this step, of the last one's b. */
typedef struct Moved {
    double v[3], w[3];
} Moved;

INLINE Moved moved_of(const Particles *s, const Model *model, size_t i, How how)
{
    Moved a;
    for (int d = 0; d < how.dim; d++) {
        a.v[d] = s->v[d][i * s->v_step];
        a.w[d] = 0.5 * model->dt * s->b[d][i];
    }
    return a;
}

/* other: 1 of another fluid, which may glide along this one: what it does at an interface is no gradient. */
INLINE void transport_stress_pair(const Moved *a, const Pair *pair, double other, How how, int l, Lanes sum[3])
{
    const double c = (1 - other) * pair->V * pair->F * DOT(a->w, pair->x, how);
    for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, c, pair->v[d] - a->v[d], how);
}

INLINE void transport_stress_end(Particles *s, size_t i, const Lanes sum[3], How how)
{
    for (int d = 0; d < how.dim; d++) s->a[d][i] += lanes_sum(&sum[d]);
}

#endif
