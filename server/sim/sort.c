/* SPDX-License-Identifier: BSD-3-Clause */
/* Two stable counting sorts: all threads sort into buckets of consecutive cells, then each sorts buckets of its own by cell. Counts
 * of each thread for each cell would take more memory than the particles where there are many threads. */
#include "sim/sort.h"
#include <assert.h>
#include <omp.h>
#include <string.h>

/* A particle and its cell. */
typedef struct Place {
    uint32_t key, index;
} Place;

_Static_assert(sizeof(Place) == SORT_BYTES_PER_PARTICLE && 2 * sizeof(uint32_t) == SORT_BYTES_PER_PARTICLE, "rooms");

typedef struct Sort {
    const Particles *s;
    const Grid *grid;
    size_t number[GROUPS]; /* of each group */
    size_t keys, buckets;
    unsigned shift;   /* bucket = key >> shift */
    uint32_t *start;  /* [keys + 1] */
    uint32_t *counts; /* [1 + threads][SORT_BUCKETS_MAX + 1]: where buckets begin, then for each thread */
    Place *place;     /* [n] by bucket */
    uint32_t *key;    /* [n] of each particle */
    uint32_t *order;  /* [n] the result */
} Sort;

size_t sort_counts(int threads)
{
    return ((size_t)threads + 1) * (SORT_BUCKETS_MAX + 1);
}

size_t sort_group(const Particles *s, int group)
{
    size_t number = 0;
    for (int g = 0; g < group; g++) number += s->begin[g + 1] > s->begin[g];
    return number;
}

size_t sort_groups(const Particles *s)
{
    const size_t n = sort_group(s, GROUPS);
    return n > 0 ? n : 1; /* of nobody */
}

static int group_of(const Particles *s, size_t i)
{
    return i < s->begin[1] ? GROUP_CONTINUITY : i < s->begin[2] ? GROUP_SUMMATION : GROUP_WALL;
}

/* From how often each bucket occurs in the share of each thread to where its particles begin, over all threads and of each. One
 * thread does it, for 2048 buckets. */
static void sum_counts(const Sort *q, size_t team)
{
    const size_t stride = SORT_BUCKETS_MAX + 1;
    uint32_t sum = 0;
    for (size_t b = 0; b < q->buckets; b++) {
        q->counts[b] = sum;
        for (size_t t = 1; t <= team; t++) {
            const uint32_t count = q->counts[t * stride + b];
            q->counts[t * stride + b] = sum;
            sum += count;
        }
    }
    q->counts[q->buckets] = sum;
}

/* A fixed share of the particles for each thread, written behind those of the threads before it. */
static void sort_into_buckets(const Sort *q)
{
    const size_t me = (size_t)omp_get_thread_num(), team = (size_t)omp_get_num_threads();
    const size_t n = q->s->n, first = n * me / team, last = n * (me + 1) / team;
    uint32_t *mine = q->counts + (me + 1) * (SORT_BUCKETS_MAX + 1);
    memset(mine, 0, (SORT_BUCKETS_MAX + 1) * sizeof *mine);
    for (size_t i = first; i < last; i++) {
        const double x[3] = {q->s->ref[0][i], q->s->ref[1][i], q->s->dim == 3 ? q->s->ref[2][i] : 0};
        q->key[i] = (uint32_t)(q->number[group_of(q->s, i)] * q->grid->cells + grid_cell(q->grid, x));
        mine[q->key[i] >> q->shift]++;
    }
#pragma omp barrier
#pragma omp single
    sum_counts(q, team);
    for (size_t i = first; i < last; i++) q->place[mine[q->key[i] >> q->shift]++] = (Place){q->key[i], (uint32_t)i};
#pragma omp barrier
}

static void sort_bucket(const Sort *q, size_t b)
{
    const size_t first_key = b << q->shift, end_key = first_key + ((size_t)1 << q->shift);
    const size_t last_key = end_key < q->keys ? end_key : q->keys;
    const uint32_t first = q->counts[b], last = q->counts[b + 1];
    uint32_t *restrict start = q->start, sum = first;
    memset(start + first_key, 0, (last_key - first_key) * sizeof *start);
    for (uint32_t k = first; k < last; k++) start[q->place[k].key]++;
    for (size_t key = first_key; key < last_key; key++) {
        const uint32_t count = start[key];
        start[key] = sum;
        sum += count;
    }
    for (uint32_t k = first; k < last; k++) q->order[start[q->place[k].key]++] = q->place[k].index;
    for (size_t key = last_key - 1; key > first_key; key--) start[key] = start[key - 1]; /* each is at its end now */
    start[first_key] = first;
}

uint32_t *sort_by_cell(const Particles *s, const Grid *grid, uint32_t *start, uint32_t *counts, void *room, void *other,
                       int threads)
{
    Sort q = {
        .s = s, .grid = grid, .keys = sort_groups(s) * grid->cells, .start = start, .counts = counts, .place = other};
    for (int g = 0; g < GROUPS; g++) q.number[g] = sort_group(s, g);
    q.key = room;
    q.order = q.key + s->n;
    assert(q.keys <= UINT32_MAX); /* grid_make() makes no more cells */
    while ((q.keys - 1) >> q.shift >= SORT_BUCKETS_MAX) q.shift++;
    q.buckets = ((q.keys - 1) >> q.shift) + 1;
#pragma omp parallel num_threads(threads)
    {
        sort_into_buckets(&q);
#pragma omp for schedule(dynamic, 8)
        for (size_t b = 0; b < q.buckets; b++) sort_bucket(&q, b);
    }
    start[q.keys] = (uint32_t)s->n;
    return q.order;
}
