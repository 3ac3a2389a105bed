/* SPDX-License-Identifier: BSD-3-Clause */
/* The pairs of one particle, eight at a time: who they are with, fetched and transposed for the vector units. What is made of them
 * is inlined into the loops of row.c, which keep all pairs for the terms that follow, and into fused ones (fused.h), which do not. */
#ifndef SIM_PAIRS_H
#define SIM_PAIRS_H

#include "sim/intrinsics.h"
#include "sim/row.h"
#include <math.h>
#include <string.h>

/* Where a quantity of the neighbours goes; NULL for nothing. */
INLINE double *place(Block *block, int what)
{
    switch (what) {
    case CARRIED_X:
    case CARRIED_X + 1:
    case CARRIED_X + 2: return block->x[what - CARRIED_X];
    case CARRIED_V:
    case CARRIED_V + 1:
    case CARRIED_V + 2: return block->v[what - CARRIED_V];
    case CARRIED_P: return block->p;
    case CARRIED_VOLUME: return block->V;
    case CARRIED_Z: return block->z;
    case CARRIED_SHEPARD: return block->shepard;
    case CARRIED_GRADIENT:
    case CARRIED_GRADIENT + 1:
    case CARRIED_GRADIENT + 2: return block->gradient[what - CARRIED_GRADIENT];
    case CARRIED_NORMAL:
    case CARRIED_NORMAL + 1:
    case CARRIED_NORMAL + 2: return block->normal[what - CARRIED_NORMAL];
    default: return NULL;
    }
}

/* Is a quantity in bundle k? */
INLINE bool bundle_has(int dim, int k, int what)
{
    const uint8_t *of = BUNDLE_LAYOUT[dim - 2][k];
    return of[0] == what || of[1] == what || of[2] == what || of[3] == what;
}

INLINE void fetch_bundle(Block *block, const uint32_t *j, const Bundles *bundles, int k, How how)
{
    const uint8_t *what = BUNDLE_LAYOUT[how.dim - 2][k];
    how.fetch(bundles->data[k], j, place(block, what[0]), place(block, what[1]), place(block, what[2]),
              place(block, what[3]));
}

/* What is not in the first bundle, where positions are. */
INLINE void fetch_rest(Block *block, const uint32_t *j, const Bundles *bundles, unsigned needs, How how)
{
    if (needs & bundle_meets(how.dim, 1)) fetch_bundle(block, j, bundles, 1, how);
    if (needs & bundle_meets(how.dim, 2)) fetch_bundle(block, j, bundles, 2, how);
    if (needs & bundle_meets(how.dim, 3)) fetch_bundle(block, j, bundles, 3, how);
}

INLINE void fetch_block(Block *block, const uint32_t *j, const Bundles *bundles, unsigned needs, How how)
{
    fetch_bundle(block, j, bundles, 0, how);
    fetch_rest(block, j, bundles, needs, how);
}

/* Neighbours of a particle: pairs [0, fluid) are with fluid, in n_fluid blocks; so many with walls follow in the blocks up to n.
 * The last block of either is filled up with one of its neighbours. */
typedef struct Picked {
    size_t fluid, walls;
    size_t n_fluid, n;
} Picked;

/* Fill up the last block of n neighbours with one of them; returns how many blocks. */
INLINE size_t fill_up(uint32_t *j, size_t n)
{
    if (!n) return 0;
    const uint32_t one = j[0];
    for (size_t l = 0; l < LANES; l++) j[n + l] = one;
    return (n + LANES - 1) / LANES;
}

/* All that are listed, or the marked ones of them; returns how many. */
INLINE size_t pick(const RowPlan *plan, const uint32_t *list, size_t n, const uint8_t *marks, uint32_t *j)
{
    if (plan->pairs == ROW_MARKED) return select_marked(plan->model->level, list, n, marks, j);
    memcpy(j, list, n * sizeof *list);
    return n;
}

/* j: [PICKED_MAX] */
INLINE Picked pick_neighbours(const RowPlan *plan, size_t i, uint32_t *j)
{
    const uint32_t *list = neighbours_of(plan->nb, i);
    const uint16_t *end = plan->nb->end[i];
    const uint8_t *marks = neighbours_marks(plan->nb, i);
    const size_t fluid = end[END_FLUID], walls = end[END_WALLS] - fluid;
    Picked picked = {0};
    picked.fluid = pick(plan, list, fluid, marks, j);
    picked.n_fluid = fill_up(j, picked.fluid);
    j += picked.n_fluid * LANES;
    if (walls) picked.walls = pick(plan, list + fluid, walls, marks + neighbours_mark_bytes(fluid), j);
    picked.n = picked.n_fluid + fill_up(j, picked.walls);
    return picked;
}

/* Note which of the pairs are in reach, if all that are listed were looked at. What is fused may leave it out, and says so (Fusion.notes),
 * as marks are used only where all have noted theirs. r: [n][stride] distances of the blocks. */
INLINE void note_reach(const RowPlan *plan, size_t i, const Picked *picked, const double *r, size_t stride)
{
    if (plan->pairs == ROW_LISTED)
        select_marks(plan->model->level, r, stride, picked->n, plan->model->kernel.support,
                     neighbours_marks(plan->nb, i));
}

