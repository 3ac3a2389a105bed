/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of what neighbours are asked for, and the loop that copies it. */
#include "sim/bundle.h"
#include "base/array.h"
#include <stdlib.h>
#include <string.h>

enum { CHUNK = 512 };

/* 1 / Gamma, 0 of walls, which have none. */
static void inverse_shepard(const Particles *s, const Model *model, int d, size_t first, size_t n, double *restrict out)
{
    (void)model, (void)d;
    const double *restrict shepard = s->shepard + first;
    for (size_t i = 0; i < n; i++) out[i] = shepard[i] > 0 ? 1 / shepard[i] : 0;
}

/* What is stored nowhere: particles of a range are all fluid, or all wall. */
static void volume(const Particles *s, const Model *model, int d, size_t first, size_t n, double *restrict out)
{
    (void)d;
    const double *restrict m = s->m + first, *restrict rho = s->rho + first;
    const bool fluid = first < particles_fluid(s);
    for (size_t i = 0; i < n; i++) out[i] = fluid ? m[i] / rho[i] : model->cell_volume;
}

static void impedance(const Particles *s, const Model *model, int d, size_t first, size_t n, double *restrict out)
{
    (void)d;
    for (size_t i = 0; i < n; i++) out[i] = particles_impedance(s, model, first + i);
}

/* One number of each neighbour: component d of a field, or made of fields; 0 of a field that the scheme has not, unless something that no
 * neighbour asks for is at home there. Where a scheme has what may be there instead, neighbours are asked for that. */
typedef struct Quantity {
    FieldId field;
    int d;
    void (*make)(const Particles *, const Model *, int d, size_t first, size_t n, double *out); /* NULL: the field */
    Fields of;
    FieldId instead; /* of schemes that have this one; the same: none is */
    Fields guests;   /* fields of schemes that have not this one, component d of which may be at home in its place */
} Quantity;

#define IS(id, d)                                                                                                      \
    {                                                                                                                  \
        F_##id, d, NULL, FIELD(id), F_##id, 0                                                                          \
    }
#define IS_OR(id, d, other, guests)                                                                                    \
    {                                                                                                                  \
        F_##id, d, NULL, FIELD(id) | FIELD(other), F_##other, guests                                                   \
    }
static const Quantity QUANTITIES[CARRIED_END] = {
    [CARRIED_X] = IS(X, 0),
    IS(X, 1),
    IS(X, 2),
    [CARRIED_V] = IS(V, 0),
    IS(V, 1),
    IS(V, 2),
    [CARRIED_P] = IS(P, 0),
    [CARRIED_VOLUME] = {F_VOL, 0, volume, FIELD(M) | FIELD(RHO), F_VOL, 0},
    [CARRIED_Z] = {F_Z, 0, impedance, FIELD(RHO), F_Z, 0},
    [CARRIED_SHEPARD] = {F_SHEPARD, 0, inverse_shepard, FIELD(SHEPARD), F_SHEPARD, 0},
    [CARRIED_GRADIENT] = IS_OR(GRADIENT, 0, STRAIN, FIELD(OFFSET)),
    IS_OR(GRADIENT, 1, STRAIN, FIELD(OFFSET)),
    IS_OR(GRADIENT, 2, STRAIN, FIELD(OFFSET)),
    [CARRIED_NORMAL] = IS_OR(NORMAL, 0, STRAIN_OFF, 0),
    IS_OR(NORMAL, 1, STRAIN_OFF, 0),
    IS_OR(NORMAL, 2, STRAIN_OFF, 0),
};

static bool has(const Particles *s, FieldId field, int d)
{
    return s->made >> field & 1 || particles_field(s, (int)field, d);
}

static bool is_there(const Particles *s, const Quantity *q)
{
    return has(s, q->field, q->d) || has(s, q->instead, q->d);
}

/* Which quantity is at a place of the layout; CARRIED_NOTHING if none is. */
static int quantity_at(const Bundles *b, int k, int c)
{
    return BUNDLE_LAYOUT[b->dim - 2][k][c];
}

