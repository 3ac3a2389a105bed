/* SPDX-License-Identifier: BSD-3-Clause */
/* Generalized finite differences over the neighbours of a particle, weighted by the kernel.                        P5 eq. 8-11
 *   B_i = (sum_j W x (x) x)^-1,  o_i = B_i sum_j W x,  k_ij = W (1 - x . o_i),  D_i = sum_j r^2 k_ij,   x = x_i - x_j
 *   <grad f>_i = B_i sum_j (f_i - f_j) W x                      exact for linear f, however the neighbours lie
 *   <lap f>_i = 2 dim/D_i sum_j (f_j - f_i) k_ij                nothing of linear f, and exact for r^2 from anywhere
 * B is kept as `correction`, in units of dx^2 / V_0 and so of about 1 over the kernel's second moment. */
#ifndef SIM_TERMS_DIFFERENCES_H
#define SIM_TERMS_DIFFERENCES_H

#include "sim/terms/moments.h"

/* What is fixed in the differences of one particle. */
typedef struct Stencil {
    double offset[3], laplacian;
} Stencil;

INLINE Stencil stencil_of(const Particles *s, size_t i, How how)
{
    Stencil stencil = {.laplacian = s->laplacian[i]};
    for (int d = 0; d < how.dim; d++) stencil.offset[d] = s->offset[d][i * s->offset_step];
    return stencil;
}

/* 2 dim k_ij / D_i, of a stencil and arrays; a macro as DOT() is one, so that what it is given must be names. */
#define LAPLACIAN_WEIGHT(stencil, x, W, how) ((stencil).laplacian * (W) * (1 - DOT((stencil).offset, (x), (how))))

/* ret = B_i sum */
INLINE void gradient_of(const Particles *s, size_t i, const Model *model, const Lanes sum[3], How how, double ret[3])
{
    const double scale = 1 / model->differences.scale;
    double g[3] = {0};
    for (int d = 0; d < how.dim; d++) g[d] = scale * lanes_sum(&sum[d]);
    const double xy = s->correction_off[0][i];
    ret[0] = s->correction[0][i] * g[0] + xy * g[1];
    ret[1] = xy * g[0] + s->correction[1][i] * g[1];
    if (how.dim == 2) return;
    const double xz = s->correction_off[1][i], yz = s->correction_off[2][i];
    ret[0] += xz * g[2];
    ret[1] += yz * g[2];
    ret[2] = xz * g[0] + yz * g[1] + s->correction[2][i] * g[2];
}

/* A field of eight neighbours; before a loop, as compilers do not vectorise what is fetched from here and there. */
INLINE void gather(const double *f, const uint32_t *j, double ret[LANES])
{
    for (int l = 0; l < LANES; l++) ret[l] = f[j[l]];
}

/* Gravity on what is around a particle, less that on the fluid in which it floats. */
INLINE double body_force_of(const Model *model, double rho, int d)
{
    return (1 - model->differences.buoyancy / rho) * model->gravity[d];
}

/* P_j' - P_j = dt rho~_j b_j . (x_j' - x_j) of a block of images (mirrors.h): body forces b go on behind a mirror. */
INLINE void image_rises(const Row *row, const Block *b, const Particles *s, const Model *model, How how,
                        double ret[LANES])
{
    const uint32_t *j = row_j(row, b);
    for (int l = 0; l < LANES; l++) {
        const double rho = mixed(mixture_of_densities(model), s->colour[j[l]]);
        double along = 0;
        for (int d = 0; d < how.dim; d++) along += body_force_of(model, rho, d) * image_moved(row, b, l, s, model, d);
        ret[l] = model->dt * rho * along;
    }
}

/* What is added to the mirrored velocities of a block of images, as what body forces gave to velocities is not turned round; times: 2 dt. */
INLINE void add_body_force(const Row *row, const Block *b, const Particles *s, const Model *model, double times,
                           How how, double v[3][LANES])
{
    const uint32_t *j = row_j(row, b);
    const uint8_t *turned = row->turned + (size_t)(b - row->block) * LANES;
    for (int d = 0; d < how.dim; d++)
        for (int l = 0; l < LANES; l++) {
            const double rho = mixed(mixture_of_densities(model), s->colour[j[l]]);
            v[d][l] += turned[l] >> 2 * d & 3 ? times * body_force_of(model, rho, d) : 0;
        }
}

/* dt sigma kappa_ij (C_i - C_j) of a block of pairs: what tension makes of P_i - P_j, with the mean curvature of the two, or of the one that is fluid. */
INLINE void tension_rises(const Row *row, const Block *b, const Particles *s, const Model *model,
                          const double colour[LANES], double ret[LANES])
{
    const size_t i = row->i, n = particles_fluid(s);
    const uint32_t *j = row_j(row, b);
    const double scale = 0.5 * model->dt * model->tension[0][1], C = s->colour[i];
    for (int l = 0; l < LANES; l++) {
        const double its = s->curvature[j[l] < n ? j[l] : i], mine = i < n ? s->curvature[i] : its;
        ret[l] = scale * (mine + its) * (C - colour[l]);
    }
}

/* ret = B_i sum_j 2 (f_i - f_j)/(rho~_i + rho~_j) W x: grad f over the density between the two of each pair.  f: [n] by particle; rises: is it
 * a pressure, which jumps by the tension and is another at images? */
INLINE void gradient_over_density(const Row *row, const Particles *s, const Model *model, const double *f, bool rises,
                                  How how, double ret[3])
{
    const size_t i = row->i;
    const Mixture density = mixture_of_densities(model);
    const double f_i = f[i], rho = mixed(density, s->colour[i]);
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++) {
        double f_j[LANES], colour[LANES];
        gather(f, row_j(row, b), f_j);
        gather(s->colour, row_j(row, b), colour);
        if (rises && model->tense) {
            double rise[LANES];
            tension_rises(row, b, s, model, colour, rise);
            for (int l = 0; l < LANES; l++) f_j[l] += rise[l];
        }
        if (rises && are_images(row, b)) {
            double rise[LANES];
            image_rises(row, b, s, model, how, rise);
            for (int l = 0; l < LANES; l++) f_j[l] += rise[l];
        }
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double difference = 2 * b->W[l] * (f_i - f_j[l]) / (rho + mixed(density, colour[l]));
            for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, difference, b->x[d][l], how);
        }
    }
    gradient_of(s, i, model, sum, how, ret);
}

/* Density of what is around a particle. */
INLINE double density_around(const Particles *s, const Model *model, size_t i)
{
    return mixed(mixture_of_densities(model), s->colour[i]);
}

#endif
