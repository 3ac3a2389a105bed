/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/bundle.h"

/* Bundles that hold something of what has changed: fields that are the same for a whole step, and those that follow density. */
static const unsigned MOTION_IN[4] = {[2] = 1 | 4, [3] = 1 | 2 | 4}, STATE_IN[4] = {[2] = 2, [3] = 4};

static unsigned bundles_for(int dim, unsigned needs)
{
    unsigned bundles = 1;
    if (dim == 2) {
        if (needs & NEED_STATE) bundles |= 2;
        if (needs & NEED_FLUX) bundles |= 4;
    } else {
        if (needs & (NEED_V | NEED_FLUX)) bundles |= 2;
        if (needs & (NEED_STATE | NEED_FLUX)) bundles |= 4;
    }
    return bundles;
}

static void pack2(const Particles *s, const double *carries, double half, unsigned which, size_t first, size_t last)
{
    double(*restrict to)[4] = NULL;
    if (which & 1) {
        to = s->bundle[0];
        for (size_t i = first; i < last; i++) {
            to[i][0] = s->x[0][i];
            to[i][1] = s->x[1][i];
            to[i][2] = s->v[0][i];
            to[i][3] = s->v[1][i];
        }
    }
    if (which & 2) {
        to = s->bundle[1];
        for (size_t i = first; i < last; i++) {
            to[i][0] = s->p[i];
            to[i][1] = s->vol[i];
            to[i][2] = s->z[i];
        }
    }
    if (which & 4) {
        to = s->bundle[2];
        for (size_t i = first; i < last; i++) {
            const double m = s->m[i] * carries[s->phase[i]] * half;
            to[i][0] = m * s->b[0][i];
            to[i][1] = m * s->b[1][i];
        }
    }
}

static void pack3(const Particles *s, const double *carries, double half, unsigned which, size_t first, size_t last)
{
    double(*restrict to)[4] = NULL;
    if (which & 1) {
        to = s->bundle[0];
        for (size_t i = first; i < last; i++) {
            to[i][0] = s->x[0][i];
            to[i][1] = s->x[1][i];
            to[i][2] = s->x[2][i];
            to[i][3] = s->v[0][i];
        }
    }
    if (which & 2) {
        to = s->bundle[1];
        for (size_t i = first; i < last; i++) {
            const double m = s->m[i] * carries[s->phase[i]] * half;
            to[i][0] = s->v[1][i];
            to[i][1] = s->v[2][i];
            to[i][2] = m * s->b[0][i];
            to[i][3] = m * s->b[1][i];
        }
    }
    if (which & 4) {
        to = s->bundle[2];
        for (size_t i = first; i < last; i++) {
            to[i][0] = s->p[i];
            to[i][1] = s->vol[i];
            to[i][2] = s->z[i];
            to[i][3] = s->m[i] * carries[s->phase[i]] * half * s->b[2][i];
        }
    }
}

void bundles_refresh(Particles *s, const Model *model, unsigned needs, int threads)
{
    const unsigned which = bundles_for(s->dim, needs) & s->stale;
    if (!which) return;
    double carries[256] = {0}; /* by index of fluid or wall: 1 with a stress */
    for (size_t k = 0; k < model->n_phases; k++)
        carries[k] = model->transport_stress && model->phase[k].summation ? 1 : 0;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t first = 0; first < s->n; first += 1024) {
        const size_t last = first + 1024 < s->n ? first + 1024 : s->n;
        (s->dim == 2 ? pack2 : pack3)(s, carries, 0.5 * model->dt, which, first, last);
    }
    s->stale &= ~which;
}

void bundles_moved(Particles *s)
{
    s->stale |= MOTION_IN[s->dim] | ((STALE_MARKS << GROUPS) - STALE_MARKS);
}

void bundles_compressed(Particles *s)
{
    s->stale |= STATE_IN[s->dim];
}
