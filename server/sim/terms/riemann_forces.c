/* SPDX-License-Identifier: BSD-3-Clause */
/* All forces of P3 between fluids without viscosity, in one function. */
#include "sim/fused.h"
#include "sim/terms/riemann.h"
#include "sim/terms/strain.h"
#include "sim/terms/terms.h"
#include "sim/terms/transport.h"

/* stressed: with the stress of a transport. */
INLINE void forces(const RowPlan *plan, Particles *s, size_t i, bool reconstructs, bool stressed, How how)
{
    const unsigned wall_needs = NEED_F | NEED_V | NEED_STATE, needs = wall_needs | (reconstructs ? NEED_STRAIN : 0);
    const Strain strain = reconstructs ? strain_of(s, i, how) : (Strain){{0}, {0}};
    const Side a = side_of(s, plan->model, i, how);
    const Moved moved = moved_of(s, plan->model, i, how);
    Lanes push[3] = {0}, spread[3] = {0}, stress[3] = {0};
    uint32_t j[PICKED_MAX];
    double x[3];
    Block block;
    Marks other;
    const Picked picked = pick_neighbours(plan, i, j);
    if (stressed) mark_others(plan, i, j, &picked, &other);
    position_of(s, i, how, x);
    for (size_t b = 0; b < picked.n_fluid; b++) {
        const double *beyond = beyond_reach(plan, &picked, b);
        fetch_block(&block, j + b * LANES, &plan->nb->bundles, needs, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = fetched_pair(&block, l, beyond, x, plan, needs, how);
            const double smooth = reconstructs ? strained_closing(&strain, &pair, how) : 0;
            riemann_momentum_fluid(&a, &pair, smooth, how, l, push);
            background_pair(&pair, how, l, spread);
            if (stressed) transport_stress_pair(&moved, &pair, other.of[b][l], how, l, stress);
        }
    }
    for (size_t b = picked.n_fluid; b < picked.n; b++) {
        const uint32_t *wall = j + b * LANES;
        const double *beyond = beyond_reach(plan, &picked, b);
        fetch_block(&block, wall, &plan->nb->bundles, wall_needs, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = fetched_pair(&block, l, beyond, x, plan, wall_needs, how);
            riemann_momentum_wall(&a, &pair, side_wall_pressure(&a, wall[l]), how, l, push);
            background_pair(&pair, how, l, spread);
        }
    }
    riemann_momentum_end(s, i, push, how);
    background_end(s, plan->model, i, spread, how);
    if (stressed) transport_stress_end(s, i, stress, how);
}

INLINE void riemann_forces_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    forces(plan, s, i, false, false, how);
}
INTERLEAVED_FUNCTIONS(riemann_forces_fused)

INLINE void reconstructed_forces_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    forces(plan, s, i, true, false, how);
}
INTERLEAVED_FUNCTIONS(reconstructed_forces_fused)

INLINE void transported_forces_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    forces(plan, s, i, false, true, how);
}
INTERLEAVED_FUNCTIONS(transported_forces_fused)

INLINE void transported_reconstructed_forces_fused(const RowPlan *plan, Particles *s, size_t i, How how)
{
    forces(plan, s, i, true, true, how);
}
INTERLEAVED_FUNCTIONS(transported_reconstructed_forces_fused)

const Fusion riemann_forces = {
    .terms = {&riemann_momentum, &background},
    .row = FUSED_TABLE(riemann_forces_fused),
};

const Fusion reconstructed_forces = {
    .terms = {&reconstructed_momentum, &background},
    .row = FUSED_TABLE(reconstructed_forces_fused),
};

const Fusion transported_forces = {
    .terms = {&riemann_momentum, &transport_stress, &background},
    .row = FUSED_TABLE(transported_forces_fused),
};

const Fusion transported_reconstructed_forces = {
    .terms = {&reconstructed_momentum, &transport_stress, &background},
    .row = FUSED_TABLE(transported_reconstructed_forces_fused),
};
