/* SPDX-License-Identifier: BSD-3-Clause */
/* Curvature of interfaces, positive where a particle's own fluid is inside.
 *   raw    kappa_i = sum_j e . M'_i grad_i W V_j,   e = +-n_j - n_i,   M' of those that have a normal       P1 eq. 14, P2 eq. 36
 *   mean   S kappa_i = sum_j +-kappa_j w_j W V_j / sum_j w_j W V_j,    w_j = (dx |q_j|)^4,   i itself included
 *   sharp  S kappa + 3 (S S kappa - S S S kappa)  where pressures are of a state (P1, P2),   S kappa + 3 (S kappa - S S kappa)  of P4
 * signs turned round where j is of another fluid. Raw ones scatter by tenths; a mean over them does not, but rounds off waves, as the kernel of the
 * normals and that of their divergence do already: each takes k^2 <r^2>/2 of them, which the last line gives back. With P2's M, of all
 * neighbours, a drop has 5 % too little of its jump, and with P1's quotient too much. The fourth power is of how sharp the colour changes: with the
 * first one, what the kernel smears across counts as bent. A particle without a normal that has another fluid in reach has a mean too, as both
 * of a pair must have one. Where three fluids meet, the surface of a fluid is that to all others, and only its own particles tell of it. */
#include "sim/terms/curvature.h"
#include "sim/terms/images.h"
#include "sim/terms/terms.h"
#include <math.h>

void share_tension(Model *model)
{
    const size_t n = model->n_phases;
    double all = 0;
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < a; b++) all += model->tension[a][b];
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < n; b++) {
            double mine = 0; /* of its tensions, to both others */
            for (size_t k = 0; k < n; k++) mine += model->tension[a][k];
            model->tension_share[a][b] = a == b ? 0 : n == 3 ? mine - 0.5 * all : 0.5 * model->tension[a][b];
        }
}

INLINE bool sees_two_others(const Row *row, const Particles *s)
{
    const unsigned mine = s->phase[row->i];
    unsigned one = mine;
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++)
        for (int l = 0; l < LANES; l++) {
            const unsigned its = s->phase[row_j(row, b)[l]];
            if (its == mine || !(b->F[l] < 0)) continue;
            if (one != mine && its != one) return true;
            one = its;
        }
    return false;
}

INLINE void clear_curvature(Particles *s, size_t i)
{
    s->curvature[i] = curvature_step(s)[i] = curvature_weights(s)[i] = 0;
}

/* The divergence of the normals around, and what it counts for: negative where there are three fluids. */
INLINE double find_divergence(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    double n[3], q[3];
    Row room;
    clear_curvature(s, i);
    for (int d = 0; d < how.dim; d++) n[d] = s->normal[d][i * s->normal_step];
    if (!row->mixed || !(DOT(n, n, how) > 0.5)) return 0;
    const Row *seen = row_with_images(row, s, model, &room);
    const double other_counts = model->n_phases > 2 ? 0 : 1;
    Lanes towards[3] = {0}, sum[3][3] = {0};
    Moments moments = {0};
    for (const Block *b = seen->block; b < seen->block + seen->n_fluid; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double counts = has_normal(&pair, how) * (1 - (1 - other_counts) * pair.other);
            towards_pair(&pair, pair.other, how, l, towards);
            moments_pair(&moments, &pair, counts, how, l);
            curvature_pair(n, &pair, pair.other, counts, how, l, sum);
        }
    const Correction M = moments_inverse(&moments, how);
    for (int d = 0; d < how.dim; d++) q[d] = lanes_sum(&towards[d]);
    const double w = weight_of_interface(model, q, how);
    curvature_weights(s)[i] = model->n_phases > 2 && sees_two_others(row, s) ? -w : w;
    return corrected_trace(&M, sum, how);
}

INLINE void raw_curvature_row(const Row *row, Particles *s, const Model *model, How how)
{
    curvature_step(s)[row->i] = find_divergence(row, s, model, how);
}
ROW_FUNCTIONS(raw_curvature_row)

INLINE void raw_curvature_first_row(const Row *row, Particles *s, const Model *model, How how)
{
    s->curvature[row->i] = find_divergence(row, s, model, how);
}
ROW_FUNCTIONS(raw_curvature_first_row)

