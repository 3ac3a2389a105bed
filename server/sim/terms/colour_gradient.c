/* SPDX-License-Identifier: BSD-3-Clause */
/* Interfaces as gradients of the colour, and their curvature, positive where the first fluid is inside.                P5 eq. 14-16
 *   N_i = B_i sum_j 2 (C_i - C_j)/(rho~_i + rho~_j) W x,   n_i = N_i/|N_i| where rho~_i |N_i| > threshold/h, else none
 *   raw    kappa_i = sum_j (n_j - n_i) . B'_i W x over those that have a normal
 *   mean   kappa_i = sum_j w_j W kappa_j / sum_j w_j W,   w_j = (rho~_j |N_j| dx)^4,   i itself included
 * B' is that of these neighbours alone: with P5's, of all, curvatures are up to a tenth too small (schemes/differences.md). What the colour's own
 * kernel and the mean round off of waves is not given back as in curvature.c: it is too noisy here. */
#include "sim/terms/curvature.h"
#include "sim/terms/differences.h"
#include "sim/terms/images.h"
#include "sim/terms/terms.h"
#include <math.h>

INLINE void colour_gradient_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    double N[3];
    gradient_over_density(row, s, model, s->colour, false, how, N);
    const double size = sqrt(DOT(N, N, how)), rho = density_around(s, model, i);
    const double inverse = rho * size * model->kernel.h > model->differences.threshold ? 1 / size : 0;
    for (int d = 0; d < how.dim; d++) {
        s->colour_gradient[d][i] = N[d];
        s->normal[d][i * s->normal_step] = N[d] * inverse;
    }
}
ROW_FUNCTIONS(colour_gradient_row)

/* The trace of B' times sum_j (n_j - n_i) (x) W x. */
INLINE double curvature_of(const Row *row, const double n[3], const Particles *s, const Model *model, How how)
{
    Row room;
    const Row *seen = row_with_images(row, s, model, &room);
    Moments moments = {0};
    Lanes sum[3][3] = {0};
    for (const Block *b = seen->block; b < seen->block + seen->n_fluid; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double W = has_normal(&pair, how) * pair.W;
            moments_add(&moments, &pair, W, how, l);
            for (int d = 0; d < how.dim; d++) {
                const double turn = W * (pair.normal[d] - n[d]);
                for (int e = 0; e < how.dim; e++) add_product(&sum[d][e], l, turn, pair.x[e], how);
            }
        }
    const Correction B = moments_inverse_of(&moments, 1 / model->differences.scale, how);
    return corrected_trace(&B, sum, how) / model->differences.scale;
}

INLINE void colour_curvature_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const double rho = density_around(s, model, i);
    double n[3], q[3], *weight = curvature_weights(s);
    curvature_step(s)[i] = weight[i] = 0;
    for (int d = 0; d < how.dim; d++) {
        n[d] = s->normal[d][i * s->normal_step];
        q[d] = rho * s->colour_gradient[d][i];
    }
    if (!(DOT(n, n, how) > 0.5)) return;
    weight[i] = weight_of_interface(model, q, how);
    curvature_step(s)[i] = curvature_of(row, n, s, model, how);
}
ROW_FUNCTIONS(colour_curvature_row)

INLINE void mean_colour_curvature_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)how;
    const size_t i = row->i;
    const double *kappa = curvature_step(s), *weight = curvature_weights(s);
    double below = kernel_at_zero(&model->kernel) * weight[i], above = below * kappa[i];
    Row room;
    const Row *seen = row_with_images(row, s, model, &room);
    for (const Block *b = seen->block; b < seen->block + seen->n_fluid; b++) {
        const uint32_t *j = row_j(seen, b);
        for (int l = 0; l < LANES; l++) {
            const double c = b->W[l] * weight[j[l]];
            below += c;
            above += c * kappa[j[l]];
        }
    }
    s->curvature[i] = below > 0 ? above / below : 0;
}
ROW_FUNCTIONS(mean_colour_curvature_row)

const Term colour_gradient = {
    .name = "colour gradient",
    .source = "P5 eq. 14, 15",
    .equation =
        "N_i = B_i sum_j 2 (C_i - C_j)/(rho~_i + rho~_j) W x,  n_i = N_i/|N_i| where rho~_i |N_i| > threshold/h",
    .on = ON_FLUID,
    .needs = NEED_W,
    .writes = FIELD(COLOUR_GRADIENT) | FIELD(NORMAL),
    .row = ROW_TABLE(colour_gradient_row),
};

const Term colour_curvature = {
    .name = "curvature",
    .source = "P5 eq. 16",
    .equation = "k_i = sum_j (n_j - n_i) . B'_i W x over those with a normal",
    .on = ON_FLUID,
    .needed = is_tense,
    .needs = NEED_W | NEED_NORMAL,
    .row = ROW_TABLE(colour_curvature_row),
};

const Term mean_colour_curvature = {
    .name = "mean curvature",
    .source = "schemes/differences.md",
    .equation = "kappa_i = sum_j w_j W k_j / sum_j w_j W,  w_j = (rho~_j |N_j| dx)^4",
    .on = ON_FLUID,
    .needed = is_tense,
    .needs = NEED_W,
    .writes = FIELD(CURVATURE),
    .row = ROW_TABLE(mean_colour_curvature_row),
};
