/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/row.h"
#include "sim/select.h"
#include <math.h>
#include <string.h>

typedef double Quad __attribute__((vector_size(32), may_alias));

/* Four bundles, transposed. */
typedef struct Quads {
    Quad a, b, c, d;
} Quads;

INLINE Quads transposed(double (*restrict bundle)[4], const uint32_t *restrict j)
{
    const Quad k0 = *(const Quad *)bundle[j[0]], k1 = *(const Quad *)bundle[j[1]], k2 = *(const Quad *)bundle[j[2]],
               k3 = *(const Quad *)bundle[j[3]];
    const Quad even01 = __builtin_shufflevector(k0, k1, 0, 4, 2, 6),
               odd01 = __builtin_shufflevector(k0, k1, 1, 5, 3, 7);
    const Quad even23 = __builtin_shufflevector(k2, k3, 0, 4, 2, 6),
               odd23 = __builtin_shufflevector(k2, k3, 1, 5, 3, 7);
    return (Quads){
        __builtin_shufflevector(even01, even23, 0, 1, 4, 5), __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5),
        __builtin_shufflevector(even01, even23, 2, 3, 6, 7), __builtin_shufflevector(odd01, odd23, 2, 3, 6, 7)};
}

/* Bundles of eight particles, transposed: a gets the first quantity of all, b the second ... */
INLINE void fetch_quads(double (*restrict bundle)[4], const uint32_t *restrict j, double *restrict a,
                        double *restrict b, double *restrict c, double *restrict d)
{
    for (int l = 0; l < LANES; l += 4) {
        const Quads quads = transposed(bundle, j + l);
        *(Quad *)(a + l) = quads.a;
        *(Quad *)(b + l) = quads.b;
        if (c) *(Quad *)(c + l) = quads.c;
        if (d) *(Quad *)(d + l) = quads.d;
    }
}

#if HAS_LEVELS
typedef double Oct __attribute__((vector_size(64), may_alias));

/* A macro, as no function may return a vector that its instruction set does not have. */
#define BOTH(first, second)                                                                                            \
    __builtin_shufflevector(*(const Quad *)bundle[first], *(const Quad *)bundle[second], 0, 1, 2, 3, 4, 5, 6, 7)

/* The same where registers hold eight doubles, with a third of the shuffles. What is stored is loaded again as eight, which could
 * not be forwarded from two stores of four. */
INLINE void fetch_octs(double (*restrict bundle)[4], const uint32_t *restrict j, double *restrict a, double *restrict b,
                       double *restrict c, double *restrict d)
{
    const Oct k04 = BOTH(j[0], j[4]), k15 = BOTH(j[1], j[5]), k26 = BOTH(j[2], j[6]), k37 = BOTH(j[3], j[7]);
    const Oct even01 = __builtin_shufflevector(k04, k15, 0, 8, 2, 10, 4, 12, 6, 14),
              odd01 = __builtin_shufflevector(k04, k15, 1, 9, 3, 11, 5, 13, 7, 15),
              even23 = __builtin_shufflevector(k26, k37, 0, 8, 2, 10, 4, 12, 6, 14),
              odd23 = __builtin_shufflevector(k26, k37, 1, 9, 3, 11, 5, 13, 7, 15);
    *(Oct *)a = __builtin_shufflevector(even01, even23, 0, 1, 8, 9, 4, 5, 12, 13);
    *(Oct *)b = __builtin_shufflevector(odd01, odd23, 0, 1, 8, 9, 4, 5, 12, 13);
    if (c) *(Oct *)c = __builtin_shufflevector(even01, even23, 2, 3, 10, 11, 6, 7, 14, 15);
    if (d) *(Oct *)d = __builtin_shufflevector(odd01, odd23, 2, 3, 10, 11, 6, 7, 14, 15);
}
#endif

typedef void (*Fetch)(double (*bundle)[4], const uint32_t *j, double *a, double *b, double *c, double *d);

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
    case CARRIED_Q:
    case CARRIED_Q + 1:
    case CARRIED_Q + 2: return block->q[what - CARRIED_Q];
    default: return NULL;
    }
}

INLINE void fetch_bundle(Block *block, const uint32_t *j, const Bundles *bundles, int k, int dim, Fetch fetch)
{
    const uint8_t *what = BUNDLE_LAYOUT[dim - 2][k];
    fetch(bundles->bundle[k].data, j, place(block, what[0]), place(block, what[1]), place(block, what[2]),
          place(block, what[3]));
}

INLINE void fetch_block(Block *block, const uint32_t *j, const Bundles *bundles, unsigned needs, int dim, Fetch fetch)
{
    fetch_bundle(block, j, bundles, 0, dim, fetch);
    if (needs & bundle_meets(dim, 1)) fetch_bundle(block, j, bundles, 1, dim, fetch);
    if (needs & bundle_meets(dim, 2)) fetch_bundle(block, j, bundles, 2, dim, fetch);
}

/* Fill up the last block of n neighbours with one of them; returns how many blocks. */
INLINE size_t fill_up(uint32_t *j, size_t n)
{
    if (!n) return 0;
    const uint32_t one = j[0];
    for (size_t l = 0; l < LANES; l++) j[n + l] = one;
    return (n + LANES - 1) / LANES;
}

INLINE size_t copy(uint32_t *j, const uint32_t *list, size_t n)
{
    memcpy(j, list, n * sizeof *list);
    return n;
}

/* One block: neighbours, differences, distances, kernel. One after the other, so that the root of one block is taken while the
 * next is loaded. */
