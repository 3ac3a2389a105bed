/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of what neighbours are asked for, how it is laid out, and the loop that copies it. A new quantity is a bit of
 * NEED_..., a member of Block and a row of the table. */
#include "sim/bundle.h"
#include "base/array.h"
#include "sim/row.h"
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

/* One number of each neighbour: component d of a field, or made of fields. */
typedef struct Quantity {
    unsigned need; /* 0: always */
    int d;
    FieldId field;
    size_t to; /* bytes from the beginning of a Block */
    void (*make)(const Particles *, const Model *, int d, size_t first, size_t n, double *out); /* NULL: the field */
    Fields of;
    bool summed; /* 0 where density is not summed */
} Quantity;

#define TO(member) offsetof(Block, member)
#define VECTOR(need, id, member)                                                                                       \
    {need, 0, F_##id, TO(member[0]), NULL, FIELD(id), false},                                                          \
        {need, 1, F_##id, TO(member[1]), NULL, FIELD(id), false},                                                      \
    {                                                                                                                  \
        need, 2, F_##id, TO(member[2]), NULL, FIELD(id), false                                                         \
    }
#define SCALAR(need, id, member)                                                                                       \
    {                                                                                                                  \
        need, 0, F_##id, TO(member), NULL, FIELD(id), false                                                            \
    }

/* In families of what changes together; the last of a family says so. */
static const Quantity QUANTITIES[] = {
    VECTOR(0, X, x),
    VECTOR(NEED_V, V, v),
    {NEED_FLUX, 0, F_B, TO(q[0]), flux, FIELD(B) | FIELD(M), true},
    {NEED_FLUX, 1, F_B, TO(q[1]), flux, FIELD(B) | FIELD(M), true},
    {NEED_FLUX, 2, F_B, TO(q[2]), flux, FIELD(B) | FIELD(M), true},
    SCALAR(NEED_STATE, P, p),
    SCALAR(NEED_STATE, VOL, V),
    SCALAR(NEED_STATE, Z, z),
};
enum { N_QUANTITIES = sizeof QUANTITIES / sizeof *QUANTITIES, NOTHING = N_QUANTITIES };

/* Once a step, or with the density? */
static bool follows_density(size_t quantity)
{
    return QUANTITIES[quantity].need == NEED_STATE;
}

static void add(Bundles *b, size_t place, size_t quantity)
{
    Bundle *bundle = &b->bundle[place / 4];
    const Quantity *q = &QUANTITIES[quantity];
    bundle->quantity[place % 4] = (uint8_t)quantity;
    bundle->to[place % 4] = (uint16_t)(q->to / sizeof(double));
    bundle->needs |= q->need ? q->need : NEED_ALL;
    bundle->of |= q->of;
    bundle->summed = bundle->summed && q->summed;
}

static void lay_out(Bundles *b, int dim, unsigned needs)
{
    size_t wanted[N_QUANTITIES], n = 0;
    for (size_t k = 0; k < N_QUANTITIES; k++) {
        const Quantity *q = &QUANTITIES[k];
        if (q->d < dim && (q->need == 0 || q->need & needs)) wanted[n++] = k;
    }
    for (size_t k = 0; k < BUNDLES_MAX; k++) {
        b->bundle[k] = (Bundle){.summed = true, .stale = ON_ALL};
        for (int c = 0; c < 4; c++) {
            b->bundle[k].quantity[c] = NOTHING;
            b->bundle[k].to[c] = (uint16_t)(TO(nothing) / sizeof(double));
        }
    }
    size_t place = 0;
    for (size_t k = 0; k < n; k++) {
        const size_t rest = n - k, next = (place + 3) / 4 * 4;
        const bool new_family = k > 0 && follows_density(wanted[k]) != follows_density(wanted[k - 1]);
        if (new_family && (next + rest + 3) / 4 == (place + rest + 3) / 4) place = next;
        add(b, place++, wanted[k]);
    }
    b->n_bundles = (place + 3) / 4;
}

bool bundles_init(Bundles *b, size_t n, int dim, unsigned needs)
{
    lay_out(b, dim, needs);
    for (size_t k = 0; k < b->n_bundles; k++)
        if (!(b->bundle[k].data = array_new(n, sizeof *b->bundle[k].data))) {
            bundles_done(b);
            return false;
        }
    return true;
}

void bundles_done(Bundles *b)
{
    for (size_t k = 0; k < BUNDLES_MAX; k++) free(b->bundle[k].data);
    *b = (Bundles){0};
}

void bundles_stale(Bundles *b, Group group, Fields fields)
{
    for (size_t k = 0; k < b->n_bundles; k++)
        if (b->bundle[k].of & fields) b->bundle[k].stale |= 1u << group;
}

Fields bundles_fields(const Bundles *b, unsigned needs)
{
    Fields fields = 0;
    for (size_t k = 0; k < b->n_bundles; k++)
        if (b->bundle[k].needs & needs) fields |= b->bundle[k].of;
    return fields;
}

static const double *column(const Particles *s, const Model *model, size_t quantity, size_t first, size_t n,
                            double *room)
{
    if (quantity == NOTHING) {
        memset(room, 0, n * sizeof *room);
        return room;
    }
    const Quantity *q = &QUANTITIES[quantity];
    if (!q->make) return (const double *)particles_field(s, q->field, q->d) + first;
    q->make(s, model, q->d, first, n, room);
    return room;
}

/* At most CHUNK of them. */
static void pack(const Bundle *bundle, const Particles *s, const Model *model, size_t first, size_t n)
{
    double room[4][CHUNK];
    const double *from[4];
    for (int c = 0; c < 4; c++) from[c] = column(s, model, bundle->quantity[c], first, n, room[c]);
    const double *restrict a = from[0], *restrict b = from[1], *restrict c = from[2], *restrict d = from[3];
    double(*restrict to)[4] = bundle->data + first;
    for (size_t i = 0; i < n; i++) {
        to[i][0] = a[i];
        to[i][1] = b[i];
        to[i][2] = c[i];
        to[i][3] = d[i];
    }
}

/* Called by all threads of a team, which need not wait for each other. What only summed particles have is 0 in others for ever. */
static void pack_group(const Bundle *bundle, const Particles *s, const Model *model, int g)
{
    if (!(bundle->stale >> g & 1) || (bundle->summed && g != GROUP_SUMMATION)) return;
    const size_t last = s->begin[g + 1];
#pragma omp for schedule(static) nowait
    for (size_t first = s->begin[g]; first < last; first += CHUNK)
        pack(bundle, s, model, first, last - first < CHUNK ? last - first : CHUNK);
}

void bundles_refresh(Bundles *b, const Particles *s, const Model *model, unsigned needs, int threads)
{
    bool all_fresh = true;
    for (size_t k = 0; k < b->n_bundles; k++)
        all_fresh = all_fresh && !(b->bundle[k].needs & needs && b->bundle[k].stale);
    if (all_fresh) return;
#pragma omp parallel num_threads(threads)
    for (size_t k = 0; k < b->n_bundles; k++)
        for (int g = 0; g < GROUPS && b->bundle[k].needs & needs; g++) pack_group(&b->bundle[k], s, model, g);
    for (size_t k = 0; k < b->n_bundles; k++)
        if (b->bundle[k].needs & needs) b->bundle[k].stale = 0;
}

size_t bundles_bytes(const Bundles *b, size_t n)
{
    return b->n_bundles * n * sizeof *b->bundle[0].data;
}
