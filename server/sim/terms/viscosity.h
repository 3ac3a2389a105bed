/* SPDX-License-Identifier: BSD-3-Clause */
/* Laminar viscosity, pair by pair (viscosity.c, radial_viscosity.c). */
#ifndef SIM_TERMS_VISCOSITY_H
#define SIM_TERMS_VISCOSITY_H

#include "sim/terms/average.h"

/* Added to r^2, so that close pairs do not diverge. */
INLINE double viscosity_softening(const Kernel *kernel)
{
    return 0.01 * kernel->h * kernel->h;
}

/* The harmonic mean of two fluids' viscosities, times half a number and the constant that makes the sum exact on the lattice. */
INLINE double viscosity_of(const Model *model, unsigned a, unsigned b, double times)
{
    return model->viscous_scale * (0.5 * times * harmonic_mean(model->phase[a].mu, model->phase[b].mu));
}

/* Of sum_j V_i V_j mu F r^2/(r^2 + 0.01 h^2) v_ij, opposite to the last bit for the two of a pair; mu: 4 mu_i mu_j/(mu_i + mu_j). */
INLINE void viscosity_pair(const double v[3], double V, const Pair *pair, double mu, double soft, How how, int l,
                           Lanes sum[3])
{
    const double r2 = pair->r * pair->r, c = mu * (V * pair->V * pair->F * r2 / (r2 + soft));
    for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, c, v[d] - pair->v[d], how);
}

/* Of each fluid against that of a particle, times a number. */
INLINE void viscosities_of(const Model *model, unsigned mine, double times, double ret[MNS_MAX_FLUIDS])
{
    for (unsigned k = 0; k < model->n_phases; k++) ret[k] = viscosity_of(model, mine, k, times);
}

/* Of a fluid against a wall without slip, times 4. */
INLINE double wall_viscosity_of(const Model *model, unsigned mine)
{
    return 2 * model->phase[mine].mu * model->viscous_scale;
}

/* Eight wall particles as a viscous fluid sees them: the velocity mirrored at their surface (wall.c), and mu where they are without slip, else 0. */
typedef struct Sticking {
    double v[3][LANES], mu[LANES];
} Sticking;

INLINE void sticking_of(const Particles *s, const Model *model, const uint32_t *j, double mu, How how, Sticking *ret)
{
    const size_t first_wall = particles_fluid(s);
    for (int l = 0; l < LANES; l++) {
        ret->mu[l] = model->wall[s->phase[j[l]] - model->n_phases].no_slip ? mu : 0;
        for (int d = 0; d < how.dim; d++) ret->v[d][l] = s->v_wall[d][j[l] - first_wall];
    }
}

/* Of a block of a row, whose images are turned. */
INLINE void sticking_of_block(const Row *row, const Block *b, const Particles *s, const Model *model, double mu,
                              How how, Sticking *ret)
{
    sticking_of(s, model, row_j(row, b), mu, how, ret);
    for (int d = 0; d < how.dim && are_images(row, b); d++) turn_component(row, b, d, ret->v[d]);
}

INLINE void friction_pair(const double v[3], double V, const Pair *pair, const Sticking *wall, double soft, How how,
                          int l, Lanes sum[3])
{
    Pair mirrored = *pair;
    for (int d = 0; d < how.dim; d++) mirrored.v[d] = wall->v[d][l];
    viscosity_pair(v, V, &mirrored, wall->mu[l], soft, how, l, sum);
}

INLINE void viscosity_end(Particles *s, size_t i, const Lanes sum[3], How how)
{
    const double scale = 1 / s->m[i];
    for (int d = 0; d < how.dim; d++) s->a[d][i] += scale * lanes_sum(&sum[d]);
}

/* --- along the line of a pair --- */

/* Twice the harmonic mean of two fluids' viscosities, times the constant S of the lattice [Pa s m^-2]. */
INLINE double radial_viscosity_of(const Model *model, unsigned a, unsigned b)
{
    return model->radial_scale * (2 * harmonic_mean(model->phase[a].mu, model->phase[b].mu));
}

/* Of each fluid against that of a particle. */
INLINE void radial_viscosities_of(const Model *model, unsigned mine, double ret[MNS_MAX_FLUIDS])
{
    for (unsigned k = 0; k < model->n_phases; k++) ret[k] = radial_viscosity_of(model, mine, k);
}

/* Of sum_j V_i V_j mu (v_ij . x_ij) grad_i W, opposite as well. */
INLINE void drag_pair(const double v[3], double V, const Pair *pair, double mu, How how, int l, Lanes sum[3])
{
    const double along = DOT_DIFFERENCE(v, pair->v, pair->x, how);
    add_along(pair, mu * (V * pair->V * pair->F * along), how, l, sum);
}

INLINE void radial_friction_pair(const double v[3], double V, const Pair *pair, const Sticking *wall, How how, int l,
                                 Lanes sum[3])
{
    Pair mirrored = *pair;
    for (int d = 0; d < how.dim; d++) mirrored.v[d] = wall->v[d][l];
    drag_pair(v, V, &mirrored, wall->mu[l], how, l, sum);
}

#endif
