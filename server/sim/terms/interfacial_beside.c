/* SPDX-License-Identifier: BSD-3-Clause */
/* Forces, shifting and the gradient of P2 for viscous particles beside walls or another fluid. */
#include "sim/fused.h"
#include "sim/terms/push.h"
#include "sim/terms/tension.h"
#include "sim/terms/terms.h"
#include "sim/terms/viscosity.h"

/* What is known of the neighbours of a particle, and sums that the others need. */
typedef struct Beside {
    uint32_t j[PICKED_MAX];
    Picked picked;
    Marks other, counts;  /* of each neighbour: of another fluid?  1 if what it carries counts, else 0 */
    Moments moments, all; /* of fluids; of fluids and walls */
} Beside;

INLINE void moments_beside(const RowPlan *plan, const Particles *s, size_t i, How how, Beside *near)
{
    enum { NEEDS = NEED_F | NEED_STATE };
    double x[3];
    Block block, ahead[2];
    position_of(s, i, how, x);
    approach(ahead, 0, plan, &near->picked, near->j, x, how);
    for (size_t b = 0; b < near->picked.n_fluid; b++) {
        approach(ahead, b + 1, plan, &near->picked, near->j, x, how);
        fetch_rest(&block, near->j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            moments_pair(&near->moments, &pair, 1, how, l);
        }
    }
    near->all = near->moments;
    for (size_t b = near->picked.n_fluid; b < near->picked.n; b++) {
        approach(ahead, b + 1, plan, &near->picked, near->j, x, how);
        fetch_rest(&block, near->j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            moments_pair(&near->all, &pair, 1, how, l);
        }
    }
}

INLINE void corrected_pull_beside(const RowPlan *plan, Particles *s, size_t i, How how, const Beside *near,
                                  const Pulled *a)
{
    enum { NEEDS = NEED_F | NEED_STATE | NEED_NORMAL };
    double x[3];
    Lanes towards[3] = {0}, bend[3][3] = {0};
    Block block, ahead[2];
    const Correction M = moments_inverse(&near->all, how);
    position_of(s, i, how, x);
    approach(ahead, 0, plan, &near->picked, near->j, x, how);
    for (size_t b = 0; b < near->picked.n_fluid; b++) {
        approach(ahead, b + 1, plan, &near->picked, near->j, x, how);
        const double *others = near->other.of[b];
        double weight[LANES];
        by_fluid(s, near->j + b * LANES, a->weight, weight);
        fetch_rest(&block, near->j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            towards_pair(&pair, weight[l], how, l, towards);
            corrected_curvature_pair(a, &pair, others[l], how, l, bend);
        }
    }
    pull_end(s, i, a, corrected_trace(&M, bend, how), &M, towards, how);
}

INLINE void forces_beside(const RowPlan *plan, Particles *s, size_t i, How how)
{
    enum { WALL_NEEDS = NEED_F | NEED_V | NEED_STATE, NEEDS = WALL_NEEDS | NEED_SHEPARD };
    double x[3], mu[MNS_MAX_FLUIDS], like[MNS_MAX_FLUIDS];
    ShiftingSums carried = {0};
    Lanes push[3] = {0}, drag[3] = {0}, friction[3] = {0}, slope[3] = {0};
    Block block, ahead[2];
    Beside near;
    const Model *model = plan->model;
    near.moments = (Moments){0};
    near.picked = pick_neighbours(plan, i, near.j);
    const bool mixed = mark_others(plan, i, near.j, &near.picked, &near.other);
    const double own_only = mixed && model->shifts_along_interfaces ? 1 : 0;
    for (size_t b = 0; b < near.picked.n_fluid; b++)
        for (int l = 0; l < LANES; l++) near.counts.of[b][l] = 1 - own_only * near.other.of[b][l];
    moments_beside(plan, s, i, how, &near);
    const Pushed a = pushed_of(s, model, i);
    const WallPressure shown = wall_pressure_of(s, i);
    const Shifted c = shifted_of(s, model, i);
    const double beta = model->repulsion, p = s->p[i * s->p_step];
    radial_viscosities_of(model, s->phase[i], mu);
    likenesses(model, s->phase[i], like);
    position_of(s, i, how, x);
    approach(ahead, 0, plan, &near.picked, near.j, x, how);
    for (size_t b = 0; b < near.picked.n_fluid; b++) {
        approach(ahead, b + 1, plan, &near.picked, near.j, x, how);
        const double *others = near.other.of[b], *counts = near.counts.of[b];
        double against[LANES], alike[LANES];
        by_fluid(s, near.j + b * LANES, mu, against);
        by_fluid(s, near.j + b * LANES, like, alike);
        fetch_rest(&block, near.j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, NEEDS, how);
            pressure_pair(&a, model, &pair, true, beta * others[l], how, l, push, WEIGHTS_SQUARES);
            drag_pair(c.v, a.V, &pair, against[l], how, l, drag);
            gradient_pair(p, &pair, 1, how, l, slope);
            shifting_pair(&c, &pair, counts[l], alike[l], how, l, &carried);
        }
    }
    for (size_t b = near.picked.n_fluid; b < near.picked.n; b++) {
        const uint32_t *wall = near.j + b * LANES;
        approach(ahead, b + 1, plan, &near.picked, near.j, x, how);
        Sticking sticking;
        sticking_of(s, model, wall, mu[s->phase[i]], how, &sticking);
        fetch_rest(&block, wall, &plan->nb->bundles, WALL_NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = near_pair(&ahead[b % 2], &block, l, plan, WALL_NEEDS, how);
            pressure_wall(&a, &pair, shown_by(&shown, wall[l]), how, l, push, WEIGHTS_SQUARES);
            radial_friction_pair(c.v, a.V, &pair, &sticking, how, l, friction);
        }
    }
    pressure_end(s, i, push, how);
    viscosity_end(s, i, drag, how);
    if (near.picked.walls) viscosity_end(s, i, friction, how);
    if (mixed && model->tense) {
        const Pulled pulled = pulled_of(s, model, i, mixed, how);
        if (pulled.any) corrected_pull_beside(plan, s, i, how, &near, &pulled);
    }
    gradient_end(s, i, &near.moments, slope, 0, how);
    shifting_end(&c, s, model, i, &carried, how);
}
BESIDE_FUNCTIONS(forces_beside)

const Fusion interfacial_forces_beside = {
    .terms = {&volume_pressure_force, &radial_viscosity, &pressure_gradient, &shifting},
    .also = {&radial_friction, &corrected_tension},
    .not_together = LIST_WALLS | LIST_OTHERS, /* where walls mirror interfaces (images.c) */
    .row = BESIDE_TABLE(forces_beside),
};
