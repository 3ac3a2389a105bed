/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/mirrors.h"
#include "sim/pairs.h"

/* One block: neighbours, differences, distances, kernel. One after the other, so that the root of one block is taken while the
 * next is loaded. */
INLINE void fill_block(Block *b, const uint32_t *j, const RowPlan *plan, unsigned needs, const double x_i[3], How how)
{
    fetch_block(b, j, &plan->nb->bundles, needs, how);
    const Model *model = plan->model;
    double r2[LANES];
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        double x[3];
        for (int d = 0; d < how.dim; d++) x[d] = b->x[d][l] = nearest(model, x_i[d] - b->x[d][l], d, how);
        r2[l] = DOT(x, x, how);
        b->r[l] = sqrt(r2[l]);
    }
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

INLINE void fill_blocks(Row *row, const RowPlan *plan, How how)
{
    const unsigned needs = row->summed ? plan->needs : plan->needs & ~(unsigned)NEED_FLUX;
    double x[3] = {0, 0, 0};
    for (int d = 0; d < how.dim; d++) x[d] = plan->s->x[d][row->i * plan->s->x_step];
    for (size_t b = 0; b < row->n; b++) fill_block(&row->block[b], row->j + b * LANES, plan, needs, x, how);
}

INLINE void fill_row(Row *row, const RowPlan *plan, How how, bool periodic)
{
    how.periodic = periodic;
#ifndef MENISCUS_SANITIZED
#define FILL(shape)                                                                                                    \
    how.kernel = shape;                                                                                                \
    fill_blocks(row, plan, how)
    WITH_KERNEL(plan->model->kernel.type, FILL)
#else
    how.kernel = kernel_shape_of(plan->model->kernel.type);
    fill_blocks(row, plan, how);
#endif
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

/* Say which pairs are with another fluid; returns whether any is. */
INLINE bool mark_others(Row *row, const uint8_t *phase)
{
    bool any = false;
    for (Block *b = row->block; b < row->block + row->n_fluid; b++)
        any |= find_others(phase, phase[row->i], row_j(row, b), b->other);
    return any;
}

/* All that are listed. */
INLINE Picked pick_walls(const RowPlan *plan, size_t i, uint32_t *j)
{
    const uint16_t *end = plan->nb->end[i];
    const size_t fluid = end[END_FLUID], walls = end[END_WALLS] - fluid;
    memcpy(j, neighbours_of(plan->nb, i) + fluid, walls * sizeof *j);
    return (Picked){.walls = walls, .n = fill_up(j, walls)};
}

INLINE void build(Row *row, const RowPlan *plan, size_t i, How how)
{
    const Model *model = plan->model;
    const Picked picked = plan->pairs == ROW_WALLS ? pick_walls(plan, i, row->j) : pick_neighbours(plan, i, row->j);
    row->i = i;
    row->summed = picked.summed;
    row->n_fluid = picked.n_fluid;
    row->n = picked.n;
    row->n_own = row->n_fluid;
    row->n_walls = row->n;
    row->mixed = plan->needs & NEED_OTHERS && plan->nb->has[i] & LIST_OTHERS && mark_others(row, plan->s->phase);
    if (plan->nb->has[i] & LIST_IMAGES) fill_row(row, plan, how, true);
    else fill_row(row, plan, how, false);
    const double far = 2 * model->kernel.support;
    if (picked.fluid) hide(row->block + row->n_fluid - 1, picked.fluid, far);
    if (picked.walls) hide(row->block + row->n - 1, picked.walls, far);
    note_reach(plan, i, &picked, row->block[0].r, sizeof(Block) / sizeof(double));
}

#define BUILD(level, target, dimensions, fused, how_to_fetch)                                                          \
    target static void build_##level##_##dimensions(Row *row, const RowPlan *plan, size_t i)                           \
    {                                                                                                                  \
        build(row, plan, i, (How){.dim = dimensions, .fma = fused, .fetch = how_to_fetch});                            \
    }
typedef void (*Build)(Row *, const RowPlan *, size_t);
BUILD(base, , 2, BASE_FUSES, fetch_quads)
BUILD(base, , 3, BASE_FUSES, fetch_quads)
#if HAS_LEVELS
BUILD(v3, FOR_V3, 2, true, fetch_halves)
BUILD(v3, FOR_V3, 3, true, fetch_halves)
BUILD(v4, FOR_V4, 2, true, fetch_octs)
BUILD(v4, FOR_V4, 3, true, fetch_octs)
static const Build BUILDS[LEVELS][2] = {
    {build_base_2, build_base_3}, {build_v3_2, build_v3_3}, {build_v4_2, build_v4_3}};
#else
static const Build BUILDS[LEVELS][2] = {{build_base_2, build_base_3}};
#endif

RowPlan row_plan(Neighbours *nb, const Particles *s, const Model *model, unsigned needs, RowPairs pairs)
{
    RowPlan plan = {.nb = nb, .s = s, .model = model, .needs = needs, .pairs = pairs};
    plan.kernel = kernel_scale(&model->kernel);
    plan.at_zero = kernel_at_zero(&model->kernel);
    for (int used = 0; used <= LANES; used++)
        for (int l = used; l < LANES; l++) plan.beyond[used][l] = 2 * model->kernel.support;
    return plan;
}

void row_build(Row *row, const RowPlan *plan, size_t i)
{
    BUILDS[plan->model->level][plan->s->dim - 2](row, plan, i);
    if (plan->nb->has[i] & LIST_MIRRORS) mirrors_add(row, plan);
}
