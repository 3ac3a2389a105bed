/* SPDX-License-Identifier: BSD-3-Clause */
/* Particles are shifted to where there are fewer, once a step, with what they carry put right to first order.   P2 eq. 49-52, 57
 *   dx_i = -A h U_i dt sum_j V_j grad_i W,   at most dx/10;   beside an interface only along it: dx_i -= (dx_i . n_i) n_i
 *   U_i = max_j |v_j - v_i| over particles of the same fluid within the support: P2 prints |v_i|, which is another in each frame of reference,
 * so that what only drifts would be stirred; what disorders particles is how their neighbours move past them
 *   v_i += dx_i . sum_j (v_j - v_i) grad_i W V_j, density alike, over particles of the same fluid. With M_i of
 * these particles linear fields would be exact beside an interface too, but in a spray of two or three neighbours the extrapolation grows at every step
 * A fluid that fills goes through the interface too, more strongly, and carries nothing: of few neighbours of its own little is known.
 * P2's original shifts through interfaces too and corrects from all fluids, which mixes densities of water and air.
 * Within reach of a free surface there is no shift, in a domain that fluids do not fill. */
#include "sim/terms/push.h"
#include "sim/terms/terms.h"

static const double FARTHEST =
    0.1; /* of a spacing that a shift takes a particle: what it carries is put right to first order only */

/* Times as strongly are fluids that fill shifted, a light liquid at least and a gas: with 5 a gas has voids in a dam break's bubbles, with 20 it is
 * stirred at rest; with 10 the pressure beside a light liquid at rest is 4 % off. */
static const double FILLING = 5, FILLING_GAS = 10;

static double strength_of(const Model *model, const Phase *fluid)
{
    return model->shifting * (fluid->fills ? FILLING + (FILLING_GAS - FILLING) * fluid->resists : 1);
}

/* Where a particle goes, for each m/s of U; returns how far that is before what leads through an interface is left out. */
static double find_way(const Particles *s, const Model *model, size_t i, double dx[3])
{
    const int dim = s->dim;
    const Phase *fluid = &model->phase[s->phase[i]];
    const bool along = model->shifts_along_interfaces && !fluid->fills;
    const double scale = -strength_of(model, fluid) * model->kernel.h * model->dt;
    double through = 0, size = 0;
    for (int d = 0; d < dim; d++) {
        dx[d] = scale * s->concentration[d][i];
        size += dx[d] * dx[d];
        through += along ? dx[d] * s->normal[d][i * s->normal_step] : 0;
    }
    for (int d = 0; along && d < dim; d++) dx[d] -= through * s->normal[d][i * s->normal_step];
    return sqrt(size);
}

double shifting_scale(const Model *model, double far, double U2)
{
    const double U = sqrt(U2), most = FARTHEST * model->dx;
    return U * far > most ? most / far : U;
}

Shifted shifted_of(const Particles *s, const Model *model, size_t i)
{
    Shifted a = {.z = particles_impedance(s, model, i), .carries = model->phase[s->phase[i]].fills ? 0 : 1};
    a.far = find_way(s, model, i, a.dx);
    for (int d = 0; d < s->dim; d++) a.v[d] = s->v[d][i * s->v_step];
    return a;
}

/* By the differences of velocity before any was carried along, which the row has left in rate. */
static void go(Particles *s, const Model *model, size_t first, size_t last)
{
    for (size_t i = first; i < last; i++) {
        double dx[3];
        const double far = find_way(s, model, i, dx), scale = shifting_scale(model, far, s->rate[i]);
        for (int d = 0; d < s->dim; d++) s->x[d][i * s->x_step] += scale * dx[d];
    }
}

INLINE void concentration_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)model;
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            add_along(&pair, pair.V * pair.F, how, l, sum);
        }
    for (int d = 0; d < how.dim; d++) s->concentration[d][row->i] = lanes_sum(&sum[d]);
}
ROW_FUNCTIONS(concentration_row)

/* same_only: others of the same fluid count alone. Two loops, as the compiler gives up one that asks. */
INLINE void shifting_sums(const Row *row, const Particles *s, const Shifted *a, const double *like, bool same_only,
                          How how, ShiftingSums *sum)
{
    double alike[LANES];
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        by_fluid(s, row_j(row, b), like, alike);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            shifting_pair(a, &pair, same_only ? 1 - pair.other : 1, alike[l], how, l, sum);
        }
    }
}

INLINE void shifting_row(const Row *row, Particles *s, const Model *model, How how)
{
    const Shifted a = shifted_of(s, model, row->i);
    const bool same_only = row->mixed && model->shifts_along_interfaces;
    double like[MNS_MAX_FLUIDS];
    likenesses(model, s->phase[row->i], like);
    ShiftingSums sum = {0};
    if (same_only) shifting_sums(row, s, &a, like, true, how, &sum);
    else shifting_sums(row, s, &a, like, false, how, &sum);
    shifting_end(&a, s, model, row->i, &sum, how);
}
ROW_FUNCTIONS(shifting_row)

const Term concentration = {
    .name = "concentration",
    .source = "P2 eq. 49",
    .equation = "grad C_i = sum_j V_j grad_i W",
    .on = ON_FLUID,
    .needed = is_shifted,
    .needs = NEED_F | NEED_STATE,
    .writes = FIELD(CONCENTRATION),
    .row = ROW_TABLE(concentration_row),
};

const Term shifting = {
    .name = "particle shifting",
    .source = "P2 eq. 50-52, 57",
    .equation =
        "dx_i = -A h max|v_ij| dt sum_j V_j grad_i W, along interfaces;  v, rho += dx_i . grad of the same fluid",
    .on = ON_FLUID,
    .needed = is_shifted,
    .needs = NEED_F | NEED_V | NEED_STATE | NEED_SHEPARD | NEED_OTHERS,
    .writes = FIELD(V) | FIELD(RHO),
    .row = ROW_TABLE(shifting_row),
};

const Local shifted_position = {
    .name = "shifted position",
    .source = "P2 eq. 50, 52",
    .equation = "x_i += dx_i",
    .on = ON_FLUID,
    .needed = is_shifted,
    .apply = go,
    .writes = FIELD(X),
};
