/* SPDX-License-Identifier: BSD-3-Clause */
/* The two-phase Riemann problem along the line between two particles, with acoustic impedances z = rho c.   P3 eq. 6-10, 13
 *   p* = (z_i p_j + z_j p_i) / (z_i + z_j) + z_i z_j / (z_i + z_j) min(s dU+ / c, 1) dU,   dU = (v_i - v_j) . e,  e: i to j
 *   v* = (z_i v_i + z_j v_j) / (z_i + z_j) + (p_i - p_j) / (z_i + z_j) e
 * With one speed of sound for all fluids these are P3's equations; the light fluid feels the heavy one as a moving wall.
 * Against a wall the state behind it is that of the wall's pressure for this fluid, and p* has no dissipation: with it, a
 * dam break's front lags and a quarter of its energy is lost (schemes/README.md). */
#include "sim/kernel_shape.h"
#include "sim/terms/terms.h"

/* What is fixed in the pairs of one particle. */
typedef struct Side {
    double v[3], p, z, rho, c, rho0, V;
    const double *p_wall; /* by index of wall particle */
    uint32_t first_wall;
} Side;

INLINE Side side_of(const Particles *s, const Model *model, size_t i)
{
    const Phase *phase = &model->phase[s->phase[i]];
    Side a = {.p = s->p[i], .z = s->z[i], .rho = s->rho[i], .c = phase->c, .rho0 = phase->rho0, .V = s->vol[i]};
    for (int d = 0; d < s->dim; d++) a.v[d] = s->v[d][i];
    a.p_wall = s->p_wall[s->phase[i]];
    a.first_wall = (uint32_t)particles_fluid(s);
    return a;
}

/* (v_i - v_j) . (x_i - x_j) */
INLINE double opening(const Side *a, const Block *b, int l, int dim)
{
    double u = 0;
    for (int d = 0; d < dim; d++) u += (a->v[d] - b->v[d][l]) * b->x[d][l];
    return u;
}

/* d rho_i/dt = 2 rho_i sum_j V_j (v_i - v*) . grad_i W */
INLINE void riemann_density_row(const Row *row, Particles *s, const Model *model, int dim)
{
    const Side a = side_of(s, model, row->i);
    const Block *const walls = row->block + row->n_fluid, *const end = row->block + row->n;
    Lanes sum = {0};
    for (const Block *b = row->block; b < walls; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++)
            sum.of[l] +=
                b->V[l] * b->F[l] * (b->z[l] * opening(&a, b, l, dim) + (a.p - b->p[l]) * b->r[l]) / (a.z + b->z[l]);
    const double inverse_c = 1 / a.c, inverse_c2 = inverse_c * inverse_c;
    for (const Block *b = walls; b < end; b++) {
        const uint32_t *j = row_j(row, b);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double pw = a.p_wall[j[l] - a.first_wall], zw = (a.rho0 + pw * inverse_c2) * a.c;
            sum.of[l] += b->V[l] * b->F[l] * (zw * opening(&a, b, l, dim) + (a.p - pw) * b->r[l]) / (a.z + zw);
        }
    }
    s->rate[row->i] = 2 * a.rho * lanes_sum(&sum);
}
ROW_FUNCTIONS(riemann_density_row)

/* m_i dv_i/dt = -2 sum_j V_i V_j p* grad_i W. The coefficient is symmetric in i and j: opposite forces to the last bit. */
INLINE void riemann_momentum_row(const Row *row, Particles *s, const Model *model, int dim)
{
    const size_t i = row->i;
    const Side a = side_of(s, model, i);
    const Block *const walls = row->block + row->n_fluid, *const end = row->block + row->n;
    const double steepness = model->limiter / model->c_max, tiny = 1e-12 * model->dx;
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < walls; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double zj = b->z[l], r = b->r[l] + tiny, z = a.z + zj, inverse = 1 / (r * z);
            const double closing = positive(-opening(&a, b, l, dim) * (inverse * z)); /* one quotient for two */
            const double limited = steepness * closing < 1 ? steepness * closing : 1;
            const double p_star = (a.z * b->p[l] + zj * a.p + a.z * zj * (limited * closing)) * (inverse * r);
            const double c = a.V * b->V[l] * p_star * b->F[l];
            for (int d = 0; d < dim; d++) sum[d].of[l] += c * b->x[d][l];
        }
    const double inverse_c2 = 1 / (a.c * a.c);
    for (const Block *b = walls; b < end; b++) {
        const uint32_t *j = row_j(row, b);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double pw = a.p_wall[j[l] - a.first_wall], rho_w = a.rho0 + pw * inverse_c2;
            const double c = a.V * b->V[l] * ((a.rho * pw + rho_w * a.p) / (a.rho + rho_w)) * b->F[l];
            for (int d = 0; d < dim; d++) sum[d].of[l] += c * b->x[d][l];
        }
    }
    const double scale = -2 / s->m[i];
    for (int d = 0; d < dim; d++) s->a[d][i] += scale * lanes_sum(&sum[d]);
}
ROW_FUNCTIONS(riemann_momentum_row)

const Term riemann_density = {
    .name = "Riemann continuity",
    .source = "P3 eq. 5, 8, 17",
    .equation = "d rho_i/dt = 2 rho_i sum_j V_j (v_i - v*) . grad_i W",
    .on = ON_CONTINUITY,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .row = ROW_TABLE(riemann_density_row),
};

const Term riemann_momentum = {
    .name = "Riemann momentum",
    .source = "P3 eq. 6, 9, 10, 13",
    .equation = "m_i dv_i/dt = -2 sum_j V_i V_j p* grad_i W",
    .on = ON_FLUID,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .writes = FIELD(A),
    .row = ROW_TABLE(riemann_momentum_row),
};
