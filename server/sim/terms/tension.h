/* SPDX-License-Identifier: BSD-3-Clause */
/* Interface normals and surface tension, pair by pair (tension.c). */
#ifndef SIM_TERMS_TENSION_H
#define SIM_TERMS_TENSION_H

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

/* What pulls a particle: nothing if it has no normal. */
typedef struct Pulled {
    double n[3];                   /* its normal */
    double weight[MNS_MAX_FLUIDS]; /* of neighbours of each fluid, 0 for its own */
    bool any;
} Pulled;

INLINE Pulled pulled_of(const Particles *s, const Model *model, size_t i, bool mixed, How how)
{
    Pulled a;
    const unsigned mine = s->phase[i];
    const double rho0 = model->phase[mine].rho0;
    for (int d = 0; d < how.dim; d++) a.n[d] = s->normal[d][i * s->normal_step];
    for (size_t k = 0; k < model->n_phases; k++)
        a.weight[k] = k == mine ? 0 : model->tension[mine][k] * 2 * rho0 / (rho0 + model->phase[k].rho0);
    a.any = mixed && magnitude(a.n, how) > 0.5;
    return a;
}

/* n_j as seen from i, less n_i, along direction d; 0 where j has none. */
INLINE double turned(const Pair *pair, double other, const double n[3], double valid, int d)
{
    return valid * ((1 - 2 * other) * pair->normal[d] - n[d]);
}

/* Of both sums of P1 eq. 14. */
INLINE void curvature_pair(const Pulled *a, const Pair *pair, double other, How how, int l, Lanes *above, Lanes *below)
{
    const double valid = has_normal(pair, how), c = pair->V * pair->F;
    for (int d = 0; d < how.dim; d++) add_product(above, l, c * turned(pair, other, a->n, valid, d), pair->x[d], how);
    add_product(below, l, -valid * c, pair->r * pair->r, how);
}

INLINE double curvature_end(const Lanes *above, const Lanes *below, How how)
{
    const double all = lanes_sum(below);
    return all > 0 ? how.dim * lanes_sum(above) / all : 0;
}

/* P2 eq. 36: of sum_j e (x) grad_i W V_j, of which the trace of M times it is the curvature. */
INLINE void corrected_curvature_pair(const Pulled *a, const Pair *pair, double other, How how, int l, Lanes sum[3][3])
{
    const double valid = has_normal(pair, how), c = pair->V * pair->F;
    for (int k = 0; k < how.dim; k++) {
        const double e = c * turned(pair, other, a->n, valid, k);
        for (int d = 0; d < how.dim; d++) add_product(&sum[k][d], l, e, pair->x[d], how);
    }
}

INLINE void pull_end(Particles *s, size_t i, const Pulled *a, double kappa, const Correction *M, const Lanes towards[3],
                     How how)
{
    double force[3];
    correct(M, towards, how, force);
    const double scale = -kappa * magnitude(force, how) / s->rho[i];
    for (int d = 0; d < how.dim; d++) s->a[d][i] += scale * a->n[d];
}

#endif
