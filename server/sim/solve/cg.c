/* SPDX-License-Identifier: BSD-3-Clause */
/* Conjugate gradients, preconditioned by the diagonal. As b has no part along the constants, the residuals have none but for
 * rounding. */
#include "sim/solve/vectors.h"
#include <math.h>

/* q = L p; returns p . q. */
static double advance(const System *y, const double *restrict p, double *restrict q)
{
    matrix_multiply(&y->matrix, p, q, y->threads);
    return vectors_dot(y, p, q);
}

/* x += alpha p;  r -= alpha q;  z = r / diagonal. Returns r . r and r . z. */
static Products update(System *y, double alpha, const double *restrict p, const double *restrict q, double *restrict r,
                       double *restrict z)
{
    const double *restrict diagonal = y->matrix.diagonal;
    double *restrict x = y->x, *rr = partial_of(y, 1), *rz = partial_of(y, 2);
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) {
        Eight sum_rr = {0}, sum_rz = {0};
        for (size_t i = chunk * ROWS; i < chunk_whole_end(y, chunk); i += ENTRIES)
#pragma omp simd
            for (size_t k = i; k < i + ENTRIES; k++) {
                x[k] += alpha * p[k];
                r[k] -= alpha * q[k];
                z[k] = diagonal[k] > 0 ? r[k] / diagonal[k] : 0;
                sum_rr.of[k - i] += r[k] * r[k];
                sum_rz.of[k - i] += r[k] * z[k];
            }
        rr[chunk] = eight_sum(&sum_rr);
        rz[chunk] = eight_sum(&sum_rz);
    }
    return (Products){vectors_partial_sum(y, 1), vectors_partial_sum(y, 2)};
}

static void solve(System *y, const SolveGoal *goal, SolveReport *report)
{
    double *r = y->work[0], *z = y->work[1], *p = y->work[2], *q = y->work[3];
    const double size = system_begin(y, r);
    *report = (SolveReport){.converged = size == 0};
    if (size == 0) {
        vectors_clear(y, y->x);
        return;
    }
    unsigned k = 0;
    do {
        vectors_clear(y, p);
        vectors_clear(y, q);
        Products now = update(y, 0, p, q, r, z);
        double beta = 0;
        for (; !system_note(y, report, goal, k, sqrt(now.aa) / size); k++) {
            vectors_add_to(y, p, beta, z);
            const double pq = advance(y, p, q), before = now.ab;
            now = update(y, now.ab / pq, p, q, r, z);
            beta = now.ab / before;
        }
    } while (system_is_left(y, goal, report, r, size));
}

const SolveMethod solve_cg = {
    .name = "cg",
    .equation = "conjugate gradients, preconditioned by the diagonal",
    .solve = solve,
};
