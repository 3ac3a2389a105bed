/* SPDX-License-Identifier: BSD-3-Clause */
/* Neighbour lists: particles sorted by group and cell, then a search of the cells around each cell. */
#include "sim/neighbours.h"
#include "base/array.h"
#include "sim/mirrors.h"
#include "sim/select.h"
#include "sim/shares.h"
#include "sim/sort.h"
#include <omp.h>
#include <stdlib.h>
#include <string.h>

enum { MARK_WORDS_MAX = ROW_MAX / 32 + 2, CHUNK_CELLS = 16 };

MnsStatus neighbours_init(Neighbours *nb, size_t n, int dim, unsigned needs, int threads, MnsError *error)
{
    enum { USUAL = 30 }; /* neighbours, to choose slabs by */
    *nb = (Neighbours){.n = n, .threads = threads, .tells_others = needs & NEED_OTHERS};
    nb->list = array_new_team(n, sizeof *nb->list, threads);
    nb->end = array_new_team(n, sizeof *nb->end, threads);
    nb->counts = array_new(sort_counts(threads), sizeof *nb->counts);
    slabs_init(&nb->slabs, n * USUAL, threads);
    nb->has = array_new_team(n, sizeof *nb->has, threads);
    if (nb->list && nb->end && nb->has && nb->counts && bundles_init(&nb->bundles, n, dim, needs, threads))
        return MNS_OK;
    neighbours_done(nb);
    return mns_fail(error, MNS_E_MEMORY, "no memory for the neighbour lists of %zu particles", n);
}

void neighbours_done(Neighbours *nb)
{
    slabs_done(&nb->slabs);
    bundles_done(&nb->bundles);
    free(nb->list);
    free(nb->end);
    free(nb->has);
    free(nb->start);
    free(nb->counts);
    *nb = (Neighbours){0};
}

void neighbours_refresh(Neighbours *nb, Particles *s, const Model *model, unsigned needs)
{
    for (int g = 0; g < GROUPS; g++) {
        bundles_stale(&nb->bundles, (Group)g, s->changed[g]);
        if (s->changed[g] & FIELD(X)) nb->marked = 0;
        s->changed[g] = 0;
    }
    bundles_refresh(&nb->bundles, s, model, needs, nb->threads);
}

const uint32_t *neighbours_start(const Neighbours *nb, const Particles *s, int group)
{
    return s->begin[group + 1] > s->begin[group] ? nb->start + sort_group(s, group) * nb->grid.cells : NULL;
}

static bool reserve(Neighbours *nb, size_t keys)
{
    if (keys < nb->start_capacity) return true;
    uint32_t *start = realloc(nb->start, (keys + 1) * sizeof *start);
    if (!start) return false;
    nb->start = start;
    nb->start_capacity = keys + 1;
    return true;
}

/* What the search of one cell needs. */
typedef struct Search {
    const Particles *s;
    const Model *model;
    SelectNear near;
    Points points;
    double distance, distance2;
    const uint32_t *begin[GROUPS]; /* neighbours_start() */
    const uint32_t *start;         /* of the group that is searched */
    const Run *runs;
    int n_runs;
} Search;

/* Append the members of one group within reach of i to list; returns how many. Sets *images if any of them is near as an image. */
static size_t search_group(const Search *q, size_t i, uint32_t *restrict list, bool *images)
{
    const Particles *s = q->s;
    const double at[3] = {s->ref[0][i], s->ref[1][i], s->dim == 3 ? s->ref[2][i] : 0};
    size_t n = 0;
    for (int k = 0; k < q->n_runs; k++)
        n += q->near(&q->points, q->start[q->runs[k].first], q->start[q->runs[k].last + 1], at, q->distance2,
                     (uint32_t)i, list + n, images);
    return n;
}

static size_t candidates(const Search *q)
{
    size_t n = 0;
    for (int k = 0; k < q->n_runs; k++) n += q->start[q->runs[k].last + 1] - q->start[q->runs[k].first];
    return n;
}

/* LIST_... of the list of i. */
static uint8_t kinds(const Neighbours *nb, const Particles *s, size_t i, bool images, bool mirrored)
{
    const uint32_t *list = nb->list[i];
    const size_t fluid = nb->end[i][END_FLUID];
    unsigned others = 0;
    if (nb->tells_others && i < particles_fluid(s))
        for (size_t k = 0; k < fluid; k++) others |= (unsigned)(s->phase[list[k]] ^ s->phase[i]);
    return (uint8_t)((nb->end[i][END_WALLS] > fluid ? LIST_WALLS : 0) | (others ? LIST_OTHERS : 0) |
                     (images ? LIST_IMAGES : 0) | (mirrored ? LIST_MIRRORS : 0));
}

/* What went wrong in a search: no memory, or the smallest id of the particles with too many neighbours. */
typedef struct Trouble {
    bool no_memory;
    uint32_t crowded; /* UINT32_MAX: none */
} Trouble;

