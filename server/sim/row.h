/* SPDX-License-Identifier: BSD-3-Clause */
/* All pairs of one particle, laid out for the vector units: filled once, shared by all terms of a pass. Pairs come in blocks of
 * eight, fluid before walls, and each of the two is padded to whole blocks with pairs out of the kernel's reach, so that loops
 * have no remainder and no term asks whether a pair is in reach: beyond it W = F = 0. */
#ifndef SIM_ROW_H
#define SIM_ROW_H

#include "sim/kernel_shape.h"
#include "sim/neighbours.h"
#include "sim/select.h"

enum { ROW_BLOCKS = ROW_MAX / LANES + 2, PICKED_MAX = ROW_BLOCKS * LANES + 2 * SELECT_SLACK };
enum { OWN_IMAGE = PICKED_MAX }; /* the source of an image that is the particle's own */

/* Eight pairs. What was not needed (bundle.h) has no meaning. */
typedef struct Block {
    _Alignas(64) double x[3][LANES];     /* x_i - x_j, nearest image m     */
    double r[LANES];                     /* its length                        m          */
    double W[LANES];                     /* W(r, h)                           m^-dim     */
    double F[LANES];                     /* (1/r) dW/dr: grad_i W = F x       m^-dim-2   */
    double bend[LANES];                  /* (1/r) dF/dr                       m^-dim-4   */
    double v[3][LANES];                  /* v_j                               m/s        */
    double p[LANES], V[LANES], z[LANES]; /* of j             Pa, m^dim, kg/(m^2 s) */
    double shepard[LANES];               /* 1 / sum of W V of j               1          */
    double gradient[3][LANES];           /* pressure gradient of j            Pa/m       */
    double normal[3][LANES];             /* interface normal of j, or 0       1          */
    double other[LANES];                 /* 1 if j is of another fluid, else 0; of mixed rows */
} Block;

typedef struct Row {
    size_t i;          /* the particle                                */
    size_t n_fluid, n; /* blocks [0, n_fluid) are fluid, [n_fluid, n) walls */
    bool mixed;        /* is any of another fluid? With NEED_OTHERS */
    /* Blocks [n_own, n_fluid) and [n_walls, n) are images in mirrors of those before them (mirrors.h). */
    size_t n_own, n_walls;
    uint32_t j[PICKED_MAX];      /* neighbours, eight to a block; of an image, whose it is */
    uint16_t source[PICKED_MAX]; /* of an image: the pair of this row that it is of, or OWN_IMAGE */
    uint8_t turned[PICKED_MAX];  /* of an image: by which sides it is mirrored, a bit each */
    Block block[ROW_BLOCKS];
} Row;

/* Who the pairs of a block are with: [LANES]. */
static inline const uint32_t *row_j(const Row *row, const Block *block)
{
    return row->j + (size_t)(block - row->block) * LANES;
}

/* Are the pairs of a block with images? */
INLINE bool are_images(const Row *row, const Block *block)
{
    const size_t k = (size_t)(block - row->block);
    return (k >= row->n_own && k < row->n_fluid) || k >= row->n_walls;
}

/* Component d of a vector of the neighbours of a block of images, as these have it. */
INLINE void turn_component(const Row *row, const Block *block, int d, double of[LANES])
{
    const uint8_t *turned = row->turned + (size_t)(block - row->block) * LANES;
    for (int l = 0; l < LANES; l++) of[l] = turned[l] >> 2 * d & 3 ? -of[l] : of[l];
}

/* x_j' - x_j along d of the image in lane l of a block [m]. */
INLINE double image_moved(const Row *row, const Block *block, int l, const Particles *s, const Model *model, int d)
{
    const size_t pair = (size_t)(block - row->block) * LANES + (size_t)l;
    const unsigned sides = row->turned[pair] >> 2 * d & 3;
    const double x = s->x[d][row->j[pair] * s->x_step];
    if (!sides) return 0;
    return sides & 1 ? -2 * model_before_mirror(model, 2 * d, x) : 2 * model_before_mirror(model, 2 * d + 1, x);
}

/* Of eight neighbours: what is given for each fluid. */
INLINE void by_fluid(const Particles *s, const uint32_t *j, const double *of, double ret[LANES])
{
    for (int l = 0; l < LANES; l++) ret[l] = of[s->phase[j[l]]];
}

