/* SPDX-License-Identifier: BSD-3-Clause */
/* Curvature of interfaces, pair by pair (curvature.c). */
#ifndef SIM_TERMS_CURVATURE_H
#define SIM_TERMS_CURVATURE_H

#include "sim/solve/solve.h"
#include "sim/terms/interface_normal.h"
#include <math.h>

/* What the curvature that was found at a particle counts for, below 0 where three fluids meet, and a curvature on its way from one mean to the next. In room
 * that is free until forces are found: of the solver, or of accelerations. */
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

/* Both sums of a mean. */
typedef struct Mean {
    double above, below;
} Mean;

INLINE Mean mean_of_own(const Particles *s, const Model *model, size_t i, double at_zero, const double *kappa)
{
    const double below = at_zero * particles_volume(s, model, i) * fabs(curvature_weights(s)[i]);
    return (Mean){below * kappa[i], below};
}

/* What eight neighbours add. Of another fluid only those count that see no third one: their surface is not the same. */
INLINE void add_to_mean(Mean *mean, const Particles *s, const uint32_t *j, const double W[LANES], const double V[LANES],
                        const double other[LANES], const double *kappa)
{
    const double *weight = curvature_weights(s);
    for (int l = 0; l < LANES; l++) {
        const double w = weight[j[l]], counts = other[l] > 0 ? fmax(w, 0) : fabs(w), c = W[l] * V[l] * counts;
        mean->below += c;
        mean->above += c * (1 - 2 * other[l]) * kappa[j[l]];
    }
}

INLINE double mean_end(const Mean *mean)
{
    return mean->below > 0 ? mean->above / mean->below : 0;
}

#endif
