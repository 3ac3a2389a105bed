/* SPDX-License-Identifier: BSD-3-Clause */
/* Transport velocity: particles are advected with v + w, where w comes from a constant background pressure and keeps them
 * evenly spread; where density is summed, the stress A = rho v (x) w accounts for the difference.            P3 eq. 11, 12
 *   b_i = -2 p_b / rho_i sum_j V_j grad_i W,   w_i = dt/2 b_i
 *   m_i dv_i/dt += sum_j V_i V_j (A_i + A_j) . grad_i W,   A = 0 where density is not summed, and in walls
 * A fluid of the other kind feels its neighbours' A too, so that the forces of a pair stay opposite. Fluids whose density
 * follows continuity are spread as well, without stress: nothing else closes the holes that open in a falling jet, as their
 * density does not know how far apart their particles are (schemes/riemann.md). */
#ifndef SIM_TERMS_TRANSPORT_H
#define SIM_TERMS_TRANSPORT_H

#include "sim/row.h"

/* Of sum_j V_j grad_i W, over fluid and walls. */
INLINE void background_pair(const Pair *pair, How how, int l, Lanes sum[3])
{
    add_along(pair, pair->V * pair->F, how, l, sum);
}

/* b_i, and the part of the stress that is the particle's own: rho_i v_i (w_i . sum_j V_j grad_i W). */
INLINE void background_end(Particles *s, const Model *model, size_t i, const Lanes sums[3], How how)
{
    const Phase *phase = &model->phase[s->phase[i]];
    const double half = 0.5 * model->dt, scale = -2 * phase->p_b / s->rho[i];
    double along_w = 0;
    for (int d = 0; d < how.dim; d++) {
        const double sum = lanes_sum(&sums[d]);
        along_w += half * s->b[d][i] * sum; /* w of this step, of the last one's b */
        s->b[d][i] = scale * sum;
    }
    if (!model->transport_stress || !phase->summation) return;
    const double share = particles_volume(s, model, i) * s->rho[i] / s->m[i];
    for (int d = 0; d < how.dim; d++) s->a[d][i] += share * s->v[d][i * s->v_step] * along_w;
}

/* Of sum_j m_j v_j (w_j . grad_i W), over neighbours of summed density: of others q is 0. */
INLINE void transport_stress_pair(const Pair *pair, How how, int l, Lanes sum[3])
{
    const double c = pair->F * DOT(pair->q, pair->x, how);
    for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, c, pair->v[d], how);
}

INLINE void transport_stress_end(Particles *s, const Model *model, size_t i, const Lanes sum[3], How how)
{
    const double scale = particles_volume(s, model, i) / s->m[i];
    for (int d = 0; d < how.dim; d++) s->a[d][i] += scale * lanes_sum(&sum[d]);
}

#endif
