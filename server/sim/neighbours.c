/* SPDX-License-Identifier: BSD-3-Clause */
/* Neighbour lists: a stable counting sort by group and cell, then a search of the cells around each cell. */
#include "sim/neighbours.h"
#include "base/array.h"
#include "sim/select.h"
#include <omp.h>
#include <stdlib.h>
#include <string.h>

enum { MARK_WORDS_MAX = ROW_MAX / 32 + 2 };

MnsStatus neighbours_init(Neighbours *nb, size_t n, int threads, MnsError *error)
{
    *nb = (Neighbours){.n = n, .threads = threads};
    nb->offset = array_new(n, sizeof *nb->offset);
    nb->owner = array_new(n, sizeof *nb->owner);
    nb->end = array_new(n, sizeof *nb->end);
    nb->arena = calloc((size_t)threads, sizeof *nb->arena);
    if (nb->offset && nb->owner && nb->end && nb->arena) return MNS_OK;
    neighbours_done(nb);
    return mns_fail(error, MNS_E_MEMORY, "no memory for the neighbour lists of %zu particles", n);
}

void neighbours_done(Neighbours *nb)
{
    for (int k = 0; nb->arena && k < nb->threads; k++) free(nb->arena[k].data);
    free(nb->arena);
    free(nb->offset);
    free(nb->owner);
    free(nb->end);
    free(nb->start);
    *nb = (Neighbours){0};
}

static Group group_of(const Particles *s, size_t i)
{
    return i < s->begin[1] ? GROUP_CONTINUITY : i < s->begin[2] ? GROUP_SUMMATION : GROUP_WALL;
}

static bool reserve(Neighbours *nb, size_t keys)
{
    const size_t wanted = (keys + 1) * (size_t)(nb->threads + 1);
    if (wanted <= nb->start_capacity) return true;
    uint32_t *start = realloc(nb->start, wanted * sizeof *start);
    if (!start) return false;
    nb->start = start;
    nb->start_capacity = wanted;
    return true;
}

/* From how often each key occurs in the share of each thread, counts[team][keys + 1], to where its particles begin: over all
 * threads in start[keys + 1], and of each in its counts. Every thread takes a share of the keys; called by all of them. */
static void sum_counts(uint32_t *start, uint32_t *counts, size_t keys, size_t me, size_t team)
{
    const size_t stride = keys + 1, first = keys * me / team, last = keys * (me + 1) / team;
    uint32_t *const total = counts + keys; /* [t * stride]: of the keys of thread t */
    uint32_t sum = 0;
    for (size_t t = 0; t < team; t++)
        for (size_t k = first; k < last; k++) sum += counts[t * stride + k];
    total[me * stride] = sum;
#pragma omp barrier
    sum = 0;
    for (size_t t = 0; t < me; t++) sum += total[t * stride];
    for (size_t k = first; k < last; k++) {
        start[k] = sum;
        for (size_t t = 0; t < team; t++) {
            const uint32_t count = counts[t * stride + k];
            counts[t * stride + k] = sum;
            sum += count;
        }
    }
    if (me + 1 == team) start[keys] = sum;
}

/* Each thread takes a fixed share of the particles, counts its keys, and later writes its particles behind those of the
 * threads before it: the order within a key is the order of storage whatever the number of threads. */
static void counting_sort(Neighbours *nb, const Particles *s, const Grid *grid, size_t keys, uint32_t *order,
                          uint32_t *key)
{
    const size_t n = s->n, stride = keys + 1;
    uint32_t *const counts = nb->start + stride; /* [threads][keys + 1], behind the result */
#pragma omp parallel num_threads(nb->threads)
    {
        const size_t me = (size_t)omp_get_thread_num(), team = (size_t)omp_get_num_threads();
        const size_t first = n * me / team, last = n * (me + 1) / team;
        uint32_t *mine = counts + me * stride;
        memset(mine, 0, stride * sizeof *mine);
        for (size_t i = first; i < last; i++) {
            const double x[3] = {s->ref[0][i], s->ref[1][i], s->dim == 3 ? s->ref[2][i] : 0};
            key[i] = (uint32_t)((size_t)group_of(s, i) * grid->cells + grid_cell(grid, x));
            mine[key[i]]++;
        }
#pragma omp barrier
        sum_counts(nb->start, counts, keys, me, team);
#pragma omp barrier
        for (size_t i = first; i < last; i++) order[mine[key[i]]++] = (uint32_t)i;
    }
}