static void drop(Bundles *b, int k)
{
    free(b->data[k]);
    b->data[k] = NULL;
}

static bool allocate(Bundles *b, size_t n, unsigned needs, int threads)
{
    for (int k = 0; k < BUNDLES; k++) {
        if (b->data[k] || !(bundle_meets(b->dim, k) & needs)) continue;
        if (!(b->data[k] = array_new_team(n, sizeof *b->data[k], threads))) return false;
    }
    return true;
}

bool bundles_add(Bundles *b, size_t n, unsigned needs, int threads)
{
    unsigned before = 0;
    for (int k = 0; k < BUNDLES; k++) before |= b->data[k] ? 1u << k : 0;
    for (int q = 0; q < CARRIED_END; q++) b->stale[q] = ON_ALL;
    if (allocate(b, n, needs, threads)) return true;
    for (int k = 0; k < BUNDLES; k++)
        if (!(before >> k & 1)) drop(b, k);
    return false;
}

void bundles_keep(Bundles *b, unsigned needs)
{
    for (int k = 0; k < BUNDLES; k++)
        if (!(bundle_meets(b->dim, k) & needs)) drop(b, k);
}

bool bundles_init(Bundles *b, size_t n, int dim, unsigned needs, int threads)
{
    *b = (Bundles){.dim = dim};
    if (bundles_add(b, n, needs, threads)) return true;
    bundles_done(b);
    return false;
}

void bundles_done(Bundles *b)
{
    for (int k = 0; k < BUNDLES; k++) drop(b, k);
    *b = (Bundles){0};
}

void bundles_stale(Bundles *b, Group group, Fields fields)
{
    for (int q = 0; q < CARRIED_END; q++)
        if (QUANTITIES[q].of & fields) b->stale[q] |= 1u << group;
}

Fields bundles_fields(const Bundles *b, unsigned needs)
{
    Fields fields = 0;
    for (int k = 0; k < BUNDLES; k++)
        for (int c = 0; c < 4 && bundle_meets(b->dim, k) & needs; c++) fields |= QUANTITIES[quantity_at(b, k, c)].of;
    return fields;
}

static const double *column(const Particles *s, const Model *model, int what, size_t first, size_t n, double *room)
{
    const Quantity *q = &QUANTITIES[what];
    if (!q->make)
        return (const double *)particles_field(s, (int)(has(s, q->instead, q->d) ? q->instead : q->field), q->d) +
               first;
    q->make(s, model, q->d, first, n, room);
    return room;
}

enum { WHOLE = 15 }; /* all four places of a bundle */

/* At most CHUNK of them. places: which, as bits; what a whole bundle has nothing for is 0. */
static void pack(double (*data)[4], unsigned places, const int what[4], const Particles *s, const Model *model,
                 size_t first, size_t n)
{
    static const double nothing[CHUNK];
    double room[4][CHUNK];
    const double *from[4] = {nothing, nothing, nothing, nothing};
    double(*restrict to)[4] = data + first;
    for (int c = 0; c < 4; c++)
        if (what[c] != CARRIED_NOTHING && places >> c & 1) from[c] = column(s, model, what[c], first, n, room[c]);
    if (places == WHOLE) {
        const double *restrict a = from[0], *restrict b = from[1], *restrict c = from[2], *restrict d = from[3];
        for (size_t i = 0; i < n; i++) {
            to[i][0] = a[i];
            to[i][1] = b[i];
            to[i][2] = c[i];
            to[i][3] = d[i];
        }
        return;
    }
    for (int c = 0; c < 4; c++)
        for (size_t i = 0; i < n && places >> c & 1; i++) to[i][c] = from[c][i];
}

/* What of bundle k has changed in a group; what it has nothing for goes along where that makes it whole. */
typedef struct Packing {
    unsigned places;
    int what[4];
} Packing;

