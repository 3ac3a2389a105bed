/* SPDX-License-Identifier: BSD-3-Clause */
/* Terms of one loop made into one function: the pairs of a particle are fetched, used and forgotten in registers, eight at a time,
 * and never laid out as a Row. For what takes most of a step; a fifth faster in two dimensions, with the same bits as its terms one after the
 * other (tests/unit/test_fused.c), as both add up what the same inline functions say of a pair. */
#ifndef SIM_FUSED_H
#define SIM_FUSED_H

#include "sim/pairs.h"

/* All sums of particle i. */
typedef void (*FusedBody)(const RowPlan *plan, Particles *s, size_t i, How how);

INLINE void position_of(const Particles *s, size_t i, How how, double ret[3])
{
    for (int d = 0; d < 3; d++) ret[d] = d < how.dim ? s->x[d][i * s->x_step] : 0;
}

/* Lanes of all blocks of a particle. */
typedef struct Marks {
    _Alignas(64) double of[ROW_BLOCKS][LANES];
} Marks;

static const double NO_OTHERS[LANES];

/* Which neighbours are of another fluid, walls are not; returns whether any is. */
INLINE bool mark_others(const RowPlan *plan, size_t i, const uint32_t *j, const Picked *picked, Marks *other)
{
    const uint8_t *phase = plan->s->phase;
    bool any = false;
    if (plan->nb->has[i] & LIST_OTHERS)
        for (size_t b = 0; b < picked->n_fluid; b++) any |= find_others(phase, phase[i], j + b * LANES, other->of[b]);
    else memset(other->of, 0, picked->n_fluid * sizeof *other->of);
    return any;
}

/* The block of the two that has a quantity. */
INLINE const Block *rest_of(const Block *first, const Block *rest, int what, How how)
{
    return bundle_has(how.dim, 0, what) ? first : rest;
}

/* A pair of which x and r are known, and what else is needed of it: from a block with the first bundle, and from one with the rest.
 * Written out: gcc does not unroll these before it looks for what to vectorise, and then takes no pair apart. */
INLINE Pair with_rest(Pair pair, const Block *first, const Block *rest, int l, const RowPlan *plan, unsigned needs,
                      How how)
{
    if (needs & NEED_V) {
        pair.v[0] = rest_of(first, rest, CARRIED_V, how)->v[0][l];
        pair.v[1] = rest_of(first, rest, CARRIED_V + 1, how)->v[1][l];
        if (how.dim == 3) pair.v[2] = rest_of(first, rest, CARRIED_V + 2, how)->v[2][l];
    }
    if (needs & (NEED_GRADIENT | NEED_STRAIN)) {
        pair.gradient[0] = rest->gradient[0][l];
        pair.gradient[1] = rest->gradient[1][l];
        if (how.dim == 3) pair.gradient[2] = rest->gradient[2][l];
    }
    if (needs & (NEED_NORMAL | NEED_STRAIN)) {
        pair.normal[0] = rest->normal[0][l];
        pair.normal[1] = rest->normal[1][l];
        if (how.dim == 3) pair.normal[2] = rest->normal[2][l];
    }
    if (needs & (NEED_W | NEED_F | NEED_BEND)) {
        const KernelValue value = how.kernel(&plan->kernel, pair.r, DOT(pair.x, pair.x, how), how.fma);
        pair.W = value.W;
        pair.F = value.F;
        pair.bend = value.bend;
    }
    if (needs & NEED_SHEPARD) pair.shepard = rest->shepard[l];
    if (needs & NEED_STATE) {
        pair.p = rest->p[l];
        pair.V = rest->V[l];
        pair.z = rest->z[l];
    }
    return pair;
}

/* Pair l of a block that was fetched for these needs; beyond: what beyond_reach() says of it. */
INLINE Pair fetched_pair(const Block *b, int l, const double *beyond, const double x_i[3], const RowPlan *plan,
                         unsigned needs, How how)
{
    Pair pair = {0};
    for (int d = 0; d < how.dim; d++) pair.x[d] = nearest(plan->model, x_i[d] - b->x[d][l], d, how);
    pair.r = sqrt(DOT(pair.x, pair.x, how)) + beyond[l];
    return with_rest(pair, b, b, l, plan, needs, how);
}

