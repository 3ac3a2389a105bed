/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of what neighbours are asked for, and the loop that copies it. */
#include "sim/bundle.h"
#include "base/array.h"
#include <stdlib.h>
#include <string.h>

enum { CHUNK = 512 };

/* m_j w_j, the mass times the advection velocity w = dt/2 b of a particle with a stress. */
static void flux(const Particles *s, const Model *model, int d, size_t first, size_t n, double *restrict out)
{
    double half[UINT8_MAX + 1] = {0}; /* by index of fluid or wall */
    for (size_t k = 0; k < model->n_phases; k++)
        if (model->transport_stress && model->phase[k].summation) half[k] = 0.5 * model->dt;
    const double *restrict m = s->m + first, *restrict b = s->b[d] + first;
    const uint8_t *restrict phase = s->phase + first;
    for (size_t i = 0; i < n; i++) out[i] = m[i] * half[phase[i]] * b[i];
}

/* 1 / Gamma, 0 of walls, which have none. */
static void inverse_shepard(const Particles *s, const Model *model, int d, size_t first, size_t n, double *restrict out)
{
    (void)model, (void)d;
    const double *restrict shepard = s->shepard + first;
    for (size_t i = 0; i < n; i++) out[i] = shepard[i] > 0 ? 1 / shepard[i] : 0;
}

/* One number of each neighbour: component d of a field, or made of fields; 0 of a field that the scheme has not. */
typedef struct Quantity {
    FieldId field;
    int d;
    void (*make)(const Particles *, const Model *, int d, size_t first, size_t n, double *out); /* NULL: the field */
    Fields of;
    bool summed; /* 0 where density is not summed */
} Quantity;

#define IS(id, d)                                                                                                      \
    {                                                                                                                  \
        F_##id, d, NULL, FIELD(id), false                                                                              \
    }
#define FLUX(d)                                                                                                        \
    {                                                                                                                  \
        F_B, d, flux, FIELD(B) | FIELD(M), true                                                                        \
    }
static const Quantity QUANTITIES[] = {
    [CARRIED_X] = IS(X, 0),
    IS(X, 1),
    IS(X, 2),
    [CARRIED_V] = IS(V, 0),
    IS(V, 1),
    IS(V, 2),
    [CARRIED_P] = IS(P, 0),
    [CARRIED_VOLUME] = IS(VOL, 0),
    [CARRIED_Z] = IS(Z, 0),
    [CARRIED_Q] = FLUX(0),
    FLUX(1),
    FLUX(2),
    [CARRIED_SHEPARD] = {F_SHEPARD, 0, inverse_shepard, FIELD(SHEPARD), false},
    [CARRIED_GRADIENT] = IS(GRADIENT, 0),
    IS(GRADIENT, 1),
    IS(GRADIENT, 2),
    [CARRIED_NORMAL] = IS(NORMAL, 0),
    IS(NORMAL, 1),
    IS(NORMAL, 2),
};

static Bundle empty(int dim, int k)
{
    Bundle bundle = {.summed = true, .stale = ON_ALL};
    for (int c = 0; c < 4; c++) {
        const int what = BUNDLE_LAYOUT[dim - 2][k][c];
        if (what == CARRIED_NOTHING) continue;
        bundle.of |= QUANTITIES[what].of;
        bundle.summed = bundle.summed && QUANTITIES[what].summed;
    }
    return bundle;
}

bool bundles_init(Bundles *b, size_t n, int dim, unsigned needs, int threads)
{
    *b = (Bundles){.dim = dim};
    for (int k = 0; k < BUNDLES; k++) {
        b->bundle[k] = empty(dim, k);
        if (!(bundle_meets(dim, k) & needs)) continue;
        if (!(b->bundle[k].data = array_new_team(n, sizeof *b->bundle[k].data, threads))) {
            bundles_done(b);
            return false;
        }
    }
    return true;
}

void bundles_done(Bundles *b)
{
    for (int k = 0; k < BUNDLES; k++) free(b->bundle[k].data);
    *b = (Bundles){0};
}

void bundles_stale(Bundles *b, Group group, Fields fields)
{
    for (int k = 0; k < BUNDLES; k++)
        if (b->bundle[k].of & fields) b->bundle[k].stale |= 1u << group;
}

Fields bundles_fields(const Bundles *b, unsigned needs)
{
    Fields fields = 0;
    for (int k = 0; k < BUNDLES; k++)
        if (bundle_meets(b->dim, k) & needs) fields |= b->bundle[k].of;
    return fields;
}

static const double *column(const Particles *s, const Model *model, int what, size_t first, size_t n, double *room)
{
    const Quantity *q = what == CARRIED_NOTHING ? NULL : &QUANTITIES[what];
    const double *field = q ? particles_field(s, q->field, q->d) : NULL;
    if (!field) {
        memset(room, 0, n * sizeof *room);
        return room;
    }
    if (!q->make) return field + first;
    q->make(s, model, q->d, first, n, room);
    return room;
}

/* At most CHUNK of them. */
static void pack(double (*data)[4], const uint8_t what[4], const Particles *s, const Model *model, size_t first,
                 size_t n)
{
    double room[4][CHUNK];
    const double *from[4];
    for (int c = 0; c < 4; c++) from[c] = column(s, model, what[c], first, n, room[c]);
    const double *restrict a = from[0], *restrict b = from[1], *restrict c = from[2], *restrict d = from[3];
    double(*restrict to)[4] = data + first;
    for (size_t i = 0; i < n; i++) {
        to[i][0] = a[i];
        to[i][1] = b[i];
        to[i][2] = c[i];
        to[i][3] = d[i];
    }
}

/* Called by all threads of a team, which need not wait for each other. What only summed particles have is 0 in others for ever. */
static void pack_group(const Bundle *bundle, const uint8_t what[4], const Particles *s, const Model *model, int g)
{
    if (!(bundle->stale >> g & 1) || (bundle->summed && g != GROUP_SUMMATION)) return;
    const size_t last = s->begin[g + 1];
#pragma omp for schedule(static) nowait
    for (size_t first = s->begin[g]; first < last; first += CHUNK)
        pack(bundle->data, what, s, model, first, last - first < CHUNK ? last - first : CHUNK);
}

void bundles_refresh(Bundles *b, const Particles *s, const Model *model, unsigned needs, int threads)
{
    bool wanted[BUNDLES], any = false;
    for (int k = 0; k < BUNDLES; k++) {
        wanted[k] = b->bundle[k].data && bundle_meets(b->dim, k) & needs && b->bundle[k].stale;
        any = any || wanted[k];
    }
    if (!any) return;
#pragma omp parallel num_threads(threads)
    for (int k = 0; k < BUNDLES; k++)
        for (int g = 0; g < GROUPS && wanted[k]; g++)
            pack_group(&b->bundle[k], BUNDLE_LAYOUT[b->dim - 2][k], s, model, g);
    for (int k = 0; k < BUNDLES; k++)
        if (wanted[k]) b->bundle[k].stale = 0;
}

size_t bundles_bytes(const Bundles *b, size_t n)
{
    size_t bytes = 0;
    for (int k = 0; k < BUNDLES; k++)
        if (b->bundle[k].data) bytes += n * sizeof *b->bundle[k].data;
    return bytes;
}
