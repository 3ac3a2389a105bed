/* SPDX-License-Identifier: BSD-3-Clause */
/* Density by what flows together, and its dissipation, pair by pair (continuity.c, dissipation.c). */
#ifndef SIM_TERMS_CONTINUITY_H
#define SIM_TERMS_CONTINUITY_H

#include "sim/terms/average.h"
#include "sim/terms/midway.h"
#include <math.h>

/* What is fixed in the pairs of one particle. */
typedef struct Flowing {
    double v[3], p, z, lag;
    double descent[3]; /* minus its pressure gradient */
    double rest;       /* 1/2 if only what is left beside a linear field is dissipated, else 0         */
    double least;      /* of psi_ij (p_j + J_ij - p_i): 0 where a difference may not grow, else any     */
    double keeps, own; /* 1 and 0 where dissipation keeps the volume of a pair, else 0 and 1 / (2 z_i) */
} Flowing;

INLINE Flowing flowing_of(const Particles *s, const Model *model, size_t i)
{
    const bool rest = model->delta > 0 && model->dissipates_rest;
    Flowing a = {.p = s->p[i * s->p_step],
                 .z = particles_impedance(s, model, i),
                 .lag = model->lag,
                 .rest = rest ? 0.5 : 0,
                 .least = model->any_fills ? 0 : -HUGE_VAL,
                 .keeps = 1};
    if (!model->keeps_pair_volume) { /* as if both were of this fluid */
        a.keeps = 0;
        a.own = 0.5 / a.z;
    }
    for (int d = 0; d < s->dim; d++) {
        a.v[d] = s->v[d][i * s->v_step];
        if (rest) a.descent[d] = -s->gradient[d][i * s->gradient_step];
    }
    return a;
}

/* v_ij . grad_i W */
INLINE double compression(const Flowing *a, const Pair *pair, How how)
{
    return pair->F * DOT_DIFFERENCE(a->v, pair->v, pair->x, how);
}

/* What the two ways below share of a pair: 1 / (z_i + z_j). */
INLINE double flowing_inverse(const Flowing *a, const Pair *pair)
{
    return 1 / (a->z + pair->z);
}

/* Of sum_j V_j v_ij . grad_i W, and, midway, of the same without V_j. */
INLINE void continuity_pair(const Flowing *a, const Model *model, const Pair *pair, double inverse, How how, int l,
                            Lanes *sum)
{
    add_product(sum, l, pair->V * (1 + average_tilt(model, a->z, pair, inverse)), compression(a, pair, how), how);
}

INLINE void volume_continuity_pair(const Flowing *a, const Model *model, const Pair *pair, double inverse, How how,
                                   int l, Lanes *sum)
{
    add_product(sum, l, 1 + average_tilt(model, a->z, pair, inverse), compression_midway(a->v, pair, a->lag, how), how);
}

/* The same with walls, which count as the fluid that meets them. */
INLINE void continuity_wall(const Flowing *a, const Pair *pair, How how, int l, Lanes *sum)
{
    add_product(sum, l, pair->V, compression(a, pair, how), how);
}

INLINE void volume_continuity_wall(const Flowing *a, const Pair *pair, How how, int l, Lanes *sum)
{
    add_product(sum, l, 1, compression_midway(a->v, pair, a->lag, how), how);
}

INLINE void continuity_end(Particles *s, size_t i, const Lanes *sum)
{
    s->rate[i] = s->rho[i] * lanes_sum(sum);
}

INLINE void volume_continuity_end(Particles *s, size_t i, const Lanes *sum)
{
    s->rate[i] = s->m[i] / s->shepard[i] * lanes_sum(sum);
}

/* Of sum_j psi_ij r F V_j / (z_i + z_j). */
INLINE void dissipation_pair(const Flowing *a, const Pair *pair, double inverse, How how, int l, Lanes *sum)
{
    const double linear = DOT_DIFFERENCE(pair->gradient, a->descent, pair->x, how);
    const double dp = pair->p + pair->jump - a->p, left = mul_add(a->rest, linear, dp, how.fma);
    const double psi = left * dp < a->least ? 0 : left;
    add_product(sum, l, pair->V * pair->F * pair->r * psi, mul_add(a->keeps, inverse, a->own, how.fma), how);
}

INLINE void dissipation_end(Particles *s, const Model *model, size_t i, const Lanes *sum)
{
    s->rate[i] -= 2 * model->delta * s->rho[i] * lanes_sum(sum);
}

#endif
