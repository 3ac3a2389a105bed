/* SPDX-License-Identifier: BSD-3-Clause */
/* Density and momentum by the Riemann problem of pairs, as terms. */
#include "sim/terms/riemann.h"
#include "sim/fused.h"
#include "sim/terms/slope.h"
#include "sim/terms/strain.h"
#include "sim/terms/terms.h"

INLINE void density_of_row(const Row *row, Particles *s, const Model *model, Spared spared, How how)
{
    const Side a = side_of(s, model, row->i, how);
    const Slope slope = slope_of(s, model, row->i, spared, how);
    const Block *const walls = row->block + row->n_fluid, *const end = row->block + row->n;
    Slopes theirs;
    Lanes sum = {0};
    for (const Block *b = row->block; b < walls; b++) {
        const double *others = row->mixed ? b->other : NO_OTHERS;
        if (spared == SPARED_SLOPES) slopes_of_block(&theirs, row, b, s, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            riemann_density_fluid(&a, &pair, pressure_beside(&slope, a.p, &pair, &theirs, others[l], spared, how, l),
                                  how, l, &sum);
        }
    }
    for (const Block *b = walls; b < end; b++) {
        const uint32_t *j = row_j(row, b);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double p_w = side_wall_pressure(&a, j[l]);
            riemann_density_wall(&a, &pair, p_w, pressure_beside_wall(&slope, a.p - p_w, &pair, spared, how), how, l,
                                 &sum);
        }
    }
    riemann_density_end(&a, s, row->i, &sum);
}

/* What is spared is known when these loops are compiled, so a scheme without it does not pay for it. */
INLINE void riemann_density_row(const Row *row, Particles *s, const Model *model, How how)
{
    switch (model->spared) {
    case SPARED_SLOPES: density_of_row(row, s, model, SPARED_SLOPES, how); break;
    case SPARED_WEIGHT: density_of_row(row, s, model, SPARED_WEIGHT, how); break;
    default: density_of_row(row, s, model, SPARED_NOTHING, how);
    }
}
ROW_FUNCTIONS(riemann_density_row)

/* Of pairs with walls; x of the particle. r: their distances, block by block. */
INLINE void density_of_walls(const RowPlan *plan, const double x[3], const Picked *picked, const uint32_t *j,
                             const Side *a, const Slope *slope, Spared spared, double r[][LANES], Lanes *sum, How how)
{
    enum { NEEDS = NEED_F | NEED_BEND | NEED_V | NEED_STATE };
    Block block;
    for (size_t b = picked->n_fluid; b < picked->n; b++) {
        const uint32_t *wall = j + b * LANES;
        const double *beyond = beyond_reach(plan, picked, b);
        fetch_block(&block, wall, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = fetched_pair(&block, l, beyond, x, plan, NEEDS, how);
            const double p_w = side_wall_pressure(a, wall[l]);
            r[b][l] = pair.r;
            riemann_density_wall(a, &pair, p_w, pressure_beside_wall(slope, a->p - p_w, &pair, spared, how), how, l,
                                 sum);
        }
    }
}

/* strains: the rate of strain too, if it is of no gas. */
INLINE void density(const RowPlan *plan, Particles *s, size_t i, bool strains, Spared spared, How how)
{
    enum { NEEDS = NEED_F | NEED_BEND | NEED_V | NEED_STATE };
    uint32_t j[PICKED_MAX];
    _Alignas(64) double r[ROW_BLOCKS][LANES];
    double x[3];
    Lanes sum = {0};
    StrainSums sums = {0};
    Marks other;
    Slopes theirs;
    Block block;
    const Picked picked = pick_neighbours(plan, i, j);
    const Side a = side_of(s, plan->model, i, how);
    const Slope slope = slope_of(s, plan->model, i, spared, how);
    position_of(s, i, how, x);
    const bool mixed = strains && mark_others(plan, i, j, &picked, &other);
    for (size_t b = 0; b < picked.n_fluid; b++) {
        const double *beyond = beyond_reach(plan, &picked, b);
        fetch_block(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
        if (spared == SPARED_SLOPES) gather_slopes(&theirs, s, j + b * LANES, how);
        if (strains) keep_distances(&block, beyond, x, plan, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = strains ? near_pair(&block, &block, l, plan, NEEDS, how)
                                      : fetched_pair(&block, l, beyond, x, plan, NEEDS, how);
            const double is_other = strains ? other.of[b][l] : 0;
            r[b][l] = pair.r;
            riemann_density_fluid(&a, &pair, pressure_beside(&slope, a.p, &pair, &theirs, is_other, spared, how, l),
                                  how, l, &sum);
            if (strains) block.F[l] = pair.F;
        }
        if (strains) strain_block(a.v, &block, other.of[b], how, &sums);
    }
    density_of_walls(plan, x, &picked, j, &a, &slope, spared, r, &sum, how);
    note_reach(plan, i, &picked, r[0], LANES);
    riemann_density_end(&a, s, i, &sum);
    if (!strains || model_is_gas(plan->model, a.rho0)) return;
    if (mixed && is_beside_gas(s, plan->model, j, r[0], picked.n_fluid * LANES)) no_strain(s, i, how);
    else strain_end(s, i, &sums, how);
}

INLINE void riemann_density_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    density(plan, s, i, false, SPARED_NOTHING, how);
}
INTERLEAVED_FUNCTIONS(riemann_density_fused)

