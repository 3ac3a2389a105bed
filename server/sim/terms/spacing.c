/* SPDX-License-Identifier: BSD-3-Clause */
/* Particles go to where there are fewer, with velocities put right to first order.                     Xu, Stansby and Laurence 2009, P5 2.3
 *   dx_i = C U_i dt R_i,  R_i = <r>^2 sum_j x/r^3, <r> the mean of r,   at most dx/20;   u_i += dx_i . <grad u>_i
 *   U_i = max_j |u_j - u_i| within the support: with the largest speed of all, as printed, what only drifts is stirred, and a jet somewhere
 * stirs all else
 * Where the case says so, beside an interface only along it, dx_i -= (dx_i . n_i) n_i: a bubble slips by the rest through the fluid that it
 * rises in.
 * Rows read positions and velocities, so both ways wait in the places of what is found anew where the particles have gone to.
 * Not capped, two that are close throw each other several spacings away, and the run blows up for nearly all C (schemes/differences.md). The
 * gradient is of fluid alone, with the truncation tensor of that. */
#include "sim/terms/differences.h"
#include "sim/terms/terms.h"
#include <math.h>

static bool shifts(const Model *model)
{
    return model->differences.shifting > 0;
}

/* <r>^2 sum_j x/r^3 over all in the kernel's reach. */
INLINE void crowding(const Row *row, How how, double ret[3])
{
    Lanes sum[3] = {0}, distance = {0}, count = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double here = b->W[l] > 0 ? 1 : 0, c = here / (b->r[l] * b->r[l] * b->r[l]);
            count.of[l] += here;
            distance.of[l] += here * b->r[l];
            for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, c, b->x[d][l], how);
        }
    const double n = lanes_sum(&count), mean = n > 0 ? lanes_sum(&distance) / n : 0;
    for (int d = 0; d < how.dim; d++) ret[d] = mean * mean * lanes_sum(&sum[d]);
}

/* ret[d] = dx . grad u_d; returns the largest |u_j - u_i|. */
INLINE double carried(const Row *row, const Particles *s, const Model *model, const double dx[3], How how,
                      double ret[3])
{
    Moments moments = {0};
    Lanes sum[3][3] = {0}, fastest = {0};
    double u[3];
    for (int d = 0; d < how.dim; d++) u[d] = s->v[d][row->i * s->v_step];
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            double u2 = 0;
            moments_add(&moments, &pair, pair.W, how, l);
            for (int d = 0; d < how.dim; d++) {
                const double apart = u[d] - pair.v[d], du = pair.W * apart;
                u2 += apart * apart;
                for (int e = 0; e < how.dim; e++) add_product(&sum[d][e], l, du, pair.x[e], how);
            }
            u2 = pair.W > 0 ? u2 : 0;
            fastest.of[l] = u2 > fastest.of[l] ? u2 : fastest.of[l];
        }
    const double scale = 1 / model->differences.scale;
    const Correction B = moments_inverse_of(&moments, scale, how);
    for (int d = 0; d < how.dim; d++) {
        double gradient[3];
        correct(&B, sum[d], how, gradient);
        ret[d] = scale * DOT(dx, gradient, how);
    }
    double u2 = 0;
    for (int l = 0; l < LANES; l++) u2 = fastest.of[l] > u2 ? fastest.of[l] : u2;
    return sqrt(u2);
}

INLINE void spacing_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    double dx[3], du[3], n[3];
    crowding(row, how, dx);
    for (int d = 0; d < how.dim; d++) n[d] = s->normal[d][i * s->normal_step];
    const double through = DOT(dx, n, how);
    for (int d = 0; d < how.dim; d++) dx[d] -= model->differences.along * through * n[d];
    const double U = carried(row, s, model, dx, how, du), wanted = model->differences.shifting * U * model->dt;
    const double far = sqrt(DOT(dx, dx, how)), most = 0.05 * model->dx,
                 scale = wanted * far > most ? most / far : wanted;
    for (int d = 0; d < how.dim; d++) {
        s->correction[d][i] = scale * dx[d];
        s->colour_gradient[d][i] = scale * du[d];
    }
}
ROW_FUNCTIONS(spacing_row)

static void go(Particles *s, const Model *model, size_t first, size_t last)
{
    (void)model;
    for (int d = 0; d < s->dim; d++)
        for (size_t i = first; i < last; i++) {
            s->x[d][i * s->x_step] += s->correction[d][i];
            s->v[d][i * s->v_step] += s->colour_gradient[d][i];
        }
}

const Term even_spacing = {
    .name = "particle shifting",
    .source = "Xu et al. 2009, P5 2.3",
    .equation =
        "dx_i = C max|u_ij| dt <r>^2 sum_j x/r^3, at most dx/20, or along interfaces only;  du_i = dx_i . <grad u>_i",
    .on = ON_FLUID,
    .needed = shifts,
    .needs = NEED_W | NEED_V,
    .writes = FIELD(CORRECTION) | FIELD(COLOUR_GRADIENT),
    .row = ROW_TABLE(spacing_row),
};

const Local even_position = {
    .name = "shifted position",
    .source = "P5 2.3",
    .equation = "x_i += dx_i,  u_i += du_i",
    .on = ON_FLUID,
    .needed = shifts,
    .apply = go,
    .writes = FIELD(X) | FIELD(V),
};