/* What is added to the distances of block b: 0, and what puts pairs out of reach that only fill it up. [LANES] */
INLINE const double *beyond_reach(const RowPlan *plan, const Picked *picked, size_t b)
{
    const size_t left = b < picked->n_fluid ? picked->fluid - b * LANES : picked->walls - (b - picked->n_fluid) * LANES;
    return plan->beyond[left < LANES ? left : LANES];
}

/* Which of a block's neighbours are of another fluid, as 1 or 0; returns whether any is. */
INLINE bool find_others(const uint8_t *phase, uint8_t mine, const uint32_t *j, double other[LANES])
{
    unsigned others = 0;
    for (int l = 0; l < LANES; l++) {
        const unsigned is = phase[j[l]] != mine;
        other[l] = is;
        others |= is;
    }
    return others;
}

/* A difference of positions in direction d, to the nearest image. */
INLINE double nearest(const Model *model, double x, int d, How how)
{
    return how.periodic ? x - model->period[d] * __builtin_rint(x * model->frequency[d]) : x;
}

/* r2: squares of the block's distances. */
INLINE void fill_kernel(Block *b, const double r2[LANES], const RowPlan *plan, How how)
{
    if (plan->needs & NEED_BEND)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const KernelValue value = how.kernel(&plan->kernel, b->r[l], r2[l], how.fma);
            b->W[l] = value.W;
            b->F[l] = value.F;
            b->bend[l] = value.bend;
        }
    else if ((plan->needs & NEED_W) && (plan->needs & NEED_F))
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const KernelValue value = how.kernel(&plan->kernel, b->r[l], r2[l], how.fma);
            b->W[l] = value.W;
            b->F[l] = value.F;
        }
    else if (plan->needs & NEED_W)
#pragma omp simd
        for (int l = 0; l < LANES; l++) b->W[l] = how.kernel(&plan->kernel, b->r[l], r2[l], how.fma).W;
    else
#pragma omp simd
        for (int l = 0; l < LANES; l++) b->F[l] = how.kernel(&plan->kernel, b->r[l], r2[l], how.fma).F;
}

/* Differences of positions, of which a block has those of neighbours, and distances; r2: their squares. */
INLINE void fill_distances(Block *b, const RowPlan *plan, const double x_i[3], double r2[LANES], How how)
{
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        double x[3];
        for (int d = 0; d < how.dim; d++) x[d] = b->x[d][l] = nearest(plan->model, x_i[d] - b->x[d][l], d, how);
        r2[l] = DOT(x, x, how);
        b->r[l] = sqrt(r2[l]);
    }
}

/* One block: neighbours, differences, distances, kernel. One after the other, so that the root of one block is taken while the
 * next is loaded. */
INLINE void fill_block(Block *b, const uint32_t *j, const RowPlan *plan, unsigned needs, const double x_i[3], How how)
{
    double r2[LANES];
    fetch_block(b, j, &plan->nb->bundles, needs, how);
    fill_distances(b, plan, x_i, r2, how);
    fill_kernel(b, r2, plan, how);
}

/* Of which no more is asked than where the neighbours are. */
INLINE void approach_block(Block *b, const uint32_t *j, const RowPlan *plan, const double x_i[3], How how)
{
    double r2[LANES];
    fetch_bundle(b, j, &plan->nb->bundles, 0, how);
    fill_distances(b, plan, x_i, r2, how);
}

/* One array at a time: gcc gives up all four together. */
INLINE void replace_after(double of[LANES], size_t used, double by)
{
#pragma omp simd
    for (size_t l = 0; l < LANES; l++) of[l] = l > used ? by : of[l];
}

/* Put what the last block was filled up with out of reach. */
INLINE void hide(Block *last, size_t n, double far)
{
    const size_t used = (n - 1) % LANES;
    replace_after(last->r, used, far);
    replace_after(last->W, used, 0);
    replace_after(last->F, used, 0);
    replace_after(last->bend, used, 0);
}

/* Functions of every level, in two and three dimensions, from one that builds a part of the row of i and is told How by its last argument;
 * ROW_TABLE(body) is the table of them. */
typedef void (*RowBuilder)(Row *row, const RowPlan *plan, size_t i);
#define ROW_BUILDER(body, level, target, dimensions, fused, how_to_fetch)                                              \
    target static void body##_##level##_##dimensions(Row *row, const RowPlan *plan, size_t i)                          \
    {                                                                                                                  \
        body(row, plan, i, (How){.dim = dimensions, .fma = fused, .fetch = how_to_fetch});                             \
    }
#if HAS_LEVELS
#define ROW_BUILDERS(body)                                                                                             \
    ROW_BUILDER(body, base, , 2, BASE_FUSES, fetch_quads)                                                              \
    ROW_BUILDER(body, base, , 3, BASE_FUSES, fetch_quads)                                                              \
    ROW_BUILDER(body, v3, FOR_V3, 2, true, fetch_halves)                                                               \
    ROW_BUILDER(body, v3, FOR_V3, 3, true, fetch_halves)                                                               \
    ROW_BUILDER(body, v4, FOR_V4, 2, true, fetch_octs)                                                                 \
    ROW_BUILDER(body, v4, FOR_V4, 3, true, fetch_octs)
#else
#define ROW_BUILDERS(body)                                                                                             \
    ROW_BUILDER(body, base, , 2, BASE_FUSES, fetch_quads)                                                              \
    ROW_BUILDER(body, base, , 3, BASE_FUSES, fetch_quads)
#endif

#endif
