/* SPDX-License-Identifier: BSD-3-Clause */
/* The two-phase Riemann problem along the line between two particles, with acoustic impedances z = rho c.   P3 eq. 6-10, 13
 *   p* = (z_i p_j + z_j p_i) / (z_i + z_j) + z_i z_j / (z_i + z_j) min(s dU+ / c, 1) dU,   dU = (v_i - v_j) . e,  e: i to j
 *   v* = (z_i v_i + z_j v_j) / (z_i + z_j) + (p_i - p_j) / (z_i + z_j) e
 * With one speed of sound for all fluids these are P3's equations; the light fluid feels the heavy one as a moving wall.
 * Against a wall the state behind it is that of the wall's pressure for this fluid, and p* has no dissipation: with it, a
 * dam break's front lags and a quarter of its energy is lost (schemes/README.md). */
#include "sim/terms/terms.h"

/* What is fixed in the pairs of one particle. */
typedef struct Side {
    double p, z, rho, c, rho0;
    const double *p_wall; /* by index of wall particle */
} Side;

static Side side_of(const Particles *s, const Model *model, size_t i)
{
    const Phase *phase = &model->phase[s->phase[i]];
    return (Side){s->p[i], s->z[i], s->rho[i], phase->c, phase->rho0, s->p_wall[s->phase[i]]};
}

/* d rho_i/dt = 2 rho_i sum_j V_j (v_i - v*) . grad_i W */
static void riemann_density_row(Row *row, Particles *s, const Model *model)
{
    const Side a = side_of(s, model, row->i);
    const size_t n = row_whole(row->n), n_fluid = row_whole(row->end[GROUP_SUMMATION]), first_wall = particles_fluid(s);
    const double *restrict z = s->z, *restrict p = s->p, *restrict V = s->vol;
    const double *restrict r = row->r, *restrict F = row->F, *restrict u = row->u;
    const uint32_t *restrict j = row->j;
    double *restrict c = row->c;

    row_dot_difference(row, s->v);
#pragma omp simd
    for (size_t k = 0; k < n_fluid; k++)
        c[k] = V[j[k]] * F[k] * (z[j[k]] * u[k] + (a.p - p[j[k]]) * r[k]) / (a.z + z[j[k]]);
    const double inverse_c = 1 / a.c, inverse_c2 = inverse_c * inverse_c;
#pragma omp simd
    for (size_t k = n_fluid; k < n; k++) {
        const double pw = a.p_wall[j[k] - first_wall], zw = (a.rho0 + pw * inverse_c2) * a.c;
        c[k] = V[j[k]] * F[k] * (zw * u[k] + (a.p - pw) * r[k]) / (a.z + zw);
    }
    s->rate[row->i] = 2 * a.rho * row_sum(row, 0, n);
}

/* m_i dv_i/dt = -2 sum_j V_i V_j p* grad_i W. The coefficient is symmetric in i and j: opposite forces to the last bit. */
static void riemann_momentum_row(Row *row, Particles *s, const Model *model)
{
    const Side a = side_of(s, model, row->i);
    const size_t i = row->i, n = row_whole(row->n), n_fluid = row_whole(row->end[GROUP_SUMMATION]),
                 first_wall = particles_fluid(s);
    const double *restrict z = s->z, *restrict p = s->p, *restrict V = s->vol;
    const double *restrict r = row->r, *restrict F = row->F, *restrict u = row->u;
    const uint32_t *restrict j = row->j;
    double *restrict c = row->c;
    const double V_i = V[i], steepness = model->limiter / model->c_max, tiny = 1e-12 * model->dx;

    row_dot_difference(row, s->v);
#pragma omp simd
    for (size_t k = 0; k < n_fluid; k++) {
        const double zj = z[j[k]], approach = -u[k] / (r[k] + tiny);
        const double closing = approach > 0 ? approach : 0;
        const double limited = steepness * closing < 1 ? steepness * closing : 1;
        const double p_star = (a.z * p[j[k]] + zj * a.p + a.z * zj * (limited * closing)) / (a.z + zj);
        c[k] = V_i * V[j[k]] * p_star * F[k];
    }
    const double inverse_c2 = 1 / (a.c * a.c);
#pragma omp simd
    for (size_t k = n_fluid; k < n; k++) {
        const double pw = a.p_wall[j[k] - first_wall], rho_w = a.rho0 + pw * inverse_c2;
        c[k] = V_i * V[j[k]] * ((a.rho * pw + rho_w * a.p) / (a.rho + rho_w)) * F[k];
    }
    const double scale = -2 / s->m[i];
    for (int d = 0; d < row->dim; d++) s->a[d][i] += scale * row_sum_along(row, d, 0, n);
}

const Term riemann_density = {
    .name = "Riemann continuity",
    .source = "P3 eq. 5, 8, 17",
    .equation = "d rho_i/dt = 2 rho_i sum_j V_j (v_i - v*) . grad_i W",
    .on = ON_CONTINUITY,
    .row = riemann_density_row,
};

const Term riemann_momentum = {
    .name = "Riemann momentum",
    .source = "P3 eq. 6, 9, 10, 13",
    .equation = "m_i dv_i/dt = -2 sum_j V_i V_j p* grad_i W",
    .on = ON_FLUID,
    .row = riemann_momentum_row,
};
