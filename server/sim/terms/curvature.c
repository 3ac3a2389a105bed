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
#include "sim/fused.h"
#include "sim/terms/images.h"
#include "sim/terms/terms.h"
#include <math.h>

double tension_share_beside(const Model *model, size_t a, size_t b, size_t third)
{
    return 0.5 * (model->tension[a][b] + model->tension[a][third] - model->tension[b][third]);
}

void tension_share(Model *model)
{
    const size_t n = model->n_phases;
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < n; b++) {
            double sum = n > 2 || a == b ? 0 : 0.5 * model->tension[a][b];
            for (size_t k = 0; k < n; k++)
                if (a != b && k != a && k != b) sum += tension_share_beside(model, a, b, k);
            model->tension_share[a][b] = n > 3 ? sum / (double)(n - 2) : sum;
        }
}

INLINE void clear_curvature(Particles *s, size_t i)
{
    s->curvature[i] = curvature_step(s)[i] = curvature_weights(s)[i] = 0;
}

/* The divergence of the normals around, and what it counts for: negative where there are three fluids. */
INLINE double divergence_end(Particles *s, const Model *model, size_t i, const Moments *moments, const Lanes towards[3],
                             const Lanes sum[3][3], unsigned fluids, How how)
{
    const Correction M = moments_inverse(moments, how);
    double q[3];
    for (int d = 0; d < how.dim; d++) q[d] = lanes_sum(&towards[d]);
    const double w = weight_of_interface(model, q, how) * particles_volume(s, model, i);
    curvature_weights(s)[i] = model->n_phases > 2 && are_two_others(fluids, s->phase[i]) ? -w : w;
    return corrected_trace(&M, sum, how);
}

/* n: the particle's own normal; false: it has none. */
INLINE bool own_normal(const Particles *s, size_t i, How how, double n[3])
{
    for (int d = 0; d < how.dim; d++) n[d] = s->normal[d][i * s->normal_step];
    return DOT(n, n, how) > 0.5;
}

/* Of one pair to all sums. among: more than two fluids, of which others do not count. */
INLINE void divergence_pair(const double n[3], const Pair *pair, double other, double among, How how, int l,
                            Lanes towards[3], Moments *moments, Lanes sum[3][3])
{
    const double counts = has_normal(pair, how) * (1 - among * other);
    towards_pair(pair, other, how, l, towards);
    moments_pair(moments, pair, counts, how, l);
    curvature_pair(n, pair, other, counts, how, l, sum);
}

INLINE double find_divergence(const Row *row, Particles *s, const Model *model, How how)
{
    double n[3];
    Row room;
    clear_curvature(s, row->i);
    if (!row->mixed || !own_normal(s, row->i, how, n)) return 0;
    const Row *seen = row_with_images(row, s, model, &room);
    const double among = model->n_phases > 2 ? 1 : 0;
    unsigned fluids = 0;
    Lanes towards[3] = {0}, sum[3][3] = {0};
    Moments moments = {0};
    for (const Block *b = seen->block; b < seen->block + seen->n_fluid; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            divergence_pair(n, &pair, pair.other, among, how, l, towards, &moments, sum);
        }
    for (const Block *b = row->block; among > 0 && b < row->block + row->n_fluid; b++)
        fluids |= fluids_in_reach(s, row_j(row, b), b->F);
    return divergence_end(s, model, row->i, &moments, towards, sum, fluids, how);
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

INLINE double divergence_beside(const RowPlan *plan, Particles *s, size_t i, How how)
{
    enum { NEEDS = NEED_F | NEED_STATE | NEED_NORMAL };
    const double among = plan->model->n_phases > 2 ? 1 : 0;
    uint32_t j[PICKED_MAX];
    double x[3], n[3];
    unsigned fluids = 0;
    Lanes towards[3] = {0}, sum[3][3] = {0};
    Moments moments = {0};
    Block block;
    Marks other;
    clear_curvature(s, i);
    if (!own_normal(s, i, how, n)) return 0;
    const Picked picked = pick_neighbours(plan, i, j);
    if (!mark_others(plan, i, j, &picked, &other)) return 0;
    position_of(s, i, how, x);
    for (size_t b = 0; b < picked.n_fluid; b++) {
        const double *beyond = beyond_reach(plan, &picked, b);
        double F[LANES];
        fetch_block(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = fetched_pair(&block, l, beyond, x, plan, NEEDS, how);
            F[l] = pair.F;
            divergence_pair(n, &pair, other.of[b][l], among, how, l, towards, &moments, sum);
        }
        if (among > 0) fluids |= fluids_in_reach(s, j + b * LANES, F);
    }
    return divergence_end(s, plan->model, i, &moments, towards, sum, fluids, how);
}

INLINE void raw_curvature_beside(const RowPlan *plan, Particles *s, size_t i, How how)
{
    curvature_step(s)[i] = divergence_beside(plan, s, i, how);
}
BESIDE_FUNCTIONS(raw_curvature_beside)

INLINE void raw_curvature_first_beside(const RowPlan *plan, Particles *s, size_t i, How how)
{
    s->curvature[i] = divergence_beside(plan, s, i, how);
}
BESIDE_FUNCTIONS(raw_curvature_first_beside)

/* false: no other fluid is in reach. */
INLINE bool mean_beside(const RowPlan *plan, const Particles *s, size_t i, const double *kappa, How how, double *ret)
{
    enum { NEEDS = NEED_W };
    uint32_t j[PICKED_MAX];
    double x[3];
    Mean mean = {0};
    Block block;
    Marks other;
    const Picked picked = pick_neighbours(plan, i, j);
    if (!mark_others(plan, i, j, &picked, &other)) return false;
    position_of(s, i, how, x);
    for (size_t b = 0; b < picked.n_fluid; b++) {
        const double *beyond = beyond_reach(plan, &picked, b);
        double weight[LANES], both[LANES];
        weigh_curvatures(curvature_weights(s), kappa, j + b * LANES, other.of[b], weight, both);
        fetch_block(&block, j + b * LANES, &plan->nb->bundles, NEEDS, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = fetched_pair(&block, l, beyond, x, plan, NEEDS, how);
            mean_pair(&pair, weight[l], both[l], how, l, &mean);
        }
    }
    *ret = mean_end(&mean, s, i, plan->at_zero, kappa);
    return true;
}

/* Of mixed rows. */
INLINE double mean_of(const Row *row, const Particles *s, const Model *model, const double *kappa, How how)
{
    Row room;
    Mean mean = {0};
    const Row *seen = row_with_images(row, s, model, &room);
    for (const Block *b = seen->block; b < seen->block + seen->n_fluid; b++) {
        double weight[LANES], both[LANES];
        weigh_curvatures(curvature_weights(s), kappa, row_j(seen, b), b->other, weight, both);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            mean_pair(&pair, weight[l], both[l], how, l, &mean);
        }
    }
    return mean_end(&mean, s, row->i, kernel_at_zero(&model->kernel), kappa);
}

