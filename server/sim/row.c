/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/mirrors.h"
#include "sim/pairs.h"

/* Of walls beside mirrors, just where they are: those that are not behind one are filled where they come to (mirrors.c). */
INLINE void fill_blocks(Row *row, const RowPlan *plan, How how)
{
    const size_t filled = plan->nb->has[row->i] & LIST_MIRRORS ? row->n_fluid : row->n;
    const unsigned needs = plan->needs;
    double x[3] = {0, 0, 0};
    for (int d = 0; d < how.dim; d++) x[d] = plan->s->x[d][row->i * plan->s->x_step];
    for (size_t b = 0; b < filled; b++) fill_block(&row->block[b], row->j + b * LANES, plan, needs, x, how);
    for (size_t b = filled; b < row->n; b++) approach_block(&row->block[b], row->j + b * LANES, plan, x, how);
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

ROW_BUILDERS(build)

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
    static const RowBuilder builders[LEVELS][2] = ROW_TABLE(build);
    builders[plan->model->level][plan->s->dim - 2](row, plan, i);
    if (plan->nb->has[i] & LIST_MIRRORS) mirrors_add(row, plan);
}
