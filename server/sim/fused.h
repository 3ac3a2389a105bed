/* SPDX-License-Identifier: BSD-3-Clause */
/* Terms of one loop made into one function: the pairs of a particle are fetched, used and forgotten in registers, eight at a time,
 * and never laid out as a Row. For what takes most of a step; a fifth faster in two dimensions, with the same bits as its terms one after the
 * other (tests/unit/test_fused.c), as both add up what the same inline functions say of a pair. */
#ifndef SIM_FUSED_H
#define SIM_FUSED_H

#include "sim/pairs.h"

/* How pairs are made; constant in every function that is compiled. */
typedef struct Geometry {
    Fetch fetch;
    bool periodic;
    KernelShape kernel;
} Geometry;

/* All sums of particle i. */
typedef void (*FusedBody)(const RowPlan *plan, Particles *s, size_t i, int dim, Geometry how);

INLINE void position_of(const Particles *s, size_t i, int dim, double ret[3])
{
    for (int d = 0; d < 3; d++) ret[d] = d < dim ? s->x[d][i] : 0;
}

/* Without the sum that begins with 0, which is an addition more. */
INLINE double length(const double x[3], int dim)
{
    const double plane = x[0] * x[0] + x[1] * x[1];
    return sqrt(dim == 3 ? plane + x[2] * x[2] : plane);
}

/* Pair l of a block that was fetched for these needs; beyond: what beyond_reach() says of it. */
INLINE Pair fetched_pair(const Block *b, int l, const double *beyond, const double x_i[3], const RowPlan *plan,
                         unsigned needs, int dim, Geometry how)
{
    Pair pair;
    for (int d = 0; d < dim; d++) {
        pair.x[d] = nearest(plan->model, x_i[d] - b->x[d][l], d, how.periodic);
        if (needs & NEED_V) pair.v[d] = b->v[d][l];
        if (needs & NEED_FLUX) pair.q[d] = b->q[d][l];
        if (needs & NEED_GRADIENT) pair.gradient[d] = b->gradient[d][l];
        if (needs & NEED_NORMAL) pair.normal[d] = b->normal[d][l];
    }
    pair.r = length(pair.x, dim) + beyond[l];
    if (needs & (NEED_W | NEED_F)) {
        const KernelValue value = how.kernel(&plan->kernel, pair.r);
        pair.W = value.W;
        pair.F = value.F;
    }
    if (needs & NEED_SHEPARD) pair.shepard = b->shepard[l];
    if (needs & NEED_STATE) {
        pair.p = b->p[l];
        pair.V = b->V[l];
        pair.z = b->z[l];
    }
    return pair;
}

/* FUSED_FUNCTIONS(body) makes functions of every level, in two and three dimensions, from a FusedBody that is INLINE;
 * FUSED_TABLE(body) is the table of them. Each kernel has functions of its own: of several bodies in one, gcc gives up on some. */
#define FUSED_SHAPE(type, shape, body, level, target, dim, fetch)                                                      \
    target __attribute__((noinline)) static void body##_##level##_##dim##_##shape(const RowPlan *plan, Particles *s,   \
                                                                                  size_t i)                            \
    {                                                                                                                  \
        body(plan, s, i, dim, (Geometry){fetch, false, shape});                                                        \
    }                                                                                                                  \
    target __attribute__((noinline)) static void body##_##level##_##dim##_periodic_##shape(const RowPlan *plan,        \
                                                                                           Particles *s, size_t i)     \
    {                                                                                                                  \
        body(plan, s, i, dim, (Geometry){fetch, true, shape});                                                         \
    }
#define FUSED_CASE(type, shape, body, level, dim)                                                                      \
    case type:                                                                                                         \
        if (plan->nb->has[i] & LIST_IMAGES) body##_##level##_##dim##_periodic_##shape(plan, s, i);                              \
        else body##_##level##_##dim##_##shape(plan, s, i);                                                             \
        break;
#ifndef MENISCUS_SANITIZED
#define FUSED_FUNCTION(body, level, target, dim, fetch)                                                                \
    EACH_KERNEL(FUSED_SHAPE, body, level, target, dim, fetch)                                                          \
    target static void body##_##level##_##dim(const RowPlan *plan, Particles *s, size_t i)                             \
    {                                                                                                                  \
        switch (plan->model->kernel.type) {                                                                            \
            EACH_KERNEL(FUSED_CASE, body, level, dim)                                                                  \
        }                                                                                                              \
    }
#else
#define FUSED_FUNCTION(body, level, target, dim, fetch)                                                                \
    target static void body##_##level##_##dim(const RowPlan *plan, Particles *s, size_t i)                             \
    {                                                                                                                  \
        const Model *model = plan->model;                                                                              \
        body(plan, s, i, dim, (Geometry){fetch, model->periodic, kernel_shape_of(model->kernel.type)});                \
    }
#endif
#if HAS_LEVELS && !defined MENISCUS_SANITIZED
#define FUSED_FUNCTIONS(body)                                                                                          \
    FUSED_FUNCTION(body, base, , 2, fetch_quads)                                                                       \
    FUSED_FUNCTION(body, base, , 3, fetch_quads)                                                                       \
    FUSED_FUNCTION(body, v3, FOR_V3, 2, fetch_quads)                                                                   \
    FUSED_FUNCTION(body, v3, FOR_V3, 3, fetch_quads)                                                                   \
    FUSED_FUNCTION(body, v4, FOR_V4, 2, fetch_octs)                                                                    \
    FUSED_FUNCTION(body, v4, FOR_V4, 3, fetch_octs)
#define FUSED_TABLE(body) ROW_TABLE(body)
#else
#define FUSED_FUNCTIONS(body)                                                                                          \
    FUSED_FUNCTION(body, base, , 2, fetch_quads)                                                                       \
    FUSED_FUNCTION(body, base, , 3, fetch_quads)
/* Under the sanitizer gcc takes minutes for all levels; the plainest stands for all there. */
#define FUSED_TABLE(body)                                                                                              \
    {                                                                                                                  \
        [0 ... LEVELS - 1] = { body##_base_2, body##_base_3 }                                                          \
    }
#endif

#endif
