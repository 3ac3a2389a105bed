/* SPDX-License-Identifier: BSD-3-Clause */
/* Stabilised biconjugate gradients (van der Vorst 1992): for matrices that are not symmetric. Their residuals can have a part along
 * the constants that no x changes, so it is taken away. */
#include "sim/solve/vectors.h"
#include <math.h>
#include <string.h>

/* p = r + beta (p - omega v) */
static void turn(const System *y, double beta, double omega, const double *restrict r, const double *restrict v,
                 double *restrict p)
{
#pragma omp parallel for simd schedule(static) num_threads(y->threads)
    for (size_t i = 0; i < y->matrix.n; i++) p[i] = r[i] + beta * (p[i] - omega * v[i]);
}

/* ret = L z, without its mean, where z = M^-1 a. */
static void advance(System *y, Precondition *precondition, const double *a, double *z, double *ret)
{
    precondition(y, a, z);
    matrix_multiply(&y->matrix, z, ret, y->threads);
    remove_mean(y, ret);
}

/* From the residual r on, until the solution is found, or no direction is left that the shadow of the first residual sees. Returns the
 * number of iterations. */
static unsigned iterate(System *y, const SolveGoal *goal, SolveReport *report, double size, Precondition *precondition,
                        unsigned k)
{
    double *r = y->work[0], *shadow = y->work[1], *p = y->work[2], *v = y->work[3], *t = y->work[4], *z = y->work[5],
           *zs = y->work[6];
    const size_t bytes = y->matrix.n * sizeof(double);
    memcpy(shadow, r, bytes);
    memset(p, 0, bytes);
    memset(v, 0, bytes);
    double rho = 1, alpha = 1, omega = 1;
    for (; !note(y, report, goal, k, sqrt(dot(y, r, r)) / size); k++) {
        const double before = rho;
        rho = dot(y, shadow, r);
        turn(y, rho / before * (alpha / omega), omega, r, v, p);
        advance(y, precondition, p, z, v);
        alpha = rho / dot(y, shadow, v);
        if (!isfinite(alpha)) return k;
        add(y, r, -alpha, v);
        advance(y, precondition, r, zs, t);
        const double tt = dot(y, t, t);
        omega = tt > 0 ? dot(y, t, r) / tt : 0;
        add(y, y->x, alpha, z);
        add(y, y->x, omega, zs);
        add(y, r, -omega, t);
    }
    return k;
}

/* Begun anew from where it broke down, but not where it breaks down at once. */
void stabilised_gradients(System *y, const SolveGoal *goal, SolveReport *report, double size,
                          Precondition *precondition)
{
    double *r = y->work[0];
    unsigned begun = 0, k = 0;
    bool broken = false;
    do {
        begun = k;
        k = iterate(y, goal, report, size, precondition, k);
        broken = isfinite(report->residual) && report->residual > goal->tolerance && k < goal->iterations;
    } while ((broken && k > begun) || is_left(y, goal, report, r, size));
}

static void solve(System *y, const SolveGoal *goal, SolveReport *report)
{
    const double size = begin(y, y->work[0]);
    *report = (SolveReport){.converged = size == 0};
    if (size == 0) memset(y->x, 0, y->matrix.n * sizeof *y->x);
    else stabilised_gradients(y, goal, report, size, jacobi);
}

const SolveMethod solve_bicgstab = {
    .name = "bicgstab",
    .equation = "stabilised biconjugate gradients, preconditioned by the diagonal",
    .solve = solve,
};
