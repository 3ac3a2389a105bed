/* SPDX-License-Identifier: BSD-3-Clause */
/* Surface tension as a force on the particles beside an interface, weighted by density so that acceleration is continuous across it.
 *   q_i = sum_j grad_i W V_j over other fluids,   n_i = q_i / |q_i| where |q_i| h > 0.01, else none
 *   kappa_i = div n over neighbours that have a normal, turned round where j is of another fluid
 *   dv_i/dt = -kappa_i |s_i| n_i / rho_i,   s_i = sum_j sigma_ij 2 rho_0i / (rho_0i + rho_0j) grad_i W V_j over other fluids
 * P1 eq. 11-16 and P2 eq. 26-37. Both print kappa with the other sign, which destroys a drop. Only neighbours with a normal may count,
 * and the test of normals must be on what is not weighted by density: with all of them kappa is wrong by a factor of 3 to 8, and
 * with weights no particle of air ever has a normal. Reference densities weigh, so that sound does not shake the interface.
 *   P1 eq. 14:  kappa_i = dim sum_j e . grad_i W V_j / sum_j r |grad_i W| V_j,   e = +-n_j - n_i
 *   P2 eq. 36:  kappa_i = sum_j e . M_i grad_i W V_j,   and q and s with M_i too, of fluids and walls
 * Walls have no colour: where they are flat, what lies beside them is mirrored instead (images.c). */
#include "sim/terms/images.h"
#include "sim/terms/moments.h"
#include "sim/terms/terms.h"
#include <math.h>

static bool is_tense(const Model *model)
{
    return model->tense;
}

static bool finds_normals(const Model *model)
{
    return model->tense || model->shifts_along_interfaces;
}

INLINE Correction moments_of(const Row *row, How how)
{
    Moments moments = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            moments_pair(&moments, &pair, 1, how, l);
        }
    return moments_inverse(&moments, how);
}

static const Correction NO_CORRECTION = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/* sum_j w_j grad_i W V_j over other fluids, corrected; w: [n_phases], NULL for 1. */
INLINE void towards_others(const Row *row, const Particles *s, const Correction *M, const double *w, How how,
                           double ret[3])
{
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        const uint32_t *j = row_j(row, b);
        double weight[LANES];
        for (int l = 0; l < LANES; l++) weight[l] = b->other[l] * (w ? w[s->phase[j[l]]] : 1);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double c = weight[l] * b->V[l] * b->F[l];
            for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, c, b->x[d][l], how);
        }
    }
    correct(M, sum, how, ret);
}

INLINE double magnitude(const double a[3], How how)
{
    return sqrt(DOT(a, a, how));
}

INLINE void find_normal(const Row *row, Particles *s, const Model *model, How how, bool corrected)
{
    const size_t i = row->i;
    double q[3] = {0, 0, 0}, size = 0;
    if (row->mixed) {
        Row room;
        const Row *seen = row_with_images(row, s, model, &room);
        const Correction M = corrected ? moments_of(seen, how) : NO_CORRECTION;
        towards_others(seen, s, &M, NULL, how, q);
        size = magnitude(q, how);
    }
    const double inverse = size * model->kernel.h > 0.01 ? 1 / size : 0;
    for (int d = 0; d < how.dim; d++) s->normal[d][i] = q[d] * inverse;
}

INLINE void interface_normal_row(const Row *row, Particles *s, const Model *model, How how)
{
    find_normal(row, s, model, how, false);
}
ROW_FUNCTIONS(interface_normal_row)

INLINE void corrected_normal_row(const Row *row, Particles *s, const Model *model, How how)
{
    find_normal(row, s, model, how, true);
}
ROW_FUNCTIONS(corrected_normal_row)

/* n_j as seen from i, less n_i, along direction d; 0 where j has none. Of mixed rows. */
INLINE double turned(const Pair *pair, const double n[3], double valid, int d)
{
    return valid * ((1 - 2 * pair->other) * pair->normal[d] - n[d]);
}

INLINE double has_normal(const Pair *pair, How how)
{
    return DOT(pair->normal, pair->normal, how) > 0.5 ? 1 : 0;
}

/* P1 eq. 14 */
INLINE double curvature(const Row *row, const double n[3], How how)
{
    Lanes above = {0}, below = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double valid = has_normal(&pair, how), c = pair.V * pair.F;
            for (int d = 0; d < how.dim; d++) add_product(&above, l, c * turned(&pair, n, valid, d), pair.x[d], how);
            add_product(&below, l, -valid * c, pair.r * pair.r, how);
        }
    const double all = lanes_sum(&below);
    return all > 0 ? how.dim * lanes_sum(&above) / all : 0;
}

