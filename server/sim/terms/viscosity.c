/* SPDX-License-Identifier: BSD-3-Clause */
/* Laminar viscosity with the harmonic mean of the viscosities, inside the sum as dimension and limit demand.      P1 eq. 10
 *   m_i dv_i/dt += sum_j V_i V_j 4 mu_i mu_j / (mu_i + mu_j) (x_ij . grad_i W) / (r^2 + 0.01 h^2) (v_i - v_j)
 * times a constant near 1 that makes it exact for u = y^2 on the starting lattice: without it the softening makes every fluid
 * 1 % less viscous, and refinement does not help.
 * A wall without slip has the fluid's viscosity and the velocity that makes the mean on the wall that of the wall:
 * 2 v_w - v~, with v~ the fluid's velocity extrapolated into it (Adami, Hu and Adams 2012, eq. 23). */
#include "sim/terms/terms.h"

static bool is_viscous(const Model *model)
{
    return model->viscous;
}

static double softening(const Kernel *kernel)
{
    return 0.01 * kernel->h * kernel->h;
}

/* What a pair adds to the Laplacian of u = y^2 / 2, per volume. */
static double curvature(const Kernel *kernel, int dim, double r, double W, double F)
{
    const double r2 = r * r;
    return kernel_quantity_slope(kernel, dim, r, W, F) * r2 / (r2 + softening(kernel));
}

double viscosity_scale(const Kernel *kernel, int dim, const double spacing[3])
{
    double volume = 1;
    for (int d = 0; d < dim; d++) volume *= spacing[d];
    return 1 / (volume * kernel_lattice_sum(kernel, dim, spacing, curvature));
}

/* c[k] = V_i V_j mu_k F r^2 / (r^2 + 0.01 h^2), with mu in u. */
static void coefficients(Row *row, const Particles *s, const Model *model, size_t first, size_t last)
{
    const double *restrict V = s->vol, *restrict F = row->F, *restrict r = row->r, *restrict mu = row->u;
    const uint32_t *restrict j = row->j;
    double *restrict c = row->c;
    const double V_i = V[row->i], soft = softening(&model->kernel);
#pragma omp simd
    for (size_t k = row_whole(first); k < row_whole(last); k++) {
        const double r2 = r[k] * r[k];
        c[k] = V_i * V[j[k]] * mu[k] * F[k] * r2 / (r2 + soft);
    }
}

static void viscosity_row(Row *row, Particles *s, const Model *model)
{
    const size_t i = row->i, n = row->end[GROUP_SUMMATION];
    const double mu_i = model->phase[s->phase[i]].mu;
    double mu[MNS_MAX_FLUIDS]; /* against each fluid, once for all pairs */
    for (size_t a = 0; a < model->n_phases; a++) {
        const double mu_a = model->phase[a].mu;
        mu[a] = mu_i + mu_a > 0 ? model->viscous_scale * 4 * mu_i * mu_a / (mu_i + mu_a) : 0;
    }
    for (size_t k = 0; k < n; k++) row->u[k] = mu[s->phase[row->j[k]]];
    coefficients(row, s, model, 0, n);
    const double total = row_sum(row, 0, n), scale = 1 / s->m[i];
    for (int d = 0; d < row->dim; d++) s->a[d][i] += scale * (total * s->v[d][i] - row_sum_field(row, s->v[d], 0, n));
}

static void wall_friction_row(Row *row, Particles *s, const Model *model)
{
    const size_t i = row->i, first = row->end[GROUP_SUMMATION], last = row->n, first_wall = particles_fluid(s);
    const double mu = model->phase[s->phase[i]].mu;
    if (first == last || mu == 0) return;
    for (size_t k = first; k < last; k++)
        row->u[k] = model->wall[s->phase[row->j[k]] - model->n_phases].no_slip ? 2 * mu * model->viscous_scale : 0;
    coefficients(row, s, model, first, last);
    const double scale = 1 / s->m[i];
    for (int d = 0; d < row->dim; d++) {
        const double v_i = s->v[d][i];
        double sum = 0;
        for (size_t k = first; k < last; k++)
            sum += row->c[k] * (v_i - (2 * s->v[d][row->j[k]] - s->v_wall[d][row->j[k] - first_wall]));
        s->a[d][i] += scale * sum;
    }
}

const Term viscosity = {
    .name = "viscosity",
    .source = "P1 eq. 10",
    .equation = "m_i dv_i/dt += sum_j V_i V_j 4 mu_i mu_j/(mu_i + mu_j) (x_ij . grad_i W)/(r^2 + 0.01 h^2) v_ij",
    .on = ON_FLUID,
    .needed = is_viscous,
    .row = viscosity_row,
};

const Term wall_friction = {
    .name = "wall friction",
    .source = "P1 eq. 10, Adami 2012 eq. 23",
    .equation = "the same against v_j = 2 v_w - v~_w, mu_j = mu_i, for walls without slip",
    .on = ON_FLUID,
    .needed = is_viscous,
    .row = wall_friction_row,
};