/* Pairs of a particle: all that are listed, which are marked as in reach or not, or only those that were marked since anything
 * moved; or those with walls alone, which leave marks as they are. */
typedef enum RowPairs { ROW_LISTED, ROW_MARKED, ROW_WALLS } RowPairs;

/* What the rows of one loop have in common. */
typedef struct RowPlan {
    Neighbours *nb; /* whose marks are written where all that are listed are looked at */
    const Particles *s;
    const Model *model;
    unsigned needs; /* of the terms: NEED_F | NEED_V ... */
    RowPairs pairs;
    KernelScale kernel;
    double at_zero;                  /* W(0) [m^-dim] */
    double beyond[LANES + 1][LANES]; /* [k]: 0 in the first k lanes, in the others more than the kernel's reach */
} RowPlan;

/* Of bundles that have been refreshed for these needs. */
RowPlan row_plan(Neighbours *nb, const Particles *s, const Model *model, unsigned needs, RowPairs pairs);

void row_build(Row *row, const RowPlan *plan, size_t i);

/* A sum over blocks, lane by lane, so that its rounding does not depend on how wide the machine's vectors are. */
typedef struct Lanes {
    double of[LANES];
} Lanes;

_Static_assert((int)SELECT_SLACK >= (int)LANES && (int)ROW_MAX % (int)LANES == 0, "room for padding");

/* Halves onto each other: ((0 + 4) + (2 + 6)) + ((1 + 5) + (3 + 7)), in as many instructions as there are halvings. */
INLINE double lanes_sum(const Lanes *a)
{
    typedef double Half __attribute__((vector_size(LANES / 2 * sizeof(double)), aligned(sizeof(double)), may_alias));
    typedef double Quarter __attribute__((vector_size(LANES / 4 * sizeof(double))));
    const Half half = *(const Half *)a->of + *(const Half *)(a->of + LANES / 2);
    const Quarter quarter = __builtin_shufflevector(half, half, 0, 1) + __builtin_shufflevector(half, half, 2, 3);
    return quarter[0] + quarter[1];
}

typedef void (*Fetch)(double (*bundle)[4], const uint32_t *j, double *a, double *b, double *c, double *d);

/* What is known when a loop over pairs is compiled: there is one for each. Terms use the first two. */
typedef struct How {
    int dim;
    bool fma; /* for mul_add() */
    Fetch fetch;
    bool periodic; /* pairs across periodic sides among them */
    KernelShape kernel;
} How;

/* a . b, (a - b) . x and (a - b) . (a - b), of arrays [dim]. Written out, as gcc unrolls no small loop with a call in it before it looks for what to
 * vectorise; and macros, as it loses sight of a pair of which parts are passed on as pointers. */
#define DOT(a, b, how)                                                                                                 \
    ((how).dim == 3 ? mul_add((a)[2], (b)[2], mul_add((a)[1], (b)[1], (a)[0] * (b)[0], (how).fma), (how).fma)          \
                    : mul_add((a)[1], (b)[1], (a)[0] * (b)[0], (how).fma))
#define DOT_DIFFERENCE(a, b, x, how)                                                                                   \
    ((how).dim == 3 ? mul_add((a)[2] - (b)[2], (x)[2],                                                                 \
                              mul_add((a)[1] - (b)[1], (x)[1], ((a)[0] - (b)[0]) * (x)[0], (how).fma), (how).fma)      \
                    : mul_add((a)[1] - (b)[1], (x)[1], ((a)[0] - (b)[0]) * (x)[0], (how).fma))
#define DIFFERENCE_SQUARED(a, b, how)                                                                                  \
    ((how).dim == 3                                                                                                    \
         ? mul_add((a)[2] - (b)[2], (a)[2] - (b)[2],                                                                   \
                   mul_add((a)[1] - (b)[1], (a)[1] - (b)[1], ((a)[0] - (b)[0]) * ((a)[0] - (b)[0]), (how).fma),        \
                   (how).fma)                                                                                          \
         : mul_add((a)[1] - (b)[1], (a)[1] - (b)[1], ((a)[0] - (b)[0]) * ((a)[0] - (b)[0]), (how).fma))

