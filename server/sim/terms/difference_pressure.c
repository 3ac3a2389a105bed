/* SPDX-License-Identifier: BSD-3-Clause */
/* The pressure system of generalized finite differences, and what is done with its solution P = p dt.               P5 eq. 21-24
 *   2 dim/D_i sum_j 2 k_ij/(rho~_i + rho~_j) (P_j - P_i) = <div u>_i = sum_j W (u_i - u_j) . B_i x
 *   u_i -= B_i sum_j 2/(rho~_i + rho~_j) (P_i - P_j) W x
 * with P_j + dt sigma kappa_ij (C_i - C_j) for P_j where there is tension, kappa_ij the mean of the two (colour_gradient.c).
 * A wall particle is an unknown, that balances what body forces b do beside it, towards each fluid particle by itself:
 *   sum_f W (2 (P_w - P_f)/(rho~_w + rho~_f) - dt (b - a_w) . x_wf) = 0
 * By the normal of the surface alone it would not be at rest in corners and where an interface meets a wall: there the fluid in sight is
 * not as much on one side as on the other. The pressure of images (mirrors.h) is P_j' = P_j + dt rho~_j b_j . (x_j' - x_j), and of their u
 * what body forces have made is not turned round. */
#include "sim/mirrors.h"
#include "sim/solve/solve.h"
#include "sim/terms/differences.h"
#include "sim/terms/matrix_row.h"
#include "sim/terms/terms.h"
#include <math.h>
#include <string.h>

/* Keep the entries of a block of pairs. */
INLINE void keep_entries(Matrix *m, const Row *row, const Block *b, const float of[LANES])
{
    const size_t first = m->start[row->i] * LANES, at = first + entry_of(row, (size_t)(b - row->block) * LANES);
    if (are_images(row, b)) {
        add_to_sources(row, b, of, m->c + first);
        return;
    }
    memcpy(m->column + at, row_j(row, b), LANES * sizeof *m->column);
    memcpy(m->c + at, of, LANES * sizeof *of);
}

/* sum_j' c_ij' (P_j' - P_j) over a block of images. */
INLINE double risen(const Row *row, const Block *b, const Particles *s, const Model *model, const float of[LANES],
                    How how)
{
    double rise[LANES], sum = 0;
    image_rises(row, b, s, model, how, rise);
    for (int l = 0; l < LANES; l++) sum += (double)of[l] * rise[l];
    return sum;
}

/* The same over a block of any pairs, across which tension makes a difference. */
INLINE double risen_by_tension(const Row *row, const Block *b, const Particles *s, const Model *model,
                               const double colour[LANES], const float of[LANES])
{
    double rise[LANES], sum = 0;
    tension_rises(row, b, s, model, colour, rise);
    for (int l = 0; l < LANES; l++) sum += (double)of[l] * rise[l];
    return sum;
}

/* The row of a particle, whose blocks of entries are those of its pairs but images. */
INLINE void end_row(System *y, const Row *row, double b)
{
    Matrix *m = &y->matrix;
    const size_t i = row->i;
    const double diagonal = float_sum(m->c + m->start[i] * LANES, entry_blocks(row) * LANES);
    const bool says = diagonal > 0;
    m->diagonal[i] = says ? diagonal : 0;
    m->blocks[i] = says ? (uint32_t)entry_blocks(row) : 0;
    y->b[i] = says ? b : 0;
}

INLINE void difference_matrix_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    Matrix *m = &s->system->matrix;
    const Stencil stencil = stencil_of(s, i, how);
    const Mixture density = mixture_of_densities(model);
    const double rho = mixed(density, s->colour[i]);
    Lanes sum[3][3] = {0};
    double u[3], flux = 0, above = 0;
    for (int d = 0; d < how.dim; d++) u[d] = s->v[d][i * s->v_step];
    for (size_t k = 0; k < row->n; k++) {
        const Block *b = &row->block[k];
        const bool images = are_images(row, b);
        double colour[LANES], v[3][LANES];
        float c[LANES];
        gather(s->colour, row_j(row, b), colour);
        gather_velocities(row, b, s, how, v);
        if (images) add_body_force(row, b, s, model, 2 * model->dt, how, v);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            double x[3];
            const double its = mixed(density, colour[l]);
            for (int d = 0; d < how.dim; d++) x[d] = b->x[d][l];
            c[l] = (float)(2 * LAPLACIAN_WEIGHT(stencil, x, b->W[l], how) / (rho + its));
            for (int d = 0; d < how.dim; d++) {
                const double du = b->W[l] * (u[d] - v[d][l]);
                for (int e = 0; e < how.dim; e++) add_product(&sum[d][e], l, du, x[e], how);
            }
        }
        keep_entries(m, row, b, c);
        if (images) above += risen(row, b, s, model, c, how);
        if (model->tense) above += risen_by_tension(row, b, s, model, colour, c);
    }
    for (int d = 0; d < how.dim; d++) {
        double gradient[3];
        gradient_of(s, i, model, sum[d], how, gradient);
        flux += gradient[d];
    }
    end_row(s->system, row, above - flux);
}
ROW_FUNCTIONS(difference_matrix_row)

