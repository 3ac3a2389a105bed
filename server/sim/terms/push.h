/* SPDX-License-Identifier: BSD-3-Clause */
/* Pressure forces and shifting, pair by pair (pressure_force.c, shifting.c). */
#ifndef SIM_TERMS_PUSH_H
#define SIM_TERMS_PUSH_H

#include "sim/terms/average.h"
#include <math.h>

/* --- pressure ---------------------------------------------------------------------------------------------------------- */

/* How volumes weigh the two pressures of a pair: by their product (P1) or each by its own square (P2). */
typedef enum Weights { WEIGHTS_PRODUCT, WEIGHTS_SQUARES } Weights;

/* What is fixed in the pairs of one particle. */
typedef struct Pushed {
    double z, V, P; /* P = p / Gamma */
} Pushed;

INLINE Pushed pushed_of(const Particles *s, const Model *model, size_t i)
{
    return (Pushed){particles_impedance(s, model, i), particles_volume(s, model, i),
                    s->p[i * s->p_step] * (1 / s->shepard[i])}; /* as its neighbours have it, to the last bit */
}

INLINE double weighted(const Pushed *a, const Pair *pair, double mine, double its, Weights weights)
{
    return weights == WEIGHTS_PRODUCT ? a->V * pair->V * (mine + its) : a->V * a->V * mine + pair->V * pair->V * its;
}

/* repulsion: beta with a particle of another fluid, else 0; repels: it may be another. */
INLINE void pressure_pair(const Pushed *a, const Model *model, const Pair *pair, bool repels, double repulsion, How how,
                          int l, Lanes sum[3], Weights weights)
{
    const double t = average_tilt(model, a->z, pair, 1 / (a->z + pair->z)), P = pair->p * pair->shepard;
    double mine = (1 + t) * a->P, its = (1 - t) * (P + pair->jump * pair->shepard);
    if (repels) {
        mine += repulsion * fabs(a->P);
        its += repulsion * fabs(P);
    }
    add_along(pair, weighted(a, pair, mine, its, weights) * pair->F, how, l, sum);
}

/* What walls show the fluid of a particle. */
typedef struct WallPressure {
    const double *of; /* by index of wall particle */
    uint32_t first_wall;
} WallPressure;

INLINE WallPressure wall_pressure_of(const Particles *s, size_t i)
{
    return (WallPressure){s->p_wall[s->phase[i]], (uint32_t)particles_fluid(s)};
}

INLINE double shown_by(const WallPressure *shown, uint32_t j)
{
    return shown->of[j - shown->first_wall];
}

/* p_w: what the wall shows this fluid. */
INLINE void pressure_wall(const Pushed *a, const Pair *pair, double p_w, How how, int l, Lanes sum[3], Weights weights)
{
    add_along(pair, weighted(a, pair, a->P, p_w, weights) * pair->F, how, l, sum);
}

INLINE void pressure_end(Particles *s, size_t i, const Lanes sum[3], How how)
{
    for (int d = 0; d < how.dim; d++) s->a[d][i] -= lanes_sum(&sum[d]) / s->m[i];
}

/* --- shifting ---------------------------------------------------------------------------------------------------------- */

/* A particle and where it is shifted, for each m/s by which neighbours move past it. */
typedef struct Shifted {
    double dx[3], far, v[3], z; /* far: how far that would be through interfaces too */
    double carries;             /* 0 of a fluid that fills, else 1 */
} Shifted;

Shifted shifted_of(const Particles *s, const Model *model, size_t i);

/* By how much of that, where the largest difference of velocity has the square U2. */
double shifting_scale(const Model *model, double far, double U2);

/* Of dx . sum_j (f_j - f_i) grad_i W V_j for what particles carry: velocity, and in of[3] rho c_i; the largest |v_j - v_i|^2, and the largest
 * 1/Gamma_j. */
typedef struct ShiftingSums {
    Lanes of[4], fastest, thinnest;
} ShiftingSums;

/* c_i / c_j for each fluid: what z = rho c of its particles would be in a fluid of ours. */
INLINE void likenesses(const Model *model, unsigned fluid, double ret[MNS_MAX_FLUIDS])
{
    for (size_t k = 0; k < model->n_phases; k++) ret[k] = model->phase[fluid].c / model->phase[k].c;
}

/* 1/Gamma of particles at a free surface. Who has one in reach is not shifted: what is missing there looks like room, and to go to it would lift
 * the whole surface. */
static const double MOST_THIN = 1 / 0.85;

/* counts: 1 or 0; like: c_i / c_j. Pairs out of reach have no slope of the kernel. */
INLINE void shifting_pair(const Shifted *a, const Pair *pair, double counts, double like, How how, int l,
                          ShiftingSums *sum)
{
    const double c = counts * (pair->V * pair->F * DOT(a->dx, pair->x, how));
    double v2 = 0;
    for (int d = 0; d < how.dim; d++) {
        const double dv = pair->v[d] - a->v[d];
        add_product(&sum->of[d], l, c, dv, how);
        v2 += dv * dv;
    }
    add_product(&sum->of[3], l, c, pair->z * like - a->z, how);
    v2 = pair->F != 0 ? counts * v2 : 0;
    const double thin = pair->F != 0 ? pair->shepard : 0;
    sum->fastest.of[l] = v2 > sum->fastest.of[l] ? v2 : sum->fastest.of[l];
    sum->thinnest.of[l] = thin > sum->thinnest.of[l] ? thin : sum->thinnest.of[l];
}

INLINE void shifting_end(const Shifted *a, Particles *s, const Model *model, size_t i, const ShiftingSums *sum, How how)
{
    double fastest = 0, thinnest = 1 / s->shepard[i];
    for (int l = 0; l < LANES; l++) {
        fastest = sum->fastest.of[l] > fastest ? sum->fastest.of[l] : fastest;
        thinnest = sum->thinnest.of[l] > thinnest ? sum->thinnest.of[l] : thinnest;
    }
    if (thinnest > MOST_THIN && !model->filled) fastest = 0;
    const double scale = shifting_scale(model, a->far, fastest);
    s->rate[i] = fastest; /* from which its way is found again, when all have been looked at where they were */
    const double carried = a->carries * scale;
    for (int d = 0; d < how.dim; d++) s->v[d][i * s->v_step] += carried * lanes_sum(&sum->of[d]);
    s->rho[i] += carried * lanes_sum(&sum->of[3]) / model->phase[s->phase[i]].c;
}

#endif