/* x_i - x_j and r of a fetched block take the place of x_j; beyond: what beyond_reach() says of it. */
INLINE void keep_distances(Block *block, const double *beyond, const double x_i[3], const RowPlan *plan, How how)
{
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        double x[3];
        for (int d = 0; d < how.dim; d++) x[d] = block->x[d][l] = nearest(plan->model, x_i[d] - block->x[d][l], d, how);
        block->r[l] = sqrt(DOT(x, x, how)) + beyond[l];
    }
}

/* Fetch the first bundle of block b, if there is such a block, and take the distances. One block ahead of its terms, as nothing else
 * could be done while roots are taken. */
INLINE void approach(Block ahead[2], size_t b, const RowPlan *plan, const Picked *picked, const uint32_t *j,
                     const double x_i[3], How how)
{
    if (b >= picked->n) return;
    Block *block = &ahead[b % 2];
    fetch_bundle(block, j + b * LANES, &plan->nb->bundles, 0, how);
    keep_distances(block, beyond_reach(plan, picked, b), x_i, plan, how);
}

/* Pair l of a block with distances, and of which the rest was fetched for these needs. */
INLINE Pair near_pair(const Block *near, const Block *rest, int l, const RowPlan *plan, unsigned needs, How how)
{
    Pair pair = {.r = near->r[l]};
    for (int d = 0; d < how.dim; d++) pair.x[d] = near->x[d][l];
    return with_rest(pair, near, rest, l, plan, needs, how);
}

/* FUSED_FUNCTIONS(body) makes functions of every level, in two and three dimensions, from a FusedBody that is INLINE;
 * FUSED_TABLE(body) is the table of them. Each kernel has functions of its own: of several bodies in one, gcc gives up on some. */
#define FUSED_SHAPE(type, shape, body, level, target, dimensions, fused, how_to_fetch)                                 \
    target __attribute__((noinline)) static void body##_##level##_##dimensions##_##shape(const RowPlan *plan,          \
                                                                                         Particles *s, size_t i)       \
    {                                                                                                                  \
        body(plan, s, i, (How){dimensions, fused, how_to_fetch, false, shape});                                        \
    }                                                                                                                  \
    target __attribute__((noinline)) static void body##_##level##_##dimensions##_images_##shape(                       \
        const RowPlan *plan, Particles *s, size_t i)                                                                   \
    {                                                                                                                  \
        body(plan, s, i, (How){dimensions, fused, how_to_fetch, true, shape});                                         \
    }
#define FUSED_CASE(type, shape, body, level, dimensions)                                                               \
    case type:                                                                                                         \
        if (plan->nb->has[i] & LIST_IMAGES) body##_##level##_##dimensions##_images_##shape(plan, s, i);                \
        else body##_##level##_##dimensions##_##shape(plan, s, i);                                                      \
        break;
#define BESIDE_SHAPE(type, shape, body, level, target, dimensions, fused, how_to_fetch)                                \
    target __attribute__((noinline)) static void body##_##level##_##dimensions##_##shape(const RowPlan *plan,          \
                                                                                         Particles *s, size_t i)       \
    {                                                                                                                  \
        body(plan, s, i, (How){dimensions, fused, how_to_fetch, true, shape});                                         \
    }
#define BESIDE_CASE(type, shape, body, level, dimensions)                                                              \
    case type:                                                                                                         \
        body##_##level##_##dimensions##_##shape(plan, s, i);                                                           \
        break;
#ifndef MENISCUS_SANITIZED
#define KERNEL_FUNCTION(SHAPE, CASE, body, level, target, dimensions, fused, how_to_fetch)                             \
    EACH_KERNEL(SHAPE, body, level, target, dimensions, fused, how_to_fetch)                                           \
    target static void body##_##level##_##dimensions(const RowPlan *plan, Particles *s, size_t i)                      \
    {                                                                                                                  \
        switch (plan->model->kernel.type) {                                                                            \
            EACH_KERNEL(CASE, body, level, dimensions)                                                                 \
        }                                                                                                              \
    }
