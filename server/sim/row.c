/* SPDX-License-Identifier: BSD-3-Clause */
/* Geometry of the pairs of one particle. */
#include "sim/row.h"
#include <math.h>
#include <string.h>

static void differences(Row *row, const double *restrict x, int d)
{
    const size_t n = row_whole(row->n);
    const double xi = x[row->i];
    const uint32_t *restrict j = row->j;
    double *restrict dx = row->dx[d];
#pragma omp simd
    for (size_t k = 0; k < n; k++) dx[k] = xi - x[j[k]];
}

static void nearest_images(Row *row, const Model *model, int d)
{
    const size_t n = row_whole(row->n);
    const double period = model->period[d], frequency = model->frequency[d];
    double *restrict dx = row->dx[d];
#pragma omp simd
    for (size_t k = 0; k < n; k++) dx[k] -= period * __builtin_rint(dx[k] * frequency);
}

static void distances(Row *row)
{
    const size_t n = row_whole(row->n);
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

/* Copy the neighbours of one group behind those before it, and pad them with the first of them. */
static size_t gather_group(Row *row, size_t n, const uint32_t *list, size_t count)
{
    memcpy(row->j + n, list, count * sizeof *list);
    const size_t last = n + count, whole = (last + ROW_LANES - 1) / ROW_LANES * ROW_LANES;
    for (size_t k = last; k < whole; k++) row->j[k] = list[0];
    return whole;
}

/* Put the padding out of the kernel's reach. */
static void hide_padding(Row *row, const uint16_t *end, double far)
{
    for (int g = 0; g < GROUPS; g++) {
        const size_t first = g ? row->end[g - 1] : 0, count = (size_t)(end[g] - (g ? end[g - 1] : 0));
        for (size_t k = first + count; k < row->end[g]; k++) row->r[k] = far;
    }
}

void row_build(Row *row, const Neighbours *nb, const Particles *s, const Model *model, size_t i)
{
    row->i = i;
    row->dim = s->dim;
    const uint32_t *list = neighbours_of(nb, i);
    const uint16_t *end = nb->end[i];
    size_t n = 0;
    for (int g = 0; g < GROUPS; g++) {
        const size_t first = g ? end[g - 1] : 0;
        row->end[g] = n = gather_group(row, n, list + first, end[g] - first);
    }
    row->n = n;
    for (int d = 0; d < s->dim; d++) {
        differences(row, s->x[d], d);
        if (model->period[d] > 0) nearest_images(row, model, d);
    }
    distances(row);
    hide_padding(row, end, 2 * model->kernel.support);
    kernel_eval(&model->kernel, row_whole(row->n), row->r, row->W, row->F);
}