static bool arena_reserve(Arena *arena, size_t more)
{
    if (arena->used + more <= arena->capacity) return true;
    size_t capacity = arena->capacity ? arena->capacity : 4096;
    while (capacity < arena->used + more) capacity += capacity / 2;
    uint32_t *data = realloc(arena->data, capacity * sizeof *data);
    if (!data) return false;
    arena->data = data;
    arena->capacity = capacity;
    return true;
}

/* What the search of one cell needs. */
typedef struct Search {
    const Particles *s;
    const Model *model;
    double distance2;
    const uint32_t *start; /* of the group that is searched */
    const Run *runs;
    int n_runs;
} Search;

/* Append the members of one group within reach of i to list, by nearest images; returns how many. */
static size_t search_periodic(const Search *q, size_t i, uint32_t *restrict list)
{
    const double *const *ref = (const double *const *)q->s->ref;
    const int dim = q->s->dim;
    const double xi = ref[0][i], yi = ref[1][i], zi = dim == 3 ? ref[2][i] : 0;
    const double *x = ref[0], *y = ref[1], *z = dim == 3 ? ref[2] : ref[0];
    const double flat = dim == 3 ? 1 : 0;
    size_t n = 0;
    for (int k = 0; k < q->n_runs; k++) {
        const uint32_t last = q->start[q->runs[k].last + 1];
        for (uint32_t j = q->start[q->runs[k].first]; j < last; j++) {
            const double dx = model_nearest(q->model, 0, xi - x[j]), dy = model_nearest(q->model, 1, yi - y[j]),
                         dz = model_nearest(q->model, 2, (zi - z[j]) * flat);
            list[n] = j;
            n += (size_t)((dx * dx + dy * dy + dz * dz < q->distance2) & (j != i));
        }
    }
    return n;
}

/* Append the members of one group within reach of i to list; returns how many. */
static size_t search_group(const Search *q, size_t i, uint32_t *restrict list)
{
    if (q->model->periodic) return search_periodic(q, i, list);
    const Particles *s = q->s;
    const Points points = {s->ref[0], s->ref[1], s->dim == 3 ? s->ref[2] : NULL};
    const double at[3] = {s->ref[0][i], s->ref[1][i], s->dim == 3 ? s->ref[2][i] : 0};
    size_t n = 0;
    for (int k = 0; k < q->n_runs; k++)
        n += select_near(q->model->level, &points, q->start[q->runs[k].first], q->start[q->runs[k].last + 1], at,
                         q->distance2, (uint32_t)i, list + n);
    return n;
}

static size_t candidates(const Search *q)
{
    size_t n = 0;
    for (int k = 0; k < q->n_runs; k++) n += q->start[q->runs[k].last + 1] - q->start[q->runs[k].first];
    return n;
}

/* What went wrong in a search: no memory, or the smallest id of the particles with too many neighbours. */
typedef struct Trouble {
    bool no_memory;
    uint32_t crowded; /* UINT32_MAX: none */
} Trouble;

/* Lists of all particles of one group in one cell. A list that is too long is cut, so that what can be read is safe. */
static void search_cell(Neighbours *nb, Arena *arena, Search q, Group group, size_t cell, size_t cells,
                        Trouble *trouble)
{
    const uint32_t *own = nb->start + (size_t)group * cells;
    const int targets = group == GROUP_WALL ? GROUP_WALL : GROUPS;
    for (size_t i = own[cell]; i < own[cell + 1]; i++) {
        size_t n = 0;
        const size_t offset = arena->used;
        for (int target = 0; target < GROUPS; target++) {
            if (target < targets) {
                q.start = nb->start + (size_t)target * cells;
                if (!arena_reserve(arena, candidates(&q) + n + MARK_WORDS_MAX + SELECT_SLACK)) {
                    memset(nb->end[i], 0, sizeof nb->end[i]);
                    trouble->no_memory = true;
                    return;
                }
                n += search_group(&q, i, arena->data + offset + n);
            }
            if (n > ROW_MAX) {
                if (q.s->id[i] < trouble->crowded) trouble->crowded = q.s->id[i];
                n = ROW_MAX;
            }
            nb->end[i][target] = (uint16_t)n;
        }
        nb->owner[i] = (uint16_t)(arena - nb->arena);
        nb->offset[i] = offset;
        const size_t fluid = nb->end[i][GROUP_SUMMATION];
        arena->used = offset + n + (neighbours_mark_bytes(fluid) + neighbours_mark_bytes(n - fluid) + 3) / 4;
    }
}

