/* SPDX-License-Identifier: BSD-3-Clause */
/* What of a pair's pressures P3's v* leaves alone, as pressures that are linear in space, or a fluid at rest, drive nothing.
 *   both       (g_i + g_j)/2 . x_ij,   g_i = M_i sum_j V_j (p_j - p_i) grad_i W over its own fluid, M of it; 0 of a gas
 *              g_i . x_ij of a wall
 *   velocity   rho_0 g . x_ij where there is a free surface, of its own fluid and of walls
 * What is left of p_i - p_j is never more, nor of the other sign: else it would make energy. */
#ifndef SIM_TERMS_SLOPE_H
#define SIM_TERMS_SLOPE_H

#include "sim/terms/moments.h"

/* What is fixed in the pairs of one particle: its gradient, or its weight [Pa/m]. */
typedef struct Slope {
    double of[3];
} Slope;

INLINE Slope slope_of(const Particles *s, const Model *model, size_t i, Spared spared, How how)
{
    Slope slope = {{0, 0, 0}};
    const double rho0 = model->phase[s->phase[i]].rho0;
    for (int d = 0; d < how.dim; d++) {
        if (spared == SPARED_WEIGHT) slope.of[d] = rho0 * model->gravity[d];
        if (spared == SPARED_SLOPES) slope.of[d] = s->gradient[d][i];
    }
    return slope;
}

/* Gradients of eight neighbours: of bundles, rates of strain have their places. */
typedef struct Slopes {
    double of[3][LANES];
} Slopes;

INLINE void gather_slopes(Slopes *ret, const Particles *s, const uint32_t *j, How how)
{
    for (int d = 0; d < how.dim; d++)
        for (int l = 0; l < LANES; l++) ret->of[d][l] = s->gradient[d][j[l]];
}

INLINE void slopes_of_block(Slopes *ret, const Row *row, const Block *b, const Particles *s, How how)
{
    gather_slopes(ret, s, row_j(row, b), how);
    for (int d = 0; d < how.dim && are_images(row, b); d++) turn_component(row, b, d, ret->of[d]);
}

INLINE double left_beside(double all, double linear)
{
    const double left = all - linear, least = all < 0 ? all : 0, most = all < 0 ? 0 : all;
    return left < least ? least : left > most ? most : left;
}

/* p: of i; other: 1 if the pair is of two fluids. */
INLINE double pressure_beside(const Slope *a, double p, const Pair *pair, const Slopes *theirs, double other,
                              Spared spared, How how, int l)
{
    const double all = p - pair->p;
    if (spared == SPARED_NOTHING) return all;
    if (spared == SPARED_WEIGHT) return left_beside(all, (1 - other) * DOT(a->of, pair->x, how));
    double both[3];
    for (int d = 0; d < how.dim; d++) both[d] = a->of[d] + theirs->of[d][l];
    return left_beside(all, 0.5 * DOT(both, pair->x, how));
}

INLINE double pressure_beside_wall(const Slope *a, double all, const Pair *pair, Spared spared, How how)
{
    return spared == SPARED_NOTHING ? all : left_beside(all, DOT(a->of, pair->x, how));
}

#endif
