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
#include "sim/terms/tension.h"
#include "sim/terms/images.h"
#include "sim/terms/terms.h"
#include <math.h>

double magnitude_of(double square)
{
    return sqrt(square);
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

/* w: of each fluid, NULL for 1. */
INLINE void towards_others(const Row *row, const Particles *s, const double *w, How how, Lanes sum[3])
{
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        const uint32_t *j = row_j(row, b);
        double weight[LANES];
        for (int l = 0; l < LANES; l++) weight[l] = w ? w[s->phase[j[l]]] : b->other[l];
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            towards_pair(&pair, weight[l], how, l, sum);
        }
    }
}

INLINE void find_normal(const Row *row, Particles *s, const Model *model, How how, bool corrected)
{
    if (!row->mixed) {
        normal_none(s, row->i, how);
        return;
    }
    Row room;
    const Row *seen = row_with_images(row, s, model, &room);
    Lanes sum[3] = {0};
    const Correction M = corrected ? moments_of(seen, how) : NO_CORRECTION;
    towards_others(seen, s, NULL, how, sum);
    normal_end(s, model, row->i, &M, sum, how);
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

INLINE double curvature(const Row *row, const Pulled *a, How how)
{
    Lanes above = {0}, below = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            curvature_pair(a, &pair, pair.other, how, l, &above, &below);
        }
    return curvature_end(&above, &below, how);
}

INLINE double corrected_curvature(const Row *row, const Pulled *a, const Correction *M, How how)
{
    Lanes sum[3][3] = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            corrected_curvature_pair(a, &pair, pair.other, how, l, sum);
        }
    return corrected_trace(M, sum, how);
}

INLINE void pull(const Row *row, Particles *s, const Model *model, How how, bool corrected)
{
    const Pulled a = pulled_of(s, model, row->i, row->mixed, how);
    if (!a.any) return;
    Row room;
    const Row *seen = row_with_images(row, s, model, &room);
    Lanes towards[3] = {0};
    const Correction M = corrected ? moments_of(seen, how) : NO_CORRECTION;
    towards_others(seen, s, a.weight, how, towards);
    const double kappa = corrected ? corrected_curvature(seen, &a, &M, how) : curvature(seen, &a, how);
    pull_end(s, row->i, &a, kappa, &M, towards, how);
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
    normal_none(s, i, (How){.dim = s->dim});
}

const Fusion no_interface = {
    .terms = {&corrected_normal},
    .not_for = LIST_OTHERS,
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
    .beside = LIST_OTHERS,
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
    .beside = LIST_OTHERS,
    .row = ROW_TABLE(corrected_tension_row),
};
