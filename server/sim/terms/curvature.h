/* SPDX-License-Identifier: BSD-3-Clause */
/* Curvature of interfaces, pair by pair (curvature.c). */
#ifndef SIM_TERMS_CURVATURE_H
#define SIM_TERMS_CURVATURE_H

#include "sim/solve/solve.h"
#include "sim/terms/interface_normal.h"
#include <math.h>

/* What the curvature that was found at a particle counts for, its volume in it but under P5, below 0 where three fluids meet, and a curvature on its way from one mean to
 * the next. In room that is free until forces are found: of the solver, or of accelerations. */
INLINE double *curvature_weights(const Particles *s)
{
    return s->system ? s->system->work[0] : s->a[0];
}

INLINE double *curvature_step(const Particles *s)
{
    return s->system ? s->system->work[1] : s->a[1];
}

/* What a mean leaves of a wave, S, and two of differences is S^3; 4 - 3 S gives it back to second order. */
static const double SHARPNESS = 3;

/* n_j as seen from i, less n_i, along direction d; 0 where j does not count. */
INLINE double turned(const Pair *pair, double other, const double n[3], double counts, int d)
{
    return counts * ((1 - 2 * other) * pair->normal[d] - n[d]);
}

/* Of sum_j e (x) grad_i W V_j, of which the trace of M' times it is the curvature; counts: 1 or 0. */
INLINE void curvature_pair(const double n[3], const Pair *pair, double other, double counts, How how, int l,
                           Lanes sum[3][3])
{
    const double c = pair->V * pair->F;
    for (int k = 0; k < how.dim; k++) {
        const double e = c * turned(pair, other, n, counts, k);
        for (int d = 0; d < how.dim; d++) add_product(&sum[k][d], l, e, pair->x[d], how);
    }
}

/* What a curvature counts for in means: the sharper the colour changes where it was found, the more. */
INLINE double weight_of_interface(const Model *model, const double q[3], How how)
{
    const double size2 = model->dx * model->dx * DOT(q, q, how);
    return size2 * size2;
}

/* Fluids of which eight neighbours within reach are, a bit each. */
INLINE unsigned fluids_in_reach(const Particles *s, const uint32_t *j, const double F[LANES])
{
    unsigned found = 0;
    for (int l = 0; l < LANES; l++)
        if (F[l] < 0) found |= 1u << s->phase[j[l]];
    return found;
}

/* Does a particle see two fluids besides its own? */
INLINE bool are_two_others(unsigned fluids, unsigned mine)
{
    const unsigned others = fluids & ~(1u << mine);
    return others & (others - 1);
}

/* Both sums of a mean. */
typedef struct Mean {
    Lanes above, below;
} Mean;

/* What curvatures of eight neighbours count for in the mean of another, and they themselves as seen from there, by both. Of another fluid only those count
 * that see no third one: their surface is not the same. */
INLINE void weigh_curvatures(const double *weights, const double *kappa, const uint32_t *j, const double other[LANES],
                             double ret_weight[LANES], double ret_both[LANES])
{
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        const double w = weights[j[l]], counts = other[l] > 0 ? (w > 0 ? w : 0) : fabs(w);
        ret_weight[l] = counts;
        ret_both[l] = counts * (1 - 2 * other[l]) * kappa[j[l]];
    }
}

INLINE void mean_pair(const Pair *pair, double weight, double both, How how, int l, Mean *mean)
{
    add_product(&mean->below, l, pair->W, weight, how);
    add_product(&mean->above, l, pair->W, both, how);
}

INLINE double mean_end(const Mean *mean, const Particles *s, size_t i, double at_zero, const double *kappa)
{
    const double own = at_zero * fabs(curvature_weights(s)[i]), below = own + lanes_sum(&mean->below),
                 above = own * kappa[i] + lanes_sum(&mean->above);
    return below > 0 ? above / below : 0;
}

#endif
