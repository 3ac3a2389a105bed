/* SPDX-License-Identifier: BSD-3-Clause */
/* What of a pair's velocities P3's dissipation leaves alone: the part that is linear around both particles.
 *   D_i = sym(M_i sum_j V_j grad_i W (x) (v_j - v_i))   over its own fluid, M of it; 0 of a gas, and of a liquid that has one in
 *   reach: what is linear there closes bubbles, which then collapse into voids (dambreak2d: a sum of W V of 0.63, 0.69 without it)
 *   (v_i - v_j) . x_ij of that part: x_ij . (D_i + D_j)/2 . x_ij
 * D is symmetric in i and j, so forces stay opposite. Only what closes is dissipated, and of that never more than there is. */
#ifndef SIM_TERMS_STRAIN_H
#define SIM_TERMS_STRAIN_H

#include "sim/terms/moments.h"

/* Sums in single precision, as fifteen of doubles, which is how many there are in space, take twice the registers of AVX2. Differences are taken in doubles,
 * so that a flow's own speed costs no digits; and each particle's strain is one number for all its pairs, so that forces stay opposite to the last bit. */
typedef struct FloatLanes {
    float of[LANES];
} FloatLanes;

INLINE void add_float_product(FloatLanes *sum, int l, float a, float b, How how)
{
    sum->of[l] = how.fma ? __builtin_fmaf(a, b, sum->of[l]) : a * b + sum->of[l];
}

INLINE void widened(const FloatLanes *a, Lanes *ret)
{
    for (int l = 0; l < LANES; l++) ret->of[l] = (double)a->of[l];
}

/* Of sum_j V_j grad_i W (x) (x_i - x_j), as in Moments, and of sum_j V_j grad_i W (x) (v_i - v_j), by component of v. */
typedef struct StrainSums {
    FloatLanes moments[6], velocity[3][3];
} StrainSums;

/* v: of the particle; b: with distances; other: 1 for pairs that do not count, [LANES]. */
INLINE void strain_block(const double v[3], const Block *b, const double *other, How how, StrainSums *sums)
{
    FloatLanes *const m = sums->moments;
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        const float weight = (float)((1 - other[l]) * b->V[l] * b->F[l]);
        const float x = (float)b->x[0][l], y = (float)b->x[1][l], z = how.dim == 3 ? (float)b->x[2][l] : 0;
        const float slope[3] = {weight * x, weight * y, weight * z};
        add_float_product(&m[0], l, slope[0], x, how);
        add_float_product(&m[1], l, slope[1], y, how);
        add_float_product(&m[2], l, slope[0], y, how);
        if (how.dim == 3) {
            add_float_product(&m[3], l, slope[2], z, how);
            add_float_product(&m[4], l, slope[2], x, how);
            add_float_product(&m[5], l, slope[2], y, how);
        }
        for (int e = 0; e < how.dim; e++) {
            const float u = (float)(v[e] - b->v[e][l]);
            for (int d = 0; d < how.dim; d++) add_float_product(&sums->velocity[e][d], l, slope[d], u, how);
        }
    }
}

/* Is one of these neighbours a gas to the particle's liquid, and in reach? r: their distances, block by block. */
INLINE bool is_beside_gas(const Particles *s, const Model *model, const uint32_t *j, const double *r, size_t n)
{
    bool beside = false;
    for (size_t k = 0; k < n; k++)
        beside |= r[k] < model->kernel.support && model_is_gas(model, model->phase[s->phase[j[k]]].rho0);
    return beside;
}

INLINE void no_strain(Particles *s, size_t i, How how)
{
    for (int d = 0; d < how.dim; d++) s->strain[d][i] = 0;
    s->strain_off[0][i] = 0;
    if (how.dim == 3) s->strain_off[1][i] = s->strain_off[2][i] = 0;
}

INLINE void strain_end(Particles *s, size_t i, const StrainSums *sums, How how)
{
    Moments moments;
    double g[3][3] = {{0}}; /* of component e along d */
    for (int k = 0; k < (how.dim == 3 ? 6 : 3); k++) widened(&sums->moments[k], &moments.of[k]);
    const Correction M = moments_inverse_of(&moments, -1, how);
    for (int e = 0; e < how.dim; e++) {
        Lanes sum[3];
        for (int d = 0; d < how.dim; d++) widened(&sums->velocity[e][d], &sum[d]);
        correct(&M, sum, how, g[e]);
        for (int d = 0; d < how.dim; d++) g[e][d] = -g[e][d];
    }
    for (int d = 0; d < how.dim; d++) s->strain[d][i] = g[d][d];
    s->strain_off[0][i] = 0.5 * (g[0][1] + g[1][0]);
    if (how.dim == 3) {
        s->strain_off[1][i] = 0.5 * (g[0][2] + g[2][0]);
        s->strain_off[2][i] = 0.5 * (g[1][2] + g[2][1]);
    }
}

/* What is fixed in the pairs of one particle. */
typedef struct Strain {
    double diagonal[3], off[3];
} Strain;

INLINE Strain strain_of(const Particles *s, size_t i, How how)
{
    Strain a = {{0}, {0}};
    for (int d = 0; d < how.dim; d++) {
        a.diagonal[d] = s->strain[d][i];
        if (how.dim == 3 || d == 0) a.off[d] = s->strain_off[d][i];
    }
    return a;
}

/* x_ij . (D_i + D_j)/2 . x_ij as far as it closes: 0 or less [m^2/s]. Without a pointer into the pair, for which gcc vectorises no loop. */
INLINE double strained_closing(const Strain *a, const Pair *pair, How how)
{
    const double x = pair->x[0], y = pair->x[1];
    double sum = 2 * (a->off[0] + pair->normal[0]) * x * y;
    sum += (a->diagonal[0] + pair->gradient[0]) * x * x;
    sum += (a->diagonal[1] + pair->gradient[1]) * y * y;
    if (how.dim == 3) {
        const double z = pair->x[2];
        sum += (a->diagonal[2] + pair->gradient[2]) * z * z;
        sum += 2 * ((a->off[1] + pair->normal[1]) * x + (a->off[2] + pair->normal[2]) * y) * z;
    }
    return sum < 0 ? 0.5 * sum : 0;
}

#endif
