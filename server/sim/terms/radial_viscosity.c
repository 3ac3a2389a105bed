/* SPDX-License-Identifier: BSD-3-Clause */
/* Laminar viscosity along the line of a pair, which keeps angular momentum and, at a free surface, has no traction.
 *   m_i dv_i/dt += sum_j V_i V_j 2 S 2 mu_i mu_j/(mu_i + mu_j) (v_ij . x_ij) grad_i W,   S = 1/sum V (-F) x^2 y^2 over the lattice
 * In P2's eq. 25, which is Monaghan's and Gingold's, a quotient by r^2 + 0.01 h^2 stands for S: what is summed is then no smooth function where the
 * two meet, and a flow along the rows of a lattice has 8 to 17 % less viscosity than one across. Without it fourth moments are those of a smooth
 * kernel, which a lattice sums almost as integrals. P1's eq. 10 is a Laplacian: it would hold du/dn = 0 at a free surface, which damps waves half
 * as fast as they should be, and lacks grad mu . grad v^T. Walls as in viscosity.c. */
#include "sim/terms/terms.h"
#include "sim/terms/viscosity.h"

/* Mean over the planes of the lattice of what a pair adds to the viscosity of a flow along its rows, per volume. */
static double shear(const Kernel *kernel, int dim, const double x[3], double r, double W, double F)
{
    const double xy = x[0] * x[1], yz = x[1] * x[2], zx = x[2] * x[0];
    (void)kernel, (void)r, (void)W;
    return -F * (xy * xy + yz * yz + zx * zx) / (dim == 2 ? 1 : 3);
}

double radial_viscosity_scale(const Kernel *kernel, int dim, const double spacing[3])
{
    double volume = 1;
    for (int d = 0; d < dim; d++) volume *= spacing[d];
    return 1 / (volume * kernel_lattice_sum(kernel, dim, spacing, shear));
}

INLINE void radial_viscosity_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const double V = particles_volume(s, model, i);
    double mu[MNS_MAX_FLUIDS], v[3];
    radial_viscosities_of(model, s->phase[i], mu);
    for (int d = 0; d < how.dim; d++) v[d] = s->v[d][i * s->v_step];
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        const uint32_t *j = row_j(row, b);
        double mu_ij[LANES];
        by_fluid(s, j, mu, mu_ij);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            drag_pair(v, V, &pair, mu_ij[l], how, l, sum);
        }
    }
    viscosity_end(s, i, sum, how);
}
ROW_FUNCTIONS(radial_viscosity_row)

INLINE void radial_friction_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const double mu = radial_viscosity_of(model, s->phase[i], s->phase[i]), V = particles_volume(s, model, i);
    if (mu == 0) return;
    double v[3];
    for (int d = 0; d < how.dim; d++) v[d] = s->v[d][i * s->v_step];
    Lanes sum[3] = {0};
    for (const Block *b = row->block + row->n_fluid; b < row->block + row->n; b++) {
        Sticking wall;
        sticking_of_block(row, b, s, model, mu, how, &wall); /* no simd: gcc takes the mirrored pair for memory */
        for (int l = 0; l < LANES; l++) {
            Pair pair = block_pair(b, l, how);
            radial_friction_pair(v, V, &pair, &wall, how, l, sum);
        }
    }
    viscosity_end(s, i, sum, how);
}
ROW_FUNCTIONS(radial_friction_row)

const Term radial_viscosity = {
    .name = "viscosity",
    .source = "P2 eq. 25, without 1/r^2",
    .equation = "m_i dv_i/dt += sum_j V_i V_j 2 S 2 mu_i mu_j/(mu_i + mu_j) (v_ij . x_ij) grad_i W",
    .on = ON_FLUID,
    .needed = is_viscous_along,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .writes = FIELD(A),
    .row = ROW_TABLE(radial_viscosity_row),
};

const Term radial_friction = {
    .name = "wall friction",
    .source = "P2 eq. 38-41",
    .equation = "the same against the mirrored velocity, mu_j = mu_i, for walls without slip",
    .on = ON_FLUID,
    .needed = is_viscous_along,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .writes = FIELD(A),
    .beside = LIST_WALLS,
    .row = ROW_TABLE(radial_friction_row),
};
