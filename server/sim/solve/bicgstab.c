/* SPDX-License-Identifier: BSD-3-Clause */
/* Stabilised biconjugate gradients (van der Vorst 1992): for matrices that are not symmetric. Their residuals can have a part along
 * the constants that no x changes, so it is taken away. */
#include "sim/solve/vectors.h"
#include <math.h>

/* p = r + beta (p - omega v) */
static void turn(const System *y, double beta, double omega, const double *restrict r, const double *restrict v,
                 double *restrict p)
{
#pragma omp parallel for simd schedule(static) num_threads(y->threads)
    for (size_t i = 0; i < y->matrix.n; i++) p[i] = r[i] + beta * (p[i] - omega * v[i]);
}

/* ret = L z, z = M^-1 a. Without its mean it is multiplied by itself and by b. */
static Products advance(System *y, Precondition *precondition, const double *a, double *z, double *ret, const double *b)
{
    precondition(y, a, z);
    const double mean = vectors_multiply(y, z, ret);
    return vectors_level(y, ret, mean, b);
}

/* x += alpha z + omega zs;  r -= omega t. Returns r . r and r . shadow. */
static Products finish(const System *y, double alpha, const double *restrict z, double omega, const double *restrict zs,
                       const double *restrict t, double *restrict r, const double *restrict shadow)
{
    double *restrict x = y->x, *rr = partial_of(y, 0), *rs = partial_of(y, 1);
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) {
        Eight sum_rr = {0}, sum_rs = {0};
        for (size_t i = chunk * ROWS; i < chunk_whole_end(y, chunk); i += ENTRIES)
#pragma omp simd
            for (size_t k = i; k < i + ENTRIES; k++) {
                x[k] = x[k] + alpha * z[k] + omega * zs[k];
                r[k] -= omega * t[k];
                sum_rr.of[k - i] += r[k] * r[k];
                sum_rs.of[k - i] += r[k] * shadow[k];
            }
        rr[chunk] = eight_sum(&sum_rr);
        rs[chunk] = eight_sum(&sum_rs);
    }
    return (Products){vectors_partial_sum(y, 0), vectors_partial_sum(y, 1)};
}

/* From the residual r on, until the solution is found, or no direction is left that the shadow of the first residual sees. Returns the
 * number of iterations. */
static unsigned iterate(System *y, const SolveGoal *goal, SolveReport *report, double size, Precondition *precondition,
                        unsigned k)
{
    double *r = y->work[0], *shadow = y->work[1], *p = y->work[2], *v = y->work[3], *t = y->work[4], *z = y->work[5],
           *zs = y->work[6];
    vectors_copy(y, shadow, r);
    vectors_clear(y, p);
    vectors_clear(y, v);
    const double square = vectors_dot(y, r, r);
    Products now = {square, square}; /* r is its own shadow */
    double rho = 1, alpha = 1, omega = 1;
    for (; !system_note(y, report, goal, k, sqrt(now.aa) / size); k++) {
        const double before = rho;
        rho = now.ab;
        turn(y, rho / before * (alpha / omega), omega, r, v, p);
        alpha = rho / advance(y, precondition, p, z, v, shadow).ab;
        if (!isfinite(alpha)) return k;
        vectors_add(y, r, -alpha, v);
        const Products of_t = advance(y, precondition, r, zs, t, r);
        omega = of_t.aa > 0 ? of_t.ab / of_t.aa : 0;
        now = finish(y, alpha, z, omega, zs, t, r, shadow);
    }
    return k;
}

/* Begun anew from where it broke down, but not where it breaks down at once. */
void bicgstab_go_on(System *y, const SolveGoal *goal, SolveReport *report, double size, Precondition *precondition)
{
    double *r = y->work[0];
    unsigned begun = 0, k = 0;
    bool broken = false;
    do {
        begun = k;
        k = iterate(y, goal, report, size, precondition, k);
        broken = isfinite(report->residual) && report->residual > goal->tolerance && k < goal->iterations;
    } while ((broken && k > begun) || system_is_left(y, goal, report, r, size));
}

static void solve(System *y, const SolveGoal *goal, SolveReport *report)
{
    const double size = system_begin(y, y->work[0]);
    *report = (SolveReport){.converged = size == 0};
    if (size == 0) vectors_clear(y, y->x);
    else bicgstab_go_on(y, goal, report, size, vectors_jacobi);
}

const SolveMethod solve_bicgstab = {
    .name = "bicgstab",
    .equation = "stabilised biconjugate gradients, preconditioned by the diagonal",
    .solve = solve,
};