/* Lane l of a sum of products. */
INLINE void add_product(Lanes *sum, int l, double a, double b, How how)
{
    sum->of[l] = mul_add(a, b, sum->of[l], how.fma);
}

/* One pair. What a loop does not use costs it nothing. */
typedef struct Pair {
    double x[3], r, W, F, bend, v[3], p, V, z, shepard, gradient[3], normal[3], other; /* as in Block */
    double jump; /* what its pressure lacks as seen across an interface (terms/jump.h) [Pa] */
} Pair;

INLINE Pair block_pair(const Block *b, int l, How how)
{
    Pair pair = {.r = b->r[l],
                 .W = b->W[l],
                 .F = b->F[l],
                 .bend = b->bend[l],
                 .p = b->p[l],
                 .V = b->V[l],
                 .z = b->z[l],
                 .shepard = b->shepard[l],
                 .other = b->other[l]};
    for (int d = 0; d < how.dim; d++) {
        pair.x[d] = b->x[d][l];
        pair.v[d] = b->v[d][l];
        pair.gradient[d] = b->gradient[d][l];
        pair.normal[d] = b->normal[d][l];
    }
    return pair;
}

/* Lane l of sum_j c (x_i - x_j). */
INLINE void add_along(const Pair *pair, double c, How how, int l, Lanes sum[3])
{
    for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, c, pair->x[d], how);
}

/* 1 for a neighbour beside an interface. */
INLINE double has_normal(const Pair *pair, How how)
{
    return DOT(pair->normal, pair->normal, how) > 0.5 ? 1 : 0;
}

/* Velocities of eight neighbours, or what a wall shows instead. */
INLINE void gather_velocities(const Row *row, const Block *b, const Particles *s, How how, double ret[3][LANES])
{
    const bool wall = b >= row->block + row->n_fluid;
    const uint32_t *j = row_j(row, b);
    const size_t first_wall = particles_fluid(s);
    for (int d = 0; d < how.dim; d++)
        for (int l = 0; l < LANES; l++) ret[d][l] = wall ? s->v_wall[d][j[l] - first_wall] : b->v[d][l];
    for (int d = 0; d < how.dim && wall && are_images(row, b); d++) turn_component(row, b, d, ret[d]);
}

/* What a term does with a row. */
typedef void (*RowFunction)(const Row *row, Particles *s, const Model *model);

/* What several do with the pairs of particle i (fused.h). */
typedef void (*FusedFunction)(const RowPlan *plan, Particles *s, size_t i);

/* ROW_FUNCTIONS(name) makes functions of every level, in two and three dimensions, from one that is told How by its last argument;
 * ROW_TABLE(name) is the table of them. */
#define ROW_FUNCTION(name, level, target, dimensions, fused)                                                           \
    target static void name##_##level##_##dimensions(const Row *row, Particles *s, const Model *model)                 \
    {                                                                                                                  \
        name(row, s, model, (How){.dim = dimensions, .fma = fused});                                                   \
    }
#if HAS_LEVELS
#define ROW_FUNCTIONS(name)                                                                                            \
    ROW_FUNCTION(name, base, , 2, BASE_FUSES)                                                                          \
    ROW_FUNCTION(name, base, , 3, BASE_FUSES)                                                                          \
    ROW_FUNCTION(name, v3, FOR_V3, 2, true)                                                                            \
    ROW_FUNCTION(name, v3, FOR_V3, 3, true)                                                                            \
    ROW_FUNCTION(name, v4, FOR_V4, 2, true)                                                                            \
    ROW_FUNCTION(name, v4, FOR_V4, 3, true)
#define ROW_TABLE(name)                                                                                                \
    {                                                                                                                  \
        {name##_base_2, name##_base_3}, {name##_v3_2, name##_v3_3},                                                    \
        {                                                                                                              \
            name##_v4_2, name##_v4_3                                                                                   \
        }                                                                                                              \
    }
#else
#define ROW_FUNCTIONS(name)                                                                                            \
    ROW_FUNCTION(name, base, , 2, BASE_FUSES)                                                                          \
    ROW_FUNCTION(name, base, , 3, BASE_FUSES)
#define ROW_TABLE(name)                                                                                                \
    {                                                                                                                  \
        {                                                                                                              \
            name##_base_2, name##_base_3                                                                               \
        }                                                                                                              \
    }
#endif

#endif