/* P2 eq. 36: the trace of M times sum_j e (x) grad_i W V_j. */
INLINE double corrected_curvature(const Row *row, const Correction *M, const double n[3], How how)
{
    Lanes sum[3][3] = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double valid = has_normal(&pair, how), c = pair.V * pair.F;
            for (int a = 0; a < how.dim; a++) {
                const double e = c * turned(&pair, n, valid, a);
                for (int d = 0; d < how.dim; d++) add_product(&sum[a][d], l, e, pair.x[d], how);
            }
        }
    double trace = 0, column[3];
    for (int a = 0; a < how.dim; a++) {
        correct(M, sum[a], how, column);
        trace += column[a];
    }
    return trace;
}

INLINE void pull(const Row *row, Particles *s, const Model *model, How how, bool corrected)
{
    const size_t i = row->i;
    const unsigned mine = s->phase[i];
    double n[3], force[3], weight[MNS_MAX_FLUIDS];
    if (!row->mixed) return;
    for (int d = 0; d < how.dim; d++) n[d] = s->normal[d][i];
    if (!(magnitude(n, how) > 0.5)) return;
    const double rho0 = model->phase[mine].rho0;
    for (size_t a = 0; a < model->n_phases; a++)
        weight[a] = model->tension[mine][a] * 2 * rho0 / (rho0 + model->phase[a].rho0);
    Row room;
    const Row *seen = row_with_images(row, s, model, &room);
    const Correction M = corrected ? moments_of(seen, how) : NO_CORRECTION;
    towards_others(seen, s, &M, weight, how, force);
    const double kappa = corrected ? corrected_curvature(seen, &M, n, how) : curvature(seen, n, how);
    const double scale = -kappa * magnitude(force, how) / s->rho[i];
    for (int d = 0; d < how.dim; d++) s->a[d][i] += scale * n[d];
}

INLINE void surface_tension_row(const Row *row, Particles *s, const Model *model, How how)
{
    pull(row, s, model, how, false);
}
ROW_FUNCTIONS(surface_tension_row)

INLINE void corrected_tension_row(const Row *row, Particles *s, const Model *model, How how)
{
    pull(row, s, model, how, true);
}
ROW_FUNCTIONS(corrected_tension_row)

const Term interface_normal = {
    .name = "interface normal",
    .source = "P1 eq. 12, not weighted",
    .equation = "n_i = q_i/|q_i|,  q_i = sum_j grad_i W V_j over other fluids",
    .on = ON_FLUID,
    .needed = finds_normals,
    .needs = NEED_F | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(NORMAL),
    .row = ROW_TABLE(interface_normal_row),
};

static void no_normal(const RowPlan *plan, Particles *s, size_t i)
{
    (void)plan;
    for (int d = 0; d < s->dim; d++) s->normal[d][i] = 0;
}

const Fusion no_interface = {
    .terms = {&corrected_normal},
    .not_for = LIST_WALLS | LIST_OTHERS,
    .row = {[0 ... LEVELS - 1] = {no_normal, no_normal}},
};

const Term surface_tension = {
    .name = "surface tension",
    .source = "P1 eq. 13-16",
    .equation = "dv_i/dt -= kappa_i |s_i| n_i/rho_i,  kappa_i = dim sum_j e . grad_i W V_j / sum_j r |grad_i W| V_j",
    .on = ON_FLUID,
    .needed = is_tense,
    .needs = NEED_F | NEED_STATE | NEED_NORMAL | NEED_OTHERS,
    .writes = FIELD(A),
    .idle_inside = true,
    .row = ROW_TABLE(surface_tension_row),
};

const Term corrected_normal = {
    .name = "interface normal",
    .source = "P2 eq. 35, not weighted",
    .equation = "n_i = q_i/|q_i|,  q_i = sum_j M_i grad_i W V_j over other fluids",
    .on = ON_FLUID,
    .needed = finds_normals,
    .needs = NEED_F | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(NORMAL),
    .row = ROW_TABLE(corrected_normal_row),
};

const Term corrected_tension = {
    .name = "surface tension",
    .source = "P2 eq. 28-37",
    .equation = "dv_i/dt -= kappa_i |s_i| n_i/rho_i,  kappa_i = sum_j e . M_i grad_i W V_j",
    .on = ON_FLUID,
    .needed = is_tense,
    .needs = NEED_F | NEED_STATE | NEED_NORMAL | NEED_OTHERS,
    .writes = FIELD(A),
    .idle_inside = true,
    .row = ROW_TABLE(corrected_tension_row),
};