/* Where a mean is taken of what it was taken of before: what it leaves of a wave is given back. */
INLINE void sharpen(Particles *s, size_t i, double mean)
{
    s->curvature[i] += SHARPNESS * (curvature_step(s)[i] - mean);
}

INLINE void sharpen_once(Particles *s, size_t i, double mean)
{
    const double once = curvature_step(s)[i];
    s->curvature[i] = once + SHARPNESS * (once - mean);
}

/* Each as a row and beside walls or other fluids: what the mean is of, and what is done with it. */
#define MEAN(name, of, then)                                                                                           \
    INLINE void name##_row(const Row *row, Particles *s, const Model *model, How how)                                  \
    {                                                                                                                  \
        const size_t i = row->i;                                                                                       \
        if (!row->mixed) return;                                                                                       \
        const double mean = mean_of(row, s, model, of, how);                                                           \
        then;                                                                                                          \
    }                                                                                                                  \
    ROW_FUNCTIONS(name##_row)                                                                                          \
    INLINE void name##_beside(const RowPlan *plan, Particles *s, size_t i, How how)                                    \
    {                                                                                                                  \
        double mean;                                                                                                   \
        if (!mean_beside(plan, s, i, of, how, &mean)) return;                                                          \
        then;                                                                                                          \
    }                                                                                                                  \
    BESIDE_FUNCTIONS(name##_beside)                                                                                    \
    const Fusion name##_alone = {.terms = {&name},                                                                     \
                                 .not_together = LIST_WALLS | LIST_OTHERS, /* where walls mirror interfaces */         \
                                 .row = BESIDE_TABLE(name##_beside)};

MEAN(mean_curvature, curvature_step(s), s->curvature[i] = mean)
MEAN(next_mean, s->curvature, curvature_step(s)[i] = mean)
MEAN(sharp_curvature, curvature_step(s), sharpen(s, i, mean))
MEAN(sharp_mean, curvature_step(s), sharpen_once(s, i, mean))

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

/* With images too, as one is farther away than what it is of. */
#define AMONG_THEIR_OWN(term, body)                                                                                    \
    {                                                                                                                  \
        .terms = {&term}, .not_for = LIST_OTHERS, .with_images = true, .row = { [0 ... LEVELS - 1] = {body, body} }    \
    }
#define BESIDE_OTHERS(term, body)                                                                                      \
    {                                                                                                                  \
        .terms = {&term}, .not_together = LIST_WALLS | LIST_OTHERS, .row = BESIDE_TABLE(body)                          \
    }
const Fusion raw_curvature_alone = BESIDE_OTHERS(raw_curvature, raw_curvature_beside);
const Fusion raw_curvature_first_alone = BESIDE_OTHERS(raw_curvature_first, raw_curvature_first_beside);
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
                       .needs = (pairs) | NEED_OTHERS,                                                                 \
                       .writes = fields,                                                                               \
                       .row = ROW_TABLE(term##_row)}

enum { DIVERGENCE = NEED_F | NEED_STATE | NEED_NORMAL };
CURVATURE(raw_curvature, "curvature", "P2 eq. 36, M of those with a normal", "k_i = sum_j e . M'_i grad_i W V_j",
          DIVERGENCE, FIELD(CURVATURE));
CURVATURE(raw_curvature_first, "curvature", "P2 eq. 36, M of those with a normal", "k_i = sum_j e . M'_i grad_i W V_j",
          DIVERGENCE, FIELD(CURVATURE));
CURVATURE(mean_curvature, "mean curvature", "schemes/dissipation.md",
          "S k_i = sum_j +-k_j w_j W V_j / sum_j w_j W V_j,  w_j = (dx |q_j|)^4", NEED_W, FIELD(CURVATURE));
CURVATURE(next_mean, "mean curvature", "schemes/dissipation.md",
          "S k_i = sum_j +-k_j w_j W V_j / sum_j w_j W V_j,  w_j = (dx |q_j|)^4", NEED_W, 0);
CURVATURE(sharp_curvature, "sharp curvature", "schemes/dissipation.md", "kappa_i = S k_i + 3 (S S k_i - S S S k_i)",
          NEED_W, FIELD(CURVATURE));
CURVATURE(sharp_mean, "sharp curvature", "schemes/incompressible.md", "kappa_i = S k_i + 3 (S k_i - S S k_i)", NEED_W,
          FIELD(CURVATURE));
