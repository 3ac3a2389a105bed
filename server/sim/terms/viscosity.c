/* SPDX-License-Identifier: BSD-3-Clause */
/* Laminar viscosity with the harmonic mean of the viscosities, inside the sum as dimension and limit demand.      P1 eq. 10
 *   m_i dv_i/dt += sum_j V_i V_j 4 mu_i mu_j / (mu_i + mu_j) (x_ij . grad_i W) / (r^2 + 0.01 h^2) (v_i - v_j)
 * times a constant near 1 that makes it exact for u = y^2 on the starting lattice: without it the softening makes every fluid
 * 1 % less viscous, and refinement does not help.
 * A wall without slip has the fluid's viscosity and the velocity that makes the mean on the wall that of the wall:
 * 2 v_w - v~, with v~ the fluid's velocity extrapolated into it (Adami, Hu and Adams 2012, eq. 23). */
#include "sim/terms/terms.h"

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

/* V_i V_j F r^2 / (r^2 + 0.01 h^2) of a pair, but for V_i and mu. */
INLINE double friction(const Block *b, int l, double soft)
{
    const double r2 = b->r[l] * b->r[l];
    return b->V[l] * b->F[l] * r2 / (r2 + soft);
}

INLINE void viscosity_row(const Row *row, Particles *s, const Model *model, int dim)
{
    const size_t i = row->i;
    const double mu_i = model->phase[s->phase[i]].mu, soft = softening(&model->kernel);
    double mu[MNS_MAX_FLUIDS], v[3]; /* viscosity against each fluid, once for all pairs */
    for (size_t a = 0; a < model->n_phases; a++) {
        const double mu_a = model->phase[a].mu;
        mu[a] = mu_i + mu_a > 0 ? model->viscous_scale * 4 * mu_i * mu_a / (mu_i + mu_a) : 0;
    }
    for (int d = 0; d < dim; d++) v[d] = s->v[d][i];
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        const uint32_t *j = row_j(row, b);
        double mu_ij[LANES];
        for (int l = 0; l < LANES; l++) mu_ij[l] = mu[s->phase[j[l]]];
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double c = mu_ij[l] * friction(b, l, soft);
            for (int d = 0; d < dim; d++) sum[d].of[l] += c * (v[d] - b->v[d][l]);
        }
    }
    const double scale = s->vol[i] / s->m[i];
    for (int d = 0; d < dim; d++) s->a[d][i] += scale * lanes_sum(&sum[d]);
}
ROW_FUNCTIONS(viscosity_row)

INLINE void wall_friction_row(const Row *row, Particles *s, const Model *model, int dim)
{
    const size_t i = row->i, first_wall = particles_fluid(s);
    const double mu = 2 * model->phase[s->phase[i]].mu * model->viscous_scale, soft = softening(&model->kernel);
    if (mu == 0) return;
    Lanes sum[3] = {0};
    for (const Block *b = row->block + row->n_fluid; b < row->block + row->n; b++)
        for (int l = 0; l < LANES; l++) {
            const size_t j = row_j(row, b)[l];
            const double c = model->wall[s->phase[j] - model->n_phases].no_slip ? mu * friction(b, l, soft) : 0;
            for (int d = 0; d < dim; d++)
                sum[d].of[l] += c * (s->v[d][i] - (2 * b->v[d][l] - s->v_wall[d][j - first_wall]));
        }
    const double scale = s->vol[i] / s->m[i];
    for (int d = 0; d < dim; d++) s->a[d][i] += scale * lanes_sum(&sum[d]);
}
ROW_FUNCTIONS(wall_friction_row)

const Term viscosity = {
    .name = "viscosity",
    .source = "P1 eq. 10",
    .equation = "m_i dv_i/dt += sum_j V_i V_j 4 mu_i mu_j/(mu_i + mu_j) (x_ij . grad_i W)/(r^2 + 0.01 h^2) v_ij",
    .on = ON_FLUID,
    .needed = is_viscous,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .writes = FIELD(A),
    .row = ROW_TABLE(viscosity_row),
};

const Term wall_friction = {
    .name = "wall friction",
    .source = "P1 eq. 10, Adami 2012 eq. 23",
    .equation = "the same against v_j = 2 v_w - v~_w, mu_j = mu_i, for walls without slip",
    .on = ON_FLUID,
    .needed = is_viscous,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .writes = FIELD(A),
    .row = ROW_TABLE(wall_friction_row),
};