#else
#define KERNEL_FUNCTION(SHAPE, CASE, body, level, target, dimensions, fused, how_to_fetch)                             \
    target static void body##_##level##_##dimensions(const RowPlan *plan, Particles *s, size_t i)                      \
    {                                                                                                                  \
        const bool images = plan->nb->has[i] & LIST_IMAGES;                                                            \
        body(plan, s, i, (How){dimensions, fused, how_to_fetch, images, kernel_shape_of(plan->model->kernel.type)});   \
    }
#endif
#define FUSED_FUNCTION(...) KERNEL_FUNCTION(FUSED_SHAPE, FUSED_CASE, __VA_ARGS__)

/* The same for particles beside walls or other fluids, which are fewer: all functions look for images, and machines older than 2013 go
 * over rows. */
#define BESIDE_FUNCTION(...) KERNEL_FUNCTION(BESIDE_SHAPE, BESIDE_CASE, __VA_ARGS__)
#if HAS_LEVELS
#define FUSED_LEVELS(body, for_v3)                                                                                     \
    FUSED_FUNCTION(body, base, , 2, BASE_FUSES, fetch_quads)                                                           \
    FUSED_FUNCTION(body, base, , 3, BASE_FUSES, fetch_quads)                                                           \
    FUSED_FUNCTION(body, v3, for_v3, 2, true, fetch_halves)                                                            \
    FUSED_FUNCTION(body, v3, for_v3, 3, true, fetch_halves)                                                            \
    FUSED_FUNCTION(body, v4, FOR_V4, 2, true, fetch_octs)                                                              \
    FUSED_FUNCTION(body, v4, FOR_V4, 3, true, fetch_octs)
#define FUSED_FUNCTIONS(body) FUSED_LEVELS(body, FOR_V3)
/* The same of a body that does not approach(). Where a block is two vectors, gcc has the whole chain of the first, from differences to sums,
 * before that of the second, which is further than a processor looks ahead; told to schedule, it lays them side by side. */
#ifndef __clang__
#define INTERLEAVED FOR_V3 __attribute__((optimize("schedule-insns")))
#else
#define INTERLEAVED FOR_V3
#endif
#define INTERLEAVED_FUNCTIONS(body) FUSED_LEVELS(body, INTERLEAVED)
#define FUSED_TABLE(body)           ROW_TABLE(body)
#define BESIDE_FUNCTIONS(body)                                                                                         \
    BESIDE_FUNCTION(body, v3, FOR_V3, 2, true, fetch_halves)                                                           \
    BESIDE_FUNCTION(body, v3, FOR_V3, 3, true, fetch_halves)                                                           \
    BESIDE_FUNCTION(body, v4, FOR_V4, 2, true, fetch_octs)                                                             \
    BESIDE_FUNCTION(body, v4, FOR_V4, 3, true, fetch_octs)
#define BESIDE_TABLE(body)                                                                                             \
    {                                                                                                                  \
        [LEVEL_V3] = {body##_v3_2, body##_v3_3}, [LEVEL_V4] = { body##_v4_2, body##_v4_3 }                             \
    }
#else
#define BESIDE_FUNCTIONS(body)                                                                                         \
    BESIDE_FUNCTION(body, base, , 2, BASE_FUSES, fetch_quads)                                                          \
    BESIDE_FUNCTION(body, base, , 3, BASE_FUSES, fetch_quads)
#define BESIDE_TABLE(body) FUSED_TABLE(body)
#define FUSED_FUNCTIONS(body)                                                                                          \
    FUSED_FUNCTION(body, base, , 2, BASE_FUSES, fetch_quads)                                                           \
    FUSED_FUNCTION(body, base, , 3, BASE_FUSES, fetch_quads)
#define INTERLEAVED_FUNCTIONS(body) FUSED_FUNCTIONS(body)
#define FUSED_TABLE(body)                                                                                              \
    {                                                                                                                  \
        [0 ... LEVELS - 1] = { body##_base_2, body##_base_3 }                                                          \
    }
#endif

#endif