/* Fields whose component may be at home in the place of a quantity. */
static Fields residents(int what)
{
    if (what == CARRIED_NOTHING || QUANTITIES[what].make) return 0;
    return QUANTITIES[what].guests | UINT64_C(1) << QUANTITIES[what].field;
}

/* Is it of a field that has no other place? */
static bool lives_here(const Particles *s, int what)
{
    return s->housed & residents(what);
}

static Packing packing_of(const Bundles *b, const Particles *s, int k, int g)
{
    Packing packing = {0};
    unsigned empty = 0;
    for (int c = 0; c < 4; c++) {
        const int what = quantity_at(b, k, c);
        const bool there = what != CARRIED_NOTHING && is_there(s, &QUANTITIES[what]);
        packing.what[c] = there ? what : CARRIED_NOTHING;
        if (lives_here(s, what)) continue;
        if (packing.what[c] == CARRIED_NOTHING) empty |= 1u << c;
        else if (b->stale[what] >> g & 1) packing.places |= 1u << c;
    }
    if (packing.places && (packing.places | empty) == WHOLE) packing.places = WHOLE;
    return packing;
}

/* Called by all threads of a team, which need not wait for each other. */
static void pack_group(const Bundles *b, int k, const Particles *s, const Model *model, int g)
{
    const Packing packing = packing_of(b, s, k, g);
    const size_t last = packing.places ? s->begin[g + 1] : 0;
#pragma omp for schedule(static) nowait
    for (size_t first = s->begin[g]; first < last; first += CHUNK)
        pack(b->data[k], packing.places, packing.what, s, model, first, last - first < CHUNK ? last - first : CHUNK);
}

static bool is_stale(const Bundles *b, const Particles *s, int k)
{
    unsigned groups = 0;
    for (int c = 0; c < 4; c++)
        if (!lives_here(s, quantity_at(b, k, c))) groups |= b->stale[quantity_at(b, k, c)];
    return groups;
}

void bundles_refresh(Bundles *b, const Particles *s, const Model *model, unsigned needs, int threads)
{
    bool wanted[BUNDLES], any = false;
    for (int k = 0; k < BUNDLES; k++) {
        wanted[k] = b->data[k] && bundle_meets(b->dim, k) & needs && is_stale(b, s, k);
        any = any || wanted[k];
    }
    if (!any) return;
#pragma omp parallel num_threads(threads)
    for (int k = 0; k < BUNDLES; k++)
        for (int g = 0; g < GROUPS && wanted[k]; g++) pack_group(b, k, s, model, g);
    for (int k = 0; k < BUNDLES; k++)
        for (int c = 0; c < 4 && wanted[k]; c++) b->stale[quantity_at(b, k, c)] = 0;
}

double *bundles_place(const Bundles *b, int field, int d)
{
    for (int k = 0; k < BUNDLES; k++)
        for (int c = 0; c < 4 && b->data[k]; c++) {
            const int what = quantity_at(b, k, c);
            if (residents(what) >> field & 1 && QUANTITIES[what].d == d) return &b->data[k][0][c];
        }
    return NULL;
}

/* Is another of these fields at a place that would be this one's? */
static bool is_ousted(int what, int field, Fields of)
{
    const Quantity *q = &QUANTITIES[what];
    return q->field == (FieldId)field && q->instead != q->field && of >> q->instead & 1;
}

unsigned bundles_with(int dim, int field, Fields of)
{
    const Bundles any = {.dim = dim};
    unsigned found = 0;
    for (int k = 0; k < BUNDLES; k++)
        for (int c = 0; c < 4; c++) {
            const int what = quantity_at(&any, k, c);
            if (residents(what) >> field & 1 && !is_ousted(what, field, of)) found |= 1u << k;
        }
    return found;
}

size_t bundles_bytes(const Bundles *b, size_t n)
{
    size_t bytes = 0;
    for (int k = 0; k < BUNDLES; k++)
        if (b->data[k]) bytes += n * sizeof *b->data[k];
    return bytes;
}
