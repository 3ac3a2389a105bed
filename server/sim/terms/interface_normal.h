/* SPDX-License-Identifier: BSD-3-Clause */
/* Interface normals, pair by pair (interface_normal.c). */
#ifndef SIM_TERMS_INTERFACE_NORMAL_H
#define SIM_TERMS_INTERFACE_NORMAL_H

#include "sim/terms/moments.h"

static const Correction NO_CORRECTION = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/* The root of a square, apart from loops over pairs, so that tests/support/vectorised.sh finds only theirs. */
double magnitude_of(double square);

INLINE double magnitude(const double a[3], How how)
{
    return magnitude_of(DOT(a, a, how));
}

/* Of sum_j w_j grad_i W V_j over other fluids; weight: w_j, 0 for its own. */
INLINE void towards_pair(const Pair *pair, double weight, How how, int l, Lanes sum[3])
{
    add_along(pair, weight * pair->V * pair->F, how, l, sum);
}

/* Of unit length along q, corrected; none where that is too small. */
INLINE void normal_end(Particles *s, const Model *model, size_t i, const Correction *M, const Lanes sum[3], How how)
{
    double q[3];
    correct(M, sum, how, q);
    const double size = magnitude(q, how), inverse = size * model->kernel.h > 0.01 ? 1 / size : 0;
    for (int d = 0; d < how.dim; d++) s->normal[d][i * s->normal_step] = q[d] * inverse;
}

INLINE void normal_none(Particles *s, size_t i, How how)
{
    for (int d = 0; d < how.dim; d++) s->normal[d][i * s->normal_step] = 0;
}

#endif