/* Of the mean over the fluid in sight, however little of it there is, and over h^2, so that it counts about as much as the row of a fluid
 * particle: by the sums themselves the rows of walls that only the rim of a kernel reaches would be 1e-19 of others, which no residual sees,
 * and multigrid's cycles would make what rounding leaves there large. A wall particle that is hidden says nothing. */
INLINE void difference_wall_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const WallState *wall = &model->wall[s->phase[i] - model->n_phases];
    Matrix *m = &s->system->matrix;
    const double h = model->kernel.h, rho = density_around(s, model, i);
    const Mixture density = mixture_of_densities(model);
    double seen = 0, flux = 0;
    if (mirrors_hide(model, s, i)) {
        m->diagonal[i] = s->system->b[i] = 0;
        m->blocks[i] = 0;
        return;
    }
    for (size_t k = 0; k < row->n; k++)
        for (int l = 0; l < LANES; l++) seen += row->block[k].W[l];
    const double scale = seen > 0 ? 1 / (h * h * seen) : 0;
    for (size_t k = 0; k < row->n; k++) {
        const Block *b = &row->block[k];
        double colour[LANES];
        float c[LANES];
        gather(s->colour, row_j(row, b), colour);
        for (size_t l = 0; l < LANES; l++) {
            double along = 0;
            const double mean = 0.5 * (rho + mixed(density, colour[l]));
            for (int d = 0; d < how.dim; d++)
                along += model->dt * (body_force_of(model, mean, d) - wall->a[d]) * b->x[d][l];
            c[l] = (float)(scale * b->W[l] / mean);
            flux += scale * b->W[l] * along;
        }
        keep_entries(m, row, b, c);
        if (are_images(row, b)) flux += risen(row, b, s, model, c, how);
        if (model->tense) flux += risen_by_tension(row, b, s, model, colour, c);
    }
    end_row(s->system, row, flux);
}
ROW_FUNCTIONS(difference_wall_row)

INLINE void difference_correction_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    double change[3];
    gradient_over_density(row, s, model, s->system->x, true, how, change);
    for (int d = 0; d < how.dim; d++) s->colour_gradient[d][i] = change[d];
}
ROW_FUNCTIONS(difference_correction_row)

static void correct_velocity(Particles *s, const Model *model, size_t first, size_t last)
{
    (void)model;
    for (int d = 0; d < s->dim; d++)
        for (size_t i = first; i < last; i++) s->v[d][i * s->v_step] -= s->colour_gradient[d][i];
}

const Term difference_matrix = {
    .name = "pressure system",
    .source = "P5 eq. 23, 24",
    .equation = "2 dim/D_i sum_j 2 k_ij/(rho~_i + rho~_j) (P_j - P_i) = sum_j W (u_i - u_j) . B_i x",
    .on = ON_FLUID,
    .needs = NEED_W | NEED_V,
    .row = ROW_TABLE(difference_matrix_row),
};

const Term difference_wall_matrix = {
    .name = "pressure system at walls",
    .source = "schemes/differences.md",
    .equation = "sum_f W (2 (P_w - P_f)/(rho~_w + rho~_f) - dt (b - a_w) . x_wf) = 0",
    .on = ON_WALL,
    .needs = NEED_W,
    .row = ROW_TABLE(difference_wall_row),
};

const Term difference_correction = {
    .name = "velocity correction",
    .source = "P5 eq. 21, 22",
    .equation = "du_i = B_i sum_j 2/(rho~_i + rho~_j) (P_i - P_j) W x",
    .on = ON_FLUID,
    .needs = NEED_W,
    .writes = FIELD(COLOUR_GRADIENT),
    .row = ROW_TABLE(difference_correction_row),
};

const Local corrected_velocity = {
    .name = "corrected velocity",
    .source = "P5 eq. 21, 22",
    .equation = "u_i -= du_i",
    .on = ON_FLUID,
    .apply = correct_velocity,
    .writes = FIELD(V),
};