static Trouble search_all(Neighbours *nb, const Particles *s, const Model *model, const Grid *grid, double distance)
{
    bool no_memory = false;
    uint32_t crowded = UINT32_MAX;
    for (int k = 0; k < nb->threads; k++) nb->arena[k].used = 0;
#pragma omp parallel num_threads(nb->threads) reduction(|| : no_memory) reduction(min : crowded)
    {
        Arena *arena = &nb->arena[omp_get_thread_num()];
        Run runs[GRID_RUNS_MAX];
        Trouble trouble = {false, UINT32_MAX};
#pragma omp for schedule(dynamic, 16)
        for (size_t cell = 0; cell < grid->cells; cell++) {
            const Search q = {.s = s,
                              .model = model,
                              .distance2 = distance * distance,
                              .runs = runs,
                              .n_runs = grid_runs(grid, cell, runs)};
            for (int g = 0; g < GROUPS; g++) search_cell(nb, arena, q, (Group)g, cell, grid->cells, &trouble);
        }
        no_memory = trouble.no_memory;
        crowded = trouble.crowded;
    }
    return (Trouble){no_memory, crowded};
}

static MnsStatus complain(const Trouble *trouble, const Particles *s, MnsError *error)
{
    if (trouble->no_memory) return mns_fail(error, MNS_E_MEMORY, "no memory for the neighbour lists");
    size_t i = 0;
    while (s->id[i] != trouble->crowded) i++;
    return mns_fail(
        error, MNS_E_LIMIT,
        "particle %u at (%g, %g, %g) m has more than %d neighbours: particles have piled up there, or the kernel is "
        "too wide for this spacing",
        s->id[i], s->x[0][i], s->x[1][i], s->dim == 3 ? s->x[2][i] : 0, ROW_MAX);
}

/* Lists that a search without memory does not come to are empty. */
static void clear_ends(Neighbours *nb)
{
#pragma omp parallel for schedule(static) num_threads(nb->threads)
    for (size_t i = 0; i < nb->n; i++) memset(nb->end[i], 0, sizeof nb->end[i]);
}

MnsStatus neighbours_build(Neighbours *nb, Particles *s, const Model *model, MnsError *error)
{
    const double distance = model->kernel.support + model->skin;
    const Grid grid = grid_make(s, model, distance, nb->threads);
    const size_t keys = (size_t)GROUPS * grid.cells;
    if (!reserve(nb, keys)) return mns_fail(error, MNS_E_MEMORY, "no memory for a grid of %zu cells", grid.cells);
    nb->grid = grid;
    /* The bundles are out of date afterwards; meanwhile there is room in them for the sort. */
    void *room = s->bundle[0];
    uint32_t *order = room, *key = order + s->n;
    counting_sort(nb, s, &grid, keys, order, key);
    particles_permute(s, order, nb->threads);
    clear_ends(nb);
    const Trouble trouble = search_all(nb, s, model, &grid, distance);
    return trouble.no_memory || trouble.crowded != UINT32_MAX ? complain(&trouble, s, error) : MNS_OK;
}

size_t neighbours_pairs(const Neighbours *nb)
{
    size_t pairs = 0;
#pragma omp parallel for simd reduction(+ : pairs) num_threads(nb->threads)
    for (size_t i = 0; i < nb->n; i++) pairs += nb->end[i][GROUP_WALL];
    return pairs;
}

size_t neighbours_bytes(const Neighbours *nb)
{
    size_t bytes = nb->start_capacity * sizeof *nb->start;
    bytes += nb->n * (sizeof *nb->offset + sizeof *nb->owner + sizeof *nb->end);
    for (int k = 0; k < nb->threads; k++) bytes += nb->arena[k].capacity * sizeof *nb->arena[k].data;
    return bytes;
}