INLINE void strained_density_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    density(plan, s, i, true, SPARED_NOTHING, how);
}
INTERLEAVED_FUNCTIONS(strained_density_fused)

INLINE void weighed_density_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    density(plan, s, i, true, SPARED_WEIGHT, how);
}
INTERLEAVED_FUNCTIONS(weighed_density_fused)

INLINE void sloped_density_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    density(plan, s, i, true, SPARED_SLOPES, how);
}
INTERLEAVED_FUNCTIONS(sloped_density_fused)

INLINE void momentum(const Row *row, Particles *s, const Model *model, bool reconstructs, How how)
{
    const Side a = side_of(s, model, row->i, how);
    const Strain strain = reconstructs ? strain_of(s, row->i, how) : (Strain){{0}, {0}};
    const Block *const walls = row->block + row->n_fluid, *const end = row->block + row->n;
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < walls; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double smooth = reconstructs ? strained_closing(&strain, &pair, how) : 0;
            riemann_momentum_fluid(&a, &pair, smooth, how, l, sum);
        }
    for (const Block *b = walls; b < end; b++) {
        const uint32_t *j = row_j(row, b);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            riemann_momentum_wall(&a, &pair, side_wall_pressure(&a, j[l]), how, l, sum);
        }
    }
    riemann_momentum_end(s, row->i, sum, how);
}

INLINE void riemann_momentum_row(const Row *row, Particles *s, const Model *model, How how)
{
    momentum(row, s, model, false, how);
}
ROW_FUNCTIONS(riemann_momentum_row)

INLINE void reconstructed_momentum_row(const Row *row, Particles *s, const Model *model, How how)
{
    momentum(row, s, model, true, how);
}
ROW_FUNCTIONS(reconstructed_momentum_row)

static bool reconstructs(const Model *model)
{
    return model->reconstructs;
}

static bool does_not_reconstruct(const Model *model)
{
    return !model->reconstructs;
}

const Term riemann_density = {
    .name = "Riemann continuity",
    .source = "P3 eq. 5, 8, 17",
    .equation = "d rho_i/dt = 2 rho_i sum_j V_j (v_i - v*) . grad_i W,  v_ij at x_ij - dt/2 v_ij",
    .on = ON_CONTINUITY,
    .needs = NEED_F | NEED_BEND | NEED_V | NEED_STATE | NEED_OTHERS,
    .row = ROW_TABLE(riemann_density_row),
};

const Term riemann_momentum = {
    .name = "Riemann momentum",
    .source = "P3 eq. 6, 9, 10, 13",
    .equation = "m_i dv_i/dt = -2 sum_j V_i V_j p* grad_i W",
    .on = ON_FLUID,
    .needed = does_not_reconstruct,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .writes = FIELD(A),
    .row = ROW_TABLE(riemann_momentum_row),
};

const Term reconstructed_momentum = {
    .name = "Riemann momentum",
    .source = "P3 eq. 6, 9, 10, 13, dU beside its linear part",
    .equation = "m_i dv_i/dt = -2 sum_j V_i V_j p* grad_i W",
    .on = ON_FLUID,
    .needed = reconstructs,
    .needs = NEED_F | NEED_V | NEED_STATE | NEED_STRAIN,
    .writes = FIELD(A),
    .row = ROW_TABLE(reconstructed_momentum_row),
};

static bool spares_nothing(const Model *model)
{
    return model->spared == SPARED_NOTHING;
}

static bool spares_weight(const Model *model)
{
    return model->spared == SPARED_WEIGHT;
}

static bool spares_slopes(const Model *model)
{
    return model->spared == SPARED_SLOPES;
}

const Fusion riemann_density_alone = {
    .terms = {&riemann_density},
    .needed = spares_nothing,
    .notes = true,
    .row = FUSED_TABLE(riemann_density_fused),
};

/* Each way to spare has functions of its own: of several bodies in one, gcc gives up on some. */
const Fusion strained_density = {
    .terms = {&riemann_density, &strain_rate},
    .needed = spares_nothing,
    .notes = true,
    .row = FUSED_TABLE(strained_density_fused),
};

const Fusion weighed_density = {
    .terms = {&riemann_density, &strain_rate},
    .needed = spares_weight,
    .notes = true,
    .row = FUSED_TABLE(weighed_density_fused),
};

const Fusion sloped_density = {
    .terms = {&riemann_density, &strain_rate},
    .needed = spares_slopes,
    .notes = true,
    .row = FUSED_TABLE(sloped_density_fused),
};