/* Lists of all particles of one group in one cell. A list that is too long is cut, so that what can be read is safe. */
static void search_cell(Neighbours *nb, Cut *cut, Search q, Group group, size_t cell, Trouble *trouble)
{
    const int targets = group == GROUP_WALL ? GROUP_WALL : GROUPS;
    size_t room = MARK_WORDS_MAX + SELECT_SLACK;
    for (int target = 0; target < targets; target++) {
        q.start = q.begin[target];
        if (q.start) room += candidates(&q);
    }
    const uint32_t *own = q.begin[group];
    for (size_t i = own[cell]; i < own[cell + 1]; i++) {
        if (!slabs_reserve(&nb->slabs, cut, room)) {
            trouble->no_memory = true;
            return;
        }
        size_t n = 0;
        bool images = false;
        for (int target = 0; target < GROUPS; target++) {
            q.start = q.begin[target];
            if (target < targets && q.start) n += search_group(&q, i, cut->at + n, &images);
            if (n > ROW_MAX) {
                if (q.s->id[i] < trouble->crowded) trouble->crowded = q.s->id[i];
                n = ROW_MAX;
            }
            nb->end[i][target == GROUP_WALL ? END_WALLS : END_FLUID] = (uint16_t)n;
        }
        nb->list[i] = cut->at;
        const size_t fluid = nb->end[i][END_FLUID];
        n = fluid + mirrors_thin(q.model, q.s, cut->at + fluid, n - fluid);
        nb->end[i][END_WALLS] = (uint16_t)n;
        const Mirrored mirrored = mirrors_of_list(q.model, q.s, i, cut->at, fluid, n, q.distance);
        nb->has[i] = kinds(nb, q.s, i, images, mirrored);
        if (mirrored == MIRRORED_TOO_OFTEN && q.s->id[i] < trouble->crowded) trouble->crowded = q.s->id[i];
        cut_advance(cut, n + (neighbours_mark_bytes(fluid) + neighbours_mark_bytes(n - fluid) + 3) / 4);
    }
}

static Trouble search_all(Neighbours *nb, const Particles *s, const Model *model, const Grid *grid, double distance)
{
    bool no_memory = false;
    uint32_t crowded = UINT32_MAX;
    Shares shares;
    const uint32_t *begin[GROUPS];
    for (int g = 0; g < GROUPS; g++) begin[g] = neighbours_start(nb, s, g);
    slabs_clear(&nb->slabs);
    shares_init(&shares, (grid->cells + CHUNK_CELLS - 1) / CHUNK_CELLS, nb->threads);
#pragma omp parallel num_threads(nb->threads) reduction(|| : no_memory) reduction(min : crowded)
    {
        Cut cut = {NULL, 0};
        Run runs[GRID_RUNS_MAX];
        Trouble trouble = {false, UINT32_MAX};
        for (size_t chunk; shares_take(&shares, omp_get_thread_num(), &chunk);) {
            const size_t end = (chunk + 1) * CHUNK_CELLS;
            for (size_t cell = chunk * CHUNK_CELLS; cell < end && cell < grid->cells; cell++) {
                Search q = {.s = s,
                            .model = model,
                            .near = select_near(model->level, s->dim, model->periodic),
                            .points = {{s->ref[0], s->ref[1], s->ref[2]}, model->period, model->frequency},
                            .distance = distance,
                            .distance2 = distance * distance,
                            .runs = runs,
                            .n_runs = grid_runs(grid, cell, runs)};
                memcpy(q.begin, begin, sizeof begin);
                for (int g = 0; g < GROUPS; g++)
                    if (q.begin[g]) search_cell(nb, &cut, q, (Group)g, cell, &trouble);
            }
        }
        no_memory = trouble.no_memory;
        crowded = trouble.crowded;
    }
    return (Trouble){no_memory, crowded};
}

static MnsStatus complain(const Trouble *trouble, const Particles *s, const Model *model, MnsError *error)
{
    if (trouble->no_memory) return mns_fail(error, MNS_E_MEMORY, "no memory for the neighbour lists");
    size_t i = 0;
    while (s->id[i] != trouble->crowded) i++;
    return mns_fail(
        error, MNS_E_LIMIT,
        "particle %u at (%g, %g, %g) m has more than %d neighbours%s: particles have piled up there, or the kernel is "
        "too wide for this spacing",
        s->id[i], s->x[0][i * s->x_step], s->x[1][i * s->x_step], s->dim == 3 ? s->x[2][i * s->x_step] : 0, ROW_MAX,
        model->mirrors ? ", with their images in walls that mirror the fluid" : "");
}

/* Lists that a search without memory does not come to are empty. */
static void clear_lists(Neighbours *nb)
{
#pragma omp parallel for schedule(static) num_threads(nb->threads)
    for (size_t i = 0; i < nb->n; i++) {
        nb->list[i] = NULL;
        memset(nb->end[i], 0, sizeof nb->end[i]);
    }
}

MnsStatus neighbours_build(Neighbours *nb, Particles *s, const Model *model, MnsError *error)
{
    const double distance = model->kernel.support + model->skin;
    const Grid grid = grid_make(s, model, distance, nb->threads);
    const size_t keys = sort_groups(s) * grid.cells;
    if (!reserve(nb, keys)) return mns_fail(error, MNS_E_MEMORY, "no memory for a grid of %zu cells", grid.cells);
    nb->grid = grid;
    nb->marked = 0;
    /* Lists are made anew, and rates are spare when particles have moved: there is room in both for the sort. */
    uint32_t *order = sort_by_cell(s, &grid, nb->start, nb->counts, nb->list, s->rate, nb->threads);
    particles_permute(s, order, nb->threads);
    clear_lists(nb);
    const Trouble trouble = search_all(nb, s, model, &grid, distance);
    if (trouble.no_memory || trouble.crowded != UINT32_MAX) return complain(&trouble, s, model, error);
    return MNS_OK;
}

size_t neighbours_pairs(const Neighbours *nb)
{
    size_t pairs = 0;
#pragma omp parallel for simd reduction(+ : pairs) num_threads(nb->threads)
    for (size_t i = 0; i < nb->n; i++) pairs += nb->end[i][END_WALLS];
    return pairs;
}

size_t neighbours_bytes(const Neighbours *nb)
{
    return nb->start_capacity * sizeof *nb->start + sort_counts(nb->threads) * sizeof *nb->counts +
           nb->n * (sizeof *nb->list + sizeof *nb->end + sizeof *nb->has) + bundles_bytes(&nb->bundles, nb->n) +
           slabs_bytes(&nb->slabs);
}
