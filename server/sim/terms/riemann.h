/* SPDX-License-Identifier: BSD-3-Clause */
/* The two-phase Riemann problem along the line between two particles, with acoustic impedances z = rho c.   P3 eq. 6-10, 13
 *   p* = (z_i p_j + z_j p_i) / (z_i + z_j) + z_i z_j / (z_i + z_j) min(s dU+ / c, 1) dU,   dU = (v_i - v_j) . e,  e: i to j
 * Where velocities are reconstructed dU is what is left beside the part that is linear around both, never less than 0 nor more than dU (strain.h).
 *   v* = (z_i v_i + z_j v_j) / (z_i + z_j) + (p_i - p_j) / (z_i + z_j) e
 * and p_i - p_j there what slope.h leaves of it.
 * With one speed of sound for all fluids these are P3's equations; the light fluid feels the heavy one as a moving wall. In the
 * limiter c is the greatest of all fluids.
 * Against a wall the state behind it is that of the wall's pressure for this fluid, and p* has no dissipation: with it, a
 * dam break's front lags and a quarter of its energy is lost (schemes/riemann.md). */
#ifndef SIM_TERMS_RIEMANN_H
#define SIM_TERMS_RIEMANN_H

#include "sim/kernel_shape.h"
#include "sim/terms/midway.h"

/* What is fixed in the pairs of one particle. */
typedef struct Side {
    double v[3], p, z, rho, c, rho0, V;
    double lag;             /* of velocities behind positions [s] */
    double inverse_c2;      /* for state_density() without a quotient for each pair */
    double steepness, tiny; /* of p*: s / c, and what keeps 0/0 away [m] */
    const double *p_wall;   /* by index of wall particle */
    uint32_t first_wall;
} Side;

INLINE Side side_of(const Particles *s, const Model *model, size_t i, How how)
{
    const Phase *phase = &model->phase[s->phase[i]];
    Side a = {.p = s->p[i * s->p_step],
              .z = particles_impedance(s, model, i),
              .rho = s->rho[i],
              .c = phase->c,
              .rho0 = phase->rho0,
              .V = particles_volume(s, model, i)};
    for (int d = 0; d < how.dim; d++) a.v[d] = s->v[d][i * s->v_step];
    a.lag = model->lag;
    a.inverse_c2 = 1 / (a.c * a.c);
    a.steepness = model->limiter / model->c_max;
    a.tiny = 1e-12 * model->dx;
    a.p_wall = s->p_wall[s->phase[i]];
    a.first_wall = (uint32_t)particles_fluid(s);
    return a;
}

/* The pressure that wall particle j shows to the fluid of this side. */
INLINE double side_wall_pressure(const Side *a, uint32_t j)
{
    return a->p_wall[j - a->first_wall];
}

/* (v_i - v_j) . (x_i - x_j) */
INLINE double opening(const Side *a, const Pair *pair, How how)
{
    return DOT_DIFFERENCE(a->v, pair->v, pair->x, how);
}

/* Of sum_j V_j (v_i - v*) . grad_i W, velocities midway. above: how much the pressure of i is above that of j, as far as that counts. */
INLINE void riemann_density_fluid(const Side *a, const Pair *pair, double above, How how, int l, Lanes *sum)
{
    const double across = pair->F * (above * pair->r);
    const double excess = mul_add(pair->z, compression_midway(a->v, pair, a->lag, how), across, how.fma);
    add_product(sum, l, pair->V, excess / (a->z + pair->z), how);
}

/* p_w: what the wall shows this fluid. */
INLINE void riemann_density_wall(const Side *a, const Pair *pair, double p_w, double above, How how, int l, Lanes *sum)
{
    const double zw = mul_add(p_w, a->inverse_c2, a->rho0, how.fma) * a->c;
    const double across = pair->F * (above * pair->r);
    const double excess = mul_add(zw, compression_midway(a->v, pair, a->lag, how), across, how.fma);
    add_product(sum, l, pair->V, excess / (a->z + zw), how);
}

/* d rho_i/dt = 2 rho_i sum_j V_j (v_i - v*) . grad_i W */
INLINE void riemann_density_end(const Side *a, Particles *s, size_t i, const Lanes *sum)
{
    s->rate[i] = 2 * a->rho * lanes_sum(sum);
}

/* V_i V_j p* F times x_i - x_j. */
INLINE void add_push(const Side *a, const Pair *pair, double p_star, How how, int l, Lanes sum[3])
{
    add_along(pair, a->V * pair->V * p_star * pair->F, how, l, sum);
}

/* smooth: what of the pair's opening is not dissipated, 0 or less [m^2/s]. */
INLINE void riemann_momentum_fluid(const Side *a, const Pair *pair, double smooth, How how, int l, Lanes sum[3])
{
    const double zj = pair->z, r = pair->r + a->tiny, z = a->z + zj, inverse = 1 / (r * z); /* one quotient for two */
    const double closing = positive((smooth - opening(a, pair, how)) * (inverse * z));
    const double limited = a->steepness * closing < 1 ? a->steepness * closing : 1;
    const double p_star = mul_add(a->z * zj, limited * closing, a->z * pair->p + zj * a->p, how.fma);
    add_push(a, pair, p_star * (inverse * r), how, l, sum);
}

INLINE void riemann_momentum_wall(const Side *a, const Pair *pair, double p_w, How how, int l, Lanes sum[3])
{
    const double rho_w = mul_add(p_w, a->inverse_c2, a->rho0, how.fma);
    add_push(a, pair, mul_add(a->rho, p_w, rho_w * a->p, how.fma) / (a->rho + rho_w), how, l, sum);
}

/* m_i dv_i/dt = -2 sum_j V_i V_j p* grad_i W. The coefficient is symmetric in i and j: opposite forces to the last bit. */
INLINE void riemann_momentum_end(Particles *s, size_t i, const Lanes sum[3], How how)
{
    const double scale = -2 / s->m[i];
    for (int d = 0; d < how.dim; d++) s->a[d][i] += scale * lanes_sum(&sum[d]);
}

#endif
