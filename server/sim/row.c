/* SPDX-License-Identifier: BSD-3-Clause */
/* Geometry of the pairs of one particle. */
#include "sim/row.h"
#include <math.h>

static void differences(Row *row, const double *restrict x, int d)
{
    const size_t n = row->n;
    const double xi = x[row->i];
    const uint32_t *restrict j = row->j;
    double *restrict dx = row->dx[d];
#pragma omp simd
    for (size_t k = 0; k < n; k++) dx[k] = xi - x[j[k]];
}

static void nearest_images(Row *row, const Model *model, int d)
{
    const size_t n = row->n;
    const double period = model->period[d], frequency = model->frequency[d];
    double *restrict dx = row->dx[d];
#pragma omp simd
    for (size_t k = 0; k < n; k++) dx[k] -= period * __builtin_rint(dx[k] * frequency);
}

static void distances(Row *row)
{
    const size_t n = row->n;
    double *restrict r = row->r;
    const double *restrict x = row->dx[0], *restrict y = row->dx[1], *restrict z = row->dx[2];
    if (row->dim == 2) {
#pragma omp simd
        for (size_t k = 0; k < n; k++) r[k] = sqrt(x[k] * x[k] + y[k] * y[k]);
    } else {
#pragma omp simd
        for (size_t k = 0; k < n; k++) r[k] = sqrt(x[k] * x[k] + y[k] * y[k] + z[k] * z[k]);
    }
}

void row_build(Row *row, const Neighbours *nb, const Particles *s, const Model *model, size_t i)
{
    row->i = i;
    row->dim = s->dim;
    row->j = neighbours_of(nb, i);
    for (int g = 0; g < GROUPS; g++) row->end[g] = nb->end[i][g];
    row->n = row->end[GROUP_WALL];
    for (int d = 0; d < s->dim; d++) {
        differences(row, s->x[d], d);
        if (model->period[d] > 0) nearest_images(row, model, d);
    }
    distances(row);
    kernel_eval(&model->kernel, row->n, row->r, row->W, row->F);
}
