/* SPDX-License-Identifier: BSD-3-Clause */
/* Laminar viscosity with the harmonic mean of the viscosities, inside the sum as dimension and limit demand.      P1 eq. 10
 *   m_i dv_i/dt += sum_j V_i V_j 4 mu_i mu_j / (mu_i + mu_j) (x_ij . grad_i W) / (r^2 + 0.01 h^2) (v_i - v_j)
 * times a constant near 1 that makes it exact for u = y^2 on the starting lattice: without it the softening makes every fluid
 * 1 % less viscous, and refinement does not help.
 * A wall without slip has the fluid's viscosity and the velocity that makes the mean on the wall that of the wall:
 * 2 v_w - v~, with v~ the fluid's velocity extrapolated into it (Adami, Hu and Adams 2012, eq. 23). */
#include "sim/terms/viscosity.h"
#include "sim/terms/terms.h"

/* What a pair adds to the Laplacian of u = y^2 / 2, per volume. */
static double curvature(const Kernel *kernel, int dim, const double x[3], double r, double W, double F)
{
    const double r2 = r * r;
    return kernel_quantity_slope(kernel, dim, x, r, W, F) * r2 / (r2 + viscosity_softening(kernel));
}

double viscosity_scale(const Kernel *kernel, int dim, const double spacing[3])
{
    double volume = 1;
    for (int d = 0; d < dim; d++) volume *= spacing[d];
    return 1 / (volume * kernel_lattice_sum(kernel, dim, spacing, curvature));
}

INLINE void viscosity_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const double soft = viscosity_softening(&model->kernel), V = particles_volume(s, model, i);
    double mu[MNS_MAX_FLUIDS], v[3]; /* viscosity against each fluid, once for all pairs */
    viscosities_of(model, s->phase[i], 4, mu);
    for (int d = 0; d < how.dim; d++) v[d] = s->v[d][i * s->v_step];
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        const uint32_t *j = row_j(row, b);
        double mu_ij[LANES];
        by_fluid(s, j, mu, mu_ij);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            viscosity_pair(v, V, &pair, mu_ij[l], soft, how, l, sum);
        }
    }
    viscosity_end(s, i, sum, how);
}
ROW_FUNCTIONS(viscosity_row)

INLINE void wall_friction_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const double mu = wall_viscosity_of(model, s->phase[i]), soft = viscosity_softening(&model->kernel),
                 V = particles_volume(s, model, i);
    if (mu == 0) return;
    double v[3];
    for (int d = 0; d < how.dim; d++) v[d] = s->v[d][i * s->v_step];
    Lanes sum[3] = {0};
    for (const Block *b = row->block + row->n_fluid; b < row->block + row->n; b++) {
        Sticking wall;
        sticking_of_block(row, b, s, model, mu, how, &wall);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            friction_pair(v, V, &pair, &wall, soft, how, l, sum);
        }
    }
    viscosity_end(s, i, sum, how);
}
ROW_FUNCTIONS(wall_friction_row)

const Term viscosity = {
    .name = "viscosity",
    .source = "P1 eq. 10",
    .equation = "m_i dv_i/dt += sum_j V_i V_j 4 mu_i mu_j/(mu_i + mu_j) (x_ij . grad_i W)/(r^2 + 0.01 h^2) v_ij",
    .on = ON_FLUID,
    .needed = is_viscous_between,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .writes = FIELD(A),
    .row = ROW_TABLE(viscosity_row),
};

const Term wall_friction = {
    .name = "wall friction",
    .source = "P1 eq. 10, Adami 2012 eq. 23",
    .equation = "the same against v_j = 2 v_w - v~_w, mu_j = mu_i, for walls without slip",
    .on = ON_FLUID,
    .needed = is_viscous_between,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .writes = FIELD(A),
    .beside = LIST_WALLS,
    .row = ROW_TABLE(wall_friction_row),
};
