/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/bundle.h"
#include "sim/level.h"

enum { CHUNK = 1024 };

/* m_i dt/2 for particles of fluids with a stress, else 0: what makes q_i of b_i. */
typedef struct Flux {
    double of[UINT8_MAX + 1]; /* dt/2 or 0, by index of fluid or wall */
} Flux;

INLINE double carried(const Particles *s, const Flux *flux, size_t i, int what)
{
    switch (what) {
    case CARRIED_X:
    case CARRIED_X + 1:
    case CARRIED_X + 2: return s->x[what - CARRIED_X][i];
    case CARRIED_V:
    case CARRIED_V + 1:
    case CARRIED_V + 2: return s->v[what - CARRIED_V][i];
    case CARRIED_P: return s->p[i];
    case CARRIED_VOLUME: return s->vol[i];
    case CARRIED_Z: return s->z[i];
    case CARRIED_Q:
    case CARRIED_Q + 1:
    case CARRIED_Q + 2: return s->m[i] * flux->of[s->phase[i]] * s->b[what - CARRIED_Q][i];
    default: return 0;
    }
}

INLINE void pack(const Particles *s, const Flux *flux, int k, size_t first, size_t last, int dim)
{
    const uint8_t *what = BUNDLE_LAYOUT[dim - 2][k];
    double(*restrict to)[4] = s->bundle[k];
    for (size_t i = first; i < last; i++) {
        to[i][0] = carried(s, flux, i, what[0]);
        to[i][1] = carried(s, flux, i, what[1]);
        to[i][2] = carried(s, flux, i, what[2]);
        to[i][3] = carried(s, flux, i, what[3]);
    }
}

INLINE void pack_some(const Particles *s, const Flux *flux, unsigned which, size_t first, size_t last, int dim)
{
    if (which & 1) pack(s, flux, 0, first, last, dim);
    if (which & 2) pack(s, flux, 1, first, last, dim);
    if (which & 4) pack(s, flux, 2, first, last, dim);
}

/* Bundles with something that serves these needs. */
static unsigned bundles_for(int dim, unsigned needs)
{
    unsigned bundles = 1;
    for (int k = 1; k < BUNDLES; k++)
        if (bundle_meets(dim, k) & needs) bundles |= 1u << k;
    return bundles;
}

void bundles_refresh(Particles *s, const Model *model, unsigned needs, int threads)
{
    const unsigned which = bundles_for(s->dim, needs) & s->stale;
    if (!which) return;
    Flux flux = {0};
    for (size_t k = 0; k < model->n_phases; k++)
        if (model->transport_stress && model->phase[k].summation) flux.of[k] = 0.5 * model->dt;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t first = 0; first < s->n; first += CHUNK) {
        const size_t last = first + CHUNK < s->n ? first + CHUNK : s->n;
        if (s->dim == 2) pack_some(s, &flux, which, first, last, 2);
        else pack_some(s, &flux, which, first, last, 3);
    }
    s->stale &= ~which;
}

void bundles_moved(Particles *s)
{
    s->stale |= 1 | bundles_for(s->dim, NEED_V | NEED_FLUX) | ((STALE_MARKS << GROUPS) - STALE_MARKS);
}

void bundles_compressed(Particles *s)
{
    s->stale |= bundles_for(s->dim, NEED_STATE) & ~1u;
}