INLINE void fill_block(Block *b, const uint32_t *j, const RowPlan *plan, unsigned needs, const double x_i[3], int dim,
                       Fetch fetch, bool periodic, KernelShape W, KernelShape F)
{
    fetch_block(b, j, &plan->nb->bundles, needs, dim, fetch);
    const Model *model = plan->model;
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        double r2 = 0;
        for (int d = 0; d < dim; d++) {
            double x = x_i[d] - b->x[d][l];
            if (periodic) x -= model->period[d] * __builtin_rint(x * model->frequency[d]);
            b->x[d][l] = x;
            r2 += x * x;
        }
        b->r[l] = sqrt(r2);
    }
    if (plan->needs & NEED_W)
#pragma omp simd
        for (int l = 0; l < LANES; l++) b->W[l] = W(&plan->kernel, b->r[l]);
    if (plan->needs & NEED_F)
#pragma omp simd
        for (int l = 0; l < LANES; l++) b->F[l] = F(&plan->kernel, b->r[l]);
}

INLINE void fill_blocks(Row *row, const RowPlan *plan, int dim, Fetch fetch, bool periodic, KernelShape W,
                        KernelShape F)
{
    const unsigned needs = row->summed ? plan->needs : plan->needs & ~(unsigned)NEED_FLUX;
    double x[3] = {0, 0, 0};
    for (int d = 0; d < dim; d++) x[d] = plan->s->x[d][row->i];
    for (size_t b = 0; b < row->n; b++)
        fill_block(&row->block[b], row->j + b * LANES, plan, needs, x, dim, fetch, periodic, W, F);
}

INLINE void fill_row(Row *row, const RowPlan *plan, int dim, Fetch fetch, bool periodic)
{
    switch (plan->model->kernel.type) {
    case MNS_WENDLAND_C2: fill_blocks(row, plan, dim, fetch, periodic, wendland_c2_W, wendland_c2_F); break;
    case MNS_QUINTIC_SPLINE: fill_blocks(row, plan, dim, fetch, periodic, quintic_spline_W, quintic_spline_F); break;
    case MNS_TRUNCATED_GAUSSIAN:
        fill_blocks(row, plan, dim, fetch, periodic, truncated_gaussian_W, truncated_gaussian_F);
        break;
    }
}

/* Put what the last block was filled up with out of reach. */
INLINE void hide(Block *last, size_t n, double far)
{
    const size_t used = (n - 1) % LANES;
#pragma omp simd
    for (size_t l = 0; l < LANES; l++) {
        last->r[l] = l > used ? far : last->r[l];
        last->W[l] = l > used ? 0 : last->W[l];
        last->F[l] = l > used ? 0 : last->F[l];
    }
}

INLINE void build(Row *row, const RowPlan *plan, size_t i, int dim, Fetch fetch)
{
    const Model *model = plan->model;
    const uint32_t *list = neighbours_of(plan->nb, i);
    const uint16_t *end = plan->nb->end[i];
    uint8_t *marks = neighbours_marks(plan->nb, i);
    size_t fluid = end[GROUP_SUMMATION], walls = end[GROUP_WALL] - fluid;
    row->i = i;
    row->summed = end[GROUP_CONTINUITY] < fluid;
    if (plan->pairs == ROW_MARKED) {
        const uint32_t *rest = list + fluid;
        const uint8_t *rest_marks = marks + neighbours_mark_bytes(fluid);
        fluid = select_marked(model->level, list, fluid, marks, row->j);
        row->n_fluid = fill_up(row->j, fluid);
        uint32_t *j = row->j + row->n_fluid * LANES;
        walls = walls ? select_marked(model->level, rest, walls, rest_marks, j) : 0;
        row->n = row->n_fluid + fill_up(j, walls);
    } else {
        row->n_fluid = fill_up(row->j, copy(row->j, list, fluid));
        uint32_t *j = row->j + row->n_fluid * LANES;
        row->n = row->n_fluid + fill_up(j, copy(j, list + fluid, walls));
    }
    if (model->periodic) fill_row(row, plan, dim, fetch, true);
    else fill_row(row, plan, dim, fetch, false);
    const double far = 2 * model->kernel.support;
    if (fluid) hide(row->block + row->n_fluid - 1, fluid, far);
    if (walls) hide(row->block + row->n - 1, walls, far);
    if (plan->pairs == ROW_LISTED)
        select_marks(model->level, row->block[0].r, sizeof(Block) / sizeof(double), row->n, model->kernel.support,
                     marks);
}

#define BUILD(level, target, dim, fetch)                                                                               \
    target static void build_##level##_##dim(Row *row, const RowPlan *plan, size_t i)                                  \
    {                                                                                                                  \
        build(row, plan, i, dim, fetch);                                                                               \
    }
typedef void (*Build)(Row *, const RowPlan *, size_t);
BUILD(base, , 2, fetch_quads)
BUILD(base, , 3, fetch_quads)
#if HAS_LEVELS
BUILD(v3, FOR_V3, 2, fetch_quads)
BUILD(v3, FOR_V3, 3, fetch_quads)
BUILD(v4, FOR_V4, 2, fetch_octs)
BUILD(v4, FOR_V4, 3, fetch_octs)
static const Build BUILDS[LEVELS][2] = {
    {build_base_2, build_base_3}, {build_v3_2, build_v3_3}, {build_v4_2, build_v4_3}};
#else
static const Build BUILDS[LEVELS][2] = {{build_base_2, build_base_3}};
#endif

RowPlan row_plan(const Neighbours *nb, const Particles *s, const Model *model, unsigned needs, RowPairs pairs)
{
    RowPlan plan = {.nb = nb, .s = s, .model = model, .needs = needs, .pairs = pairs};
    plan.kernel = kernel_scale(&model->kernel);
    return plan;
}

void row_build(Row *row, const RowPlan *plan, size_t i)
{
    BUILDS[plan->model->level][plan->s->dim - 2](row, plan, i);
}
