/* SPDX-License-Identifier: BSD-3-Clause */
/* All pairs of one particle, laid out for the vector units: filled once, shared by all terms of a pass, and the sums over
 * it. Pairs in the skin have W = F = 0, so no term asks whether a pair is in range. The neighbours of each group are padded
 * to whole vectors with such pairs, so that loops have no remainder: 23 neighbours in three steps, not in eleven. */
#ifndef SIM_ROW_H
#define SIM_ROW_H

#include "sim/neighbours.h"

enum { ROW_LANES = 8 }; /* doubles in the widest vector register */
enum {
    ROW_STRIDE = ROW_MAX + GROUPS * ROW_LANES
}; /* not a power of two: arrays do not compete for the same cache sets */

typedef struct Row {
    size_t i, n;              /* the particle; how many pairs, padding included     */
    size_t end[GROUPS];       /* [0, end[g]) are neighbours of groups up to g       */
    int dim;                  /* 2 or 3                                             */
    uint32_t j[ROW_STRIDE];   /* [n]      neighbour indices                         */
    double dx[3][ROW_STRIDE]; /* [dim][n] x_i - x_j, nearest image       m          */
    double r[ROW_STRIDE];     /* [n]      |dx|                           m          */
    double W[ROW_STRIDE];     /* [n]      W(r, h)                        m^-dim     */
    double F[ROW_STRIDE];     /* [n]      (1/r) dW/dr: grad_i W = F dx   m^-dim-2   */
    double c[ROW_STRIDE];     /* [n]      coefficient of the term being summed      */
    double u[ROW_STRIDE];     /* [n]      work space of the term                    */
} Row;

/* n, said so that the compiler sees a number of whole vectors. */
static inline size_t row_whole(size_t n)
{
    return n & ~(size_t)(ROW_LANES - 1);
}

/* Geometry of all pairs of particle i. */
void row_build(Row *row, const Neighbours *nb, const Particles *s, const Model *model, size_t i);

/* u[k] = (f_i - f_j) . (x_i - x_j) for a vector field f. */
static inline void row_dot_difference(Row *row, double *const f[3])
{
    const size_t i = row->i, n = row_whole(row->n);
    const uint32_t *restrict j = row->j;
    double *restrict u = row->u;
    for (int d = 0; d < row->dim; d++) {
        const double *restrict fd = f[d], *restrict dx = row->dx[d];
        const double fi = fd[i];
        if (d == 0) {
#pragma omp simd
            for (size_t k = 0; k < n; k++) u[k] = (fi - fd[j[k]]) * dx[k];
        } else {
#pragma omp simd
            for (size_t k = 0; k < n; k++) u[k] += (fi - fd[j[k]]) * dx[k];
        }
    }
}

/* sum_k c[k] dx_d[k] over k in [first, last): forces along the line of centres. */
static inline double row_sum_along(const Row *row, int d, size_t first, size_t last)
{
    const double *restrict c = row->c, *restrict dx = row->dx[d];
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t k = row_whole(first); k < row_whole(last); k++) sum += c[k] * dx[k];
    return sum;
}

/* sum_k c[k] f_j over k in [first, last). */
static inline double row_sum_field(const Row *row, const double *f, size_t first, size_t last)
{
    const double *restrict c = row->c;
    const uint32_t *restrict j = row->j;
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t k = row_whole(first); k < row_whole(last); k++) sum += c[k] * f[j[k]];
    return sum;
}

/* sum_k c[k] over k in [first, last). */
static inline double row_sum(const Row *row, size_t first, size_t last)
{
    const double *restrict c = row->c;
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t k = row_whole(first); k < row_whole(last); k++) sum += c[k];
    return sum;
}

#endif