/* Of mixed rows. */
INLINE double mean_of(const Row *row, const Particles *s, const Model *model, const double *kappa)
{
    Row room;
    const Row *seen = row_with_images(row, s, model, &room);
    Mean mean = mean_of_own(s, model, row->i, kernel_at_zero(&model->kernel), kappa);
    for (const Block *b = seen->block; b < seen->block + seen->n_fluid; b++)
        add_to_mean(&mean, s, row_j(seen, b), b->W, b->V, b->other, kappa);
    return mean_end(&mean);
}

INLINE void mean_curvature_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)how;
    if (row->mixed) s->curvature[row->i] = mean_of(row, s, model, curvature_step(s));
}
ROW_FUNCTIONS(mean_curvature_row)

INLINE void next_mean_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)how;
    if (row->mixed) curvature_step(s)[row->i] = mean_of(row, s, model, s->curvature);
}
ROW_FUNCTIONS(next_mean_row)

INLINE void sharp_curvature_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)how;
    const double twice = curvature_step(s)[row->i];
    if (!row->mixed) return;
    s->curvature[row->i] += SHARPNESS * (twice - mean_of(row, s, model, curvature_step(s)));
}
ROW_FUNCTIONS(sharp_curvature_row)

INLINE void sharp_mean_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)how;
    const double once = curvature_step(s)[row->i];
    if (!row->mixed) return;
    s->curvature[row->i] = once + SHARPNESS * (once - mean_of(row, s, model, curvature_step(s)));
}
ROW_FUNCTIONS(sharp_mean_row)

/* Of particles that have no other fluid in reach. */
static void no_curvature(const RowPlan *plan, Particles *s, size_t i)
{
    (void)plan;
    clear_curvature(s, i);
}

static void nothing(const RowPlan *plan, Particles *s, size_t i)
{
    (void)plan, (void)s, (void)i;
}

#define AMONG_THEIR_OWN(term, body)                                                                                    \
    {                                                                                                                  \
        .terms = {&term}, .not_for = LIST_OTHERS, .row = { [0 ... LEVELS - 1] = {body, body} }                         \
    }
const Fusion no_raw_curvature = AMONG_THEIR_OWN(raw_curvature, no_curvature);
const Fusion no_raw_curvature_first = AMONG_THEIR_OWN(raw_curvature_first, no_curvature);
const Fusion no_mean_curvature = AMONG_THEIR_OWN(mean_curvature, nothing);
const Fusion no_next_mean = AMONG_THEIR_OWN(next_mean, nothing);
const Fusion no_sharp_curvature = AMONG_THEIR_OWN(sharp_curvature, nothing);
const Fusion no_sharp_mean = AMONG_THEIR_OWN(sharp_mean, nothing);

#define CURVATURE(term, what, of, eq, pairs, fields)                                                                   \
    const Term term = {.name = what,                                                                                   \
                       .source = of,                                                                                   \
                       .equation = eq,                                                                                 \
                       .on = ON_FLUID,                                                                                 \
                       .needed = is_tense,                                                                             \
                       .needs = NEED_F | NEED_STATE | NEED_NORMAL | NEED_OTHERS | (pairs),                             \
                       .writes = fields,                                                                               \
                       .row = ROW_TABLE(term##_row)}

CURVATURE(raw_curvature, "curvature", "P2 eq. 36, M of those with a normal", "k_i = sum_j e . M'_i grad_i W V_j", 0,
          FIELD(CURVATURE));
CURVATURE(raw_curvature_first, "curvature", "P2 eq. 36, M of those with a normal", "k_i = sum_j e . M'_i grad_i W V_j",
          0, FIELD(CURVATURE));
CURVATURE(mean_curvature, "mean curvature", "schemes/dissipation.md",
          "S k_i = sum_j +-k_j w_j W V_j / sum_j w_j W V_j,  w_j = (dx |q_j|)^4", NEED_W, FIELD(CURVATURE));
CURVATURE(next_mean, "mean curvature", "schemes/dissipation.md",
          "S k_i = sum_j +-k_j w_j W V_j / sum_j w_j W V_j,  w_j = (dx |q_j|)^4", NEED_W, 0);
CURVATURE(sharp_curvature, "sharp curvature", "schemes/dissipation.md", "kappa_i = S k_i + 3 (S S k_i - S S S k_i)",
          NEED_W, FIELD(CURVATURE));
CURVATURE(sharp_mean, "sharp curvature", "schemes/incompressible.md", "kappa_i = S k_i + 3 (S k_i - S S k_i)", NEED_W,
          FIELD(CURVATURE));
