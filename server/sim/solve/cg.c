/* SPDX-License-Identifier: BSD-3-Clause */
/* Conjugate gradients, preconditioned by the diagonal. As b has no part along the constants, the residuals have none but for
 * rounding. */
#include "sim/solve/vectors.h"
#include <math.h>
#include <string.h>

/* q = L p; returns p . q. */
static double advance(const System *y, const double *restrict p, double *restrict q)
{
    matrix_multiply(&y->matrix, p, q, y->threads);
    return dot(y, p, q);
}

typedef struct Products {
    double rr, rz;
} Products;

/* x += alpha p;  r -= alpha q;  z = r / diagonal. */
static Products update(System *y, double alpha, const double *restrict p, const double *restrict q, double *restrict r,
                       double *restrict z)
{
    const double *restrict diagonal = y->matrix.diagonal;
    double *restrict x = y->x, *restrict rr = partial_of(y, 1), *restrict rz = partial_of(y, 2);
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) {
        double sum_rr = 0, sum_rz = 0;
        for (size_t i = chunk * ROWS; i < chunk_end(y, chunk); i++) {
            x[i] += alpha * p[i];
            r[i] -= alpha * q[i];
            z[i] = diagonal[i] > 0 ? r[i] / diagonal[i] : 0;
            sum_rr += r[i] * r[i];
            sum_rz += r[i] * z[i];
        }
        rr[chunk] = sum_rr;
        rz[chunk] = sum_rz;
    }
    return (Products){partial_sum(y, 1), partial_sum(y, 2)};
}

static void solve(System *y, const SolveGoal *goal, SolveReport *report)
{
    double *r = y->work[0], *z = y->work[1], *p = y->work[2], *q = y->work[3];
    const double size = begin(y, r);
    *report = (SolveReport){.converged = size == 0};
    if (size == 0) {
        memset(y->x, 0, y->matrix.n * sizeof *y->x);
        return;
    }
    unsigned k = 0;
    do {
        memset(p, 0, y->matrix.n * sizeof *p);
        memset(q, 0, y->matrix.n * sizeof *q);
        Products now = update(y, 0, p, q, r, z);
        double beta = 0;
        for (; !note(y, report, goal, k, sqrt(now.rr) / size); k++) {
            add_to(y, p, beta, z);
            const double pq = advance(y, p, q), before = now.rz;
            now = update(y, now.rz / pq, p, q, r, z);
            beta = now.rz / before;
        }
    } while (is_left(y, goal, report, r, size));
}

const SolveMethod solve_cg = {
    .name = "cg",
    .equation = "conjugate gradients, preconditioned by the diagonal",
    .solve = solve,
};
