/* SPDX-License-Identifier: BSD-3-Clause */
/* Methods for linear systems give what elimination gives, need nothing where the guess is the solution, say so where they fail, and
 * give the same bits with any number of threads. */
#include "sim/solve/solve.h"
#include "tests/support/check.h"
#include "tests/support/draw.h"
#include <stdlib.h>
#include <string.h>

enum { MANY = 5000, FEW = 60 };

/* A ring in which each row refers to the three on either side, with weights of its own; one row says nothing. Weights of a pair are the
 * same unless they are skewed. */
static void ring(System *y, size_t n, double skew, int threads)
{
    static const int REACH[] = {-3, -2, -1, 1, 2, 3};
    assert_true(system_init(y, n + 1, n, threads));
    Matrix *m = &y->matrix;
    for (size_t i = 0; i <= n; i++) m->blocks[i] = 2;
    assert_true(matrix_lay(m, 2));
    m->blocks[n] = 0;
    for (size_t i = 0; i < n; i++) {
        m->blocks[i] = 1;
        for (size_t k = 0; k < ENTRIES; k++) {
            const size_t at = m->start[i] * ENTRIES + k;
            const size_t j = k < 6 ? (i + n + (size_t)(REACH[k] + (int)n)) % n : i;
            const uint64_t pair = (i < j ? i : j) * 7919 + (i < j ? j : i) * 104729;
            double c = 1 + 0.5 * sin((double)(pair % 1000)) + skew * sin((double)(3 * i + k));
            if (k >= 6) c = 0;
            m->column[at] = (uint32_t)j;
            m->c[at] = (float)c;
            m->diagonal[i] += (double)m->c[at];
        }
    }
}

/* By elimination with pivots, x of the last row being 0. */
static void eliminate(const System *y, const double *b, double *ret)
{
    const size_t n = y->bulk, w = n + 1;
    double *a = calloc(n * w, sizeof *a);
    assert_non_null(a);
    const Matrix *m = &y->matrix;
    for (size_t i = 0; i < n; i++) {
        for (size_t k = m->start[i] * ENTRIES; k < (m->start[i] + m->blocks[i]) * ENTRIES; k++) {
            a[i * w + i] += (double)m->c[k];
            a[i * w + m->column[k]] -= (double)m->c[k];
        }
        a[i * w + n] = b[i];
    }
    for (size_t k = 0; k < n - 1; k++) {
        size_t best = k;
        for (size_t q = k; q < n; q++)
            if (fabs(a[q * w + k]) > fabs(a[best * w + k])) best = q;
        for (size_t c = 0; c <= n; c++) {
            const double kept = a[k * w + c];
            a[k * w + c] = a[best * w + c];
            a[best * w + c] = kept;
        }
        for (size_t q = 0; q < n; q++) {
            const double factor = q == k ? 0 : a[q * w + k] / a[k * w + k];
            for (size_t c = k; c <= n && factor != 0; c++) a[q * w + c] -= factor * a[k * w + c];
        }
    }
    ret[n - 1] = 0;
    for (size_t k = 0; k < n - 1; k++) ret[k] = a[k * w + n] / a[k * w + k];
    free(a);
}

/* What L makes of a random x, so that there is a solution for every matrix. */
static void ask(System *y, uint64_t seed)
{
    for (size_t i = 0; i < y->matrix.n; i++) y->x[i] = draw_signed(&seed);
    matrix_multiply(&y->matrix, y->x, y->b, y->threads);
    memset(y->x, 0, y->matrix.n * sizeof *y->x);
}

static void constants_are_nothing_to_a_matrix(void **state)
{
    (void)state;
    System y;
    ring(&y, MANY, 0.3, 1);
    for (size_t i = 0; i < y.matrix.n; i++) y.x[i] = 1.0 / 3;
    matrix_multiply(&y.matrix, y.x, y.b, 1);
    for (size_t i = 0; i < y.matrix.n; i++) assert_true(y.b[i] == 0);
    system_done(&y);
}

static void methods_give_what_elimination_gives(void **state)
{
    (void)state;
    const SolveMethod *const methods[] = {&solve_cg, &solve_bicgstab, &solve_bicgstab};
    for (int k = 0; k < 3; k++) {
        System y;
        SolveReport report;
        double exact[FEW];
        ring(&y, FEW, k == 2 ? 0.3 : 0, 1);
        ask(&y, 5);
        eliminate(&y, y.b, exact);
        methods[k]->solve(&y, &(SolveGoal){1e-12, 500}, &report);
        assert_true(report.converged && report.iterations > 3 && report.iterations < 120 && report.residual <= 1e-12);
        for (size_t i = 0; i < FEW; i++) assert_close(y.x[i] - y.x[FEW - 1], exact[i], 1e-9);
        assert_true(y.x[FEW] == 0); /* the row that says nothing */
        system_done(&y);
    }
}

/* What was made for another matrix, and for one that takes turns with it. */
static void what_is_kept_still_serves_a_matrix_nearby(void **state)
{
    (void)state;
    if (!amg_exists()) skip();
    System y, z;
    SolveReport kept, fresh;
    ring(&y, MANY, 0, 1);
    ring(&z, MANY, 0, 1);
    solve_amg.prepare(&y);
    assert_true(system_is_ready(&y));
    system_keep(&y, 1);
    assert_false(system_is_ready(&y));
    system_keep(&y, 0);
    for (size_t i = 0; i < MANY; i++) {
        y.matrix.diagonal[i] = z.matrix.diagonal[i] = 0;
        for (size_t k = y.matrix.start[i] * ENTRIES; k < y.matrix.start[i] * ENTRIES + ENTRIES; k++) {
            y.matrix.c[k] = z.matrix.c[k] *= 1.25F + 0.25F * (float)((i + y.matrix.column[k]) % 2);
            y.matrix.diagonal[i] = z.matrix.diagonal[i] += (double)z.matrix.c[k];
        }
    }
    ask(&y, 5);
    ask(&z, 5);
    solve_amg.solve(&y, &(SolveGoal){1e-8, 100}, &kept);
    solve_amg.solve(&z, &(SolveGoal){1e-8, 100}, &fresh);
    assert_true(kept.converged && fresh.converged && y.setup_seconds > 0);
    assert_true(kept.iterations >= fresh.iterations && kept.iterations < 2 * fresh.iterations);
    system_forget(&y);
    assert_false(system_is_ready(&y));
    system_done(&y);
    system_done(&z);
}

/* Where it was built. */
static void multigrid_gives_the_same_in_few_iterations_at_any_size(void **state)
{
    (void)state;
    static const size_t SIZES[] = {FEW, 500, MANY};
    if (!amg_exists()) skip();
    for (int k = 0; k < 3; k++) {
        System y, z;
        SolveReport report, plain;
        ring(&y, SIZES[k], 0, 1);
        ring(&z, SIZES[k], 0, 1);
        for (int again = 0; again < 3; again++) { /* with what was kept, without, and by what needs no symmetry */
            ask(&y, 5);
            ask(&z, 5);
            (again < 2 ? &solve_amg : &solve_amg_bicgstab)->solve(&y, &(SolveGoal){1e-10, 100}, &report);
            solve_cg.solve(&z, &(SolveGoal){1e-10, 20000}, &plain);
            assert_true(report.converged && plain.converged);
            if (report.iterations > 25) fail_msg("%u iterations for %zu rows", report.iterations, SIZES[k]);
            for (size_t i = 0; i < SIZES[k]; i++) assert_close(y.x[i] - y.x[0], z.x[i] - z.x[0], 1e-3);
            assert_true(y.x[SIZES[k]] == 0);
            system_forget(&y);
        }
        system_done(&y);
        system_done(&z);
    }
}

/* More than a particle can have neighbours: that is told, and nothing of it is kept. */
static void what_multigrid_cannot_be_made_of_is_a_status(void **state)
{
    (void)state;
    if (!amg_exists()) skip();
    System y;
    SolveReport report;
    const size_t n = 1200;
    assert_true(system_init(&y, n, n, 1));
    for (size_t i = 0; i < n; i++) y.matrix.blocks[i] = (uint32_t)(n / ENTRIES);
    assert_true(matrix_lay(&y.matrix, 1));
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < n; k++) {
            y.matrix.column[y.matrix.start[i] * ENTRIES + k] = (uint32_t)k;
            y.matrix.c[y.matrix.start[i] * ENTRIES + k] = k == i ? 0 : 1;
            y.matrix.diagonal[i] += k != i;
        }
    ask(&y, 5);
    assert_int_equal(solve_amg.prepare(&y), MNS_E_INTERNAL);
    assert_false(system_is_ready(&y));
    solve_amg.solve(&y, &(SolveGoal){1e-8, 100}, &report);
    assert_int_equal(report.status, MNS_E_INTERNAL);
    assert_false(report.converged);
    solve_cg.solve(&y, &(SolveGoal){1e-8, 100}, &report);
    assert_true(report.converged && report.status == MNS_OK);
    system_done(&y);
}

/* By hand, by size in rows of two and of three dimensions, and by what the matrix is. */
static void methods_are_chosen_by_size_and_symmetry(void **state)
{
    (void)state;
    static const struct {
        size_t n, blocks;
        MnsSolver solver;
        const SolveMethod *symmetric, *skew;
    } cases[] = {
        {49999, 5, MNS_SOLVER_BY_SIZE, &solve_cg, &solve_bicgstab},
        {50000, 8, MNS_SOLVER_BY_SIZE, &solve_amg, &solve_amg_bicgstab},
        {50000, 9, MNS_SOLVER_BY_SIZE, &solve_cg, &solve_bicgstab},
        {2999999, 15, MNS_SOLVER_BY_SIZE, &solve_cg, &solve_bicgstab},
        {3000000, 15, MNS_SOLVER_BY_SIZE, &solve_cg, &solve_amg_bicgstab},
        {9999999, 15, MNS_SOLVER_BY_SIZE, &solve_cg, &solve_amg_bicgstab},
        {10000000, 15, MNS_SOLVER_BY_SIZE, &solve_amg, &solve_amg_bicgstab},
        {5000000, 15, MNS_SOLVER_CG, &solve_cg, &solve_bicgstab},
        {5000000, 15, MNS_SOLVER_BICGSTAB, &solve_bicgstab, &solve_bicgstab},
        {10, 5, MNS_SOLVER_AMG, &solve_amg, &solve_amg_bicgstab},
        {17700000, 15, MNS_SOLVER_BY_SIZE, &solve_amg, &solve_amg_bicgstab},
        {17800000, 15, MNS_SOLVER_BY_SIZE, &solve_cg, &solve_bicgstab}, /* hypre counts entries by int */
    };
    if (!amg_exists()) skip();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        size_t *start = calloc(cases[k].n + 1, sizeof *start);
        assert_non_null(start);
        start[cases[k].n] = cases[k].n * cases[k].blocks;
        const System y = {.matrix = {.n = cases[k].n, .start = start}};
        assert_ptr_equal(solve_method(cases[k].solver, &y, true), cases[k].symmetric);
        assert_ptr_equal(solve_method(cases[k].solver, &y, false), cases[k].skew);
        free(start);
    }
}

static void what_cannot_be_solved_is_taken_from_the_bulk(void **state)
{
    (void)state;
    System y;
    SolveReport report;
    ring(&y, FEW, 0, 1);
    ask(&y, 3);
    double wanted[FEW];
    memcpy(wanted, y.b, sizeof wanted);
    for (size_t i = 0; i < FEW; i++) y.b[i] += 0.25;
    solve_cg.solve(&y, &(SolveGoal){1e-10, 500}, &report);
    assert_true(report.converged);
    for (size_t i = 0; i < FEW; i++) assert_close(y.b[i], wanted[i], 1e-12);
    system_done(&y);
}

/* Every other row of one ring, or none of it, refers to rows of another. */
static void split(System *y, size_t n, int threads)
{
    Matrix *m = &y->matrix;
    ring(y, n, 0, threads);
    for (size_t i = 0; i < n; i++) {
        m->diagonal[i] = 0;
        for (size_t k = m->start[i] * ENTRIES; k < (m->start[i] + 1) * ENTRIES; k++) {
            if ((m->column[k] + i) % 2) m->c[k] = 0; /* even rows and odd ones are apart */
            m->diagonal[i] += (double)m->c[k];
        }
    }
}

/* What has no solution is taken from each of them, and each is centred by itself, or counted from a row of its own. */
static void parts_are_solved_as_if_they_were_alone(void **state)
{
    (void)state;
    const SolveMethod *const methods[] = {&solve_cg, &solve_bicgstab, &solve_amg, &solve_amg_bicgstab};
    for (int k = 0; k < (amg_exists() ? 4 : 2); k++)
        for (int counted = 0; counted < 2; counted++) {
            System y;
            SolveReport report;
            double wanted[500], mean[2] = {0};
            split(&y, 500, 1);
            ask(&y, 5);
            memcpy(wanted, y.b, sizeof wanted);
            for (size_t i = 0; i < 500; i++) y.b[i] += i % 2 ? 0.25 : -0.125;
            if (counted) y.zero = 100;
            methods[k]->solve(&y, &(SolveGoal){1e-10, 5000}, &report);
            if (!report.converged) fail_msg("%s: %g after %u", methods[k]->name, report.residual, report.iterations);
            assert_int_equal(y.parts, 2);
            for (size_t i = 0; i < 500; i++) {
                assert_close(y.b[i], wanted[i], 1e-12);
                assert_true(y.part[i] == (i % 2 != y.part[0]));
            }
            system_centre(&y);
            for (size_t i = 0; i < 500; i++) mean[i % 2] += y.x[i] / 250;
            assert_close(mean[1], 0, 1e-12);
            if (counted) assert_true(fabs(mean[0]) > 1e-6 && fabs(y.x[100]) <= 0);
            else assert_close(mean[0], 0, 1e-12);
            system_done(&y);
        }
}

/* A row of the bulk says nothing, and nobody refers to it. */
static void silence(System *y, size_t row)
{
    Matrix *m = &y->matrix;
    m->blocks[row] = 0;
    m->diagonal[row] = 0;
    for (size_t i = 0; i < m->n; i++)
        for (size_t k = m->start[i] * ENTRIES; k < (m->start[i] + m->blocks[i]) * ENTRIES; k++) {
            if (m->column[k] != row) continue;
            m->diagonal[i] -= (double)m->c[k];
            m->c[k] = 0;
        }
}

/* They go with the first part, and count in its mean, as where there is no other; wherever among the rows of others they are. */
static void rows_that_say_nothing_are_centred_too(void **state)
{
    (void)state;
    for (int parts = 1; parts <= 2; parts++) {
        System y;
        SolveReport report;
        double mean[2] = {0};
        if (parts > 1) split(&y, 500, 1);
        else ring(&y, 500, 0, 1);
        silence(&y, 11);
        ask(&y, 5);
        y.x[11] = 3;
        y.x[500] = 4;
        solve_cg.solve(&y, &(SolveGoal){1e-10, 5000}, &report);
        assert_true(report.converged && y.parts == (size_t)parts);
        const double before = y.x[0];
        system_centre(&y);
        const double change = y.x[0] - before;
        for (size_t i = 0; i < 500; i++) mean[parts > 1 && i != 11 && i % 2] += y.x[i];
        assert_true(fabs(change) > 1e-3);
        assert_close(mean[0], 0, 1e-10);
        assert_close(mean[1], 0, 1e-10);
        assert_close(y.x[11], 3 + change, 1e-12);
        assert_close(y.x[500], 4 + change, 1e-12);
        system_done(&y);
    }
}

/* Some that say nothing and nobody refers to; rings of six are too many to be told apart. */
static void parts_are_counted(void **state)
{
    (void)state;
    enum { RINGS = 100, EACH = 7 };
    System y;
    SolveReport report;
    ring(&y, MANY, 0, 1);
    solve_cg.solve(&y, &(SolveGoal){1, 1}, &report);
    assert_int_equal(y.parts, 1);
    system_done(&y);
    ring(&y, RINGS * EACH, 0, 3);
    for (size_t i = 0; i < RINGS * EACH; i++)
        for (size_t k = 0; k < ENTRIES; k++) {
            const size_t at = y.matrix.start[i] * ENTRIES + k;
            if (y.matrix.column[at] / EACH != i / EACH) y.matrix.c[at] = 0;
        }
    solve_cg.solve(&y, &(SolveGoal){1, 1}, &report);
    assert_int_equal(y.parts, PARTS_MAX);
    for (size_t i = 0; i < RINGS * EACH; i++)
        assert_int_equal(y.part[i], i / EACH < PARTS_MAX ? i / EACH : PARTS_MAX - 1);
    system_done(&y);
}

/* Each row refers to the next only: with a right hand side of two opposite ones the second residual has nothing of the first. */
static void a_breakdown_is_begun_anew(void **state)
{
    (void)state;
    enum { N = 8 };
    System y;
    SolveReport report;
    assert_true(system_init(&y, N, N, 1));
    for (size_t i = 0; i < N; i++) y.matrix.blocks[i] = 1;
    assert_true(matrix_lay(&y.matrix, 1));
    for (size_t i = 0; i < N; i++) {
        for (size_t k = 0; k < ENTRIES; k++) y.matrix.column[i * ENTRIES + k] = (uint32_t)((i + 1) % N);
        y.matrix.c[i * ENTRIES] = 1;
        y.matrix.diagonal[i] = 1;
        y.b[i] = i == 0 ? 1 : i == N / 2 ? -1 : 0;
    }
    solve_bicgstab.solve(&y, &(SolveGoal){1e-6, 100}, &report);
    if (!report.converged) fail_msg("%g after %u", report.residual, report.iterations);
    for (size_t i = 0; i < N; i++) assert_close(y.x[i] - y.x[(i + 1) % N], i == 0 ? 1 : i == N / 2 ? -1 : 0, 1e-5);
    system_done(&y);
}

/* From a guess that is far off, by what rounding leaves of it: b - L x is more than the methods' own sums of it say. */
static void what_is_left_is_looked_at_where_little_is_allowed(void **state)
{
    (void)state;
    const SolveMethod *const methods[] = {&solve_cg, &solve_bicgstab, &solve_amg};
    static const double far = 1e5;
    for (int k = 0; k < (amg_exists() ? 3 : 2); k++) {
        System y;
        SolveReport report;
        ring(&y, FEW, 0, 1);
        ask(&y, 6);
        for (size_t i = 0; i < FEW; i++) y.x[i] = far * sin(3.0 * (double)i);
        methods[k]->solve(&y, &(SolveGoal){5e-12, 3000}, &report);
        assert_true(report.converged);
        matrix_multiply(&y.matrix, y.x, y.work[0], 1);
        double left = 0, size = 0;
        for (size_t i = 0; i < FEW; i++) {
            left += (y.b[i] - y.work[0][i]) * (y.b[i] - y.work[0][i]);
            size += y.b[i] * y.b[i];
        }
        assert_less(sqrt(left / size), 5.05e-12);
        system_done(&y);
    }
}

static void a_guess_that_is_right_needs_no_iteration(void **state)
{
    (void)state;
    const SolveMethod *const methods[] = {&solve_cg, &solve_bicgstab};
    for (int k = 0; k < 2; k++) {
        System y;
        SolveReport cold, near, warm;
        ring(&y, 500, 0, 1);
        ask(&y, 8);
        methods[k]->solve(&y, &(SolveGoal){1e-10, 5000}, &cold);
        methods[k]->solve(&y, &(SolveGoal){1e-9, 5000}, &warm);
        for (size_t i = 0; i < y.matrix.n; i++) y.x[i] += 1e-3 * sin((double)i);
        methods[k]->solve(&y, &(SolveGoal){1e-6, 5000}, &near);
        assert_true(cold.converged && warm.converged && near.converged);
        assert_int_equal(warm.iterations, 0);
        assert_true(near.iterations > 0 && 2 * near.iterations < cold.iterations);
        memset(y.b, 0, y.matrix.n * sizeof *y.b);
        methods[k]->solve(&y, &(SolveGoal){1e-6, 10}, &near);
        assert_true(near.converged && y.x[7] == 0);
        system_done(&y);
    }
}

static void a_solve_that_fails_says_how(void **state)
{
    (void)state;
    const SolveMethod *const methods[] = {&solve_cg, &solve_bicgstab};
    for (int k = 0; k < 2; k++) {
        System y;
        SolveReport report;
        char text[256];
        ring(&y, MANY, 0, 1);
        ask(&y, 2);
        methods[k]->solve(&y, &(SolveGoal){1e-10, 5}, &report);
        assert_false(report.converged);
        assert_int_equal(report.iterations, 5);
        assert_true(report.residual > 1e-10 && report.n == 5 && report.of[0] == 1);
        solve_history(&report, text, sizeof text);
        assert_true(strncmp(text, "1 after 0, ", 11) == 0 && strstr(text, " after 5"));
        y.b[3] = NAN;
        methods[k]->solve(&y, &(SolveGoal){1e-10, 5}, &report);
        assert_false(report.converged);
        system_done(&y);
    }
}

static void threads_change_no_bit(void **state)
{
    (void)state;
    const SolveMethod *const methods[] = {&solve_cg, &solve_bicgstab};
    for (int k = 0; k < 4; k++) {
        double *x = NULL;
        for (int threads = 1; threads <= 3; threads++) {
            System y;
            SolveReport report;
            if (k / 2) split(&y, MANY, threads);
            else ring(&y, MANY, 0, threads);
            ask(&y, 4);
            for (size_t i = 0; i < MANY; i++) y.b[i] += i % 2 ? 0.25 : -0.125;
            methods[k % 2]->solve(&y, &(SolveGoal){1e-5, 20000}, &report);
            assert_true(report.converged && y.parts == (k / 2 ? 2U : 1U));
            system_centre(&y);
            if (!x) {
                x = malloc(MANY * sizeof *x);
                assert_non_null(x);
                memcpy(x, y.x, MANY * sizeof *x);
            }
            assert_memory_equal(x, y.x, MANY * sizeof *x);
            system_done(&y);
        }
        free(x);
    }
}

/* Rows of many pieces, of none, one or two blocks each. */
static void rows_lie_one_after_the_other(void **state)
{
    (void)state;
    for (size_t n = 1; n < 100000; n = 3 * n + 1) {
        Matrix m;
        assert_true(matrix_init(&m, n, 1));
        for (size_t i = 0; i < n; i++) m.blocks[i] = (uint32_t)(i % 7 % 3);
        for (int threads = 1; threads <= 3; threads++) {
            size_t next = 0;
            assert_true(matrix_lay(&m, threads));
            for (size_t i = 0; i < n; i++) {
                assert_int_equal(m.start[i], next);
                next += m.blocks[i];
            }
            assert_int_equal(m.start[n], next);
        }
        matrix_done(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_lie_one_after_the_other),
        cmocka_unit_test(constants_are_nothing_to_a_matrix),
        cmocka_unit_test(methods_give_what_elimination_gives),
        cmocka_unit_test(multigrid_gives_the_same_in_few_iterations_at_any_size),
        cmocka_unit_test(what_is_kept_still_serves_a_matrix_nearby),
        cmocka_unit_test(what_multigrid_cannot_be_made_of_is_a_status),
        cmocka_unit_test(methods_are_chosen_by_size_and_symmetry),
        cmocka_unit_test(what_cannot_be_solved_is_taken_from_the_bulk),
        cmocka_unit_test(parts_are_solved_as_if_they_were_alone),
        cmocka_unit_test(rows_that_say_nothing_are_centred_too),
        cmocka_unit_test(parts_are_counted),
        cmocka_unit_test(a_breakdown_is_begun_anew),
        cmocka_unit_test(what_is_left_is_looked_at_where_little_is_allowed),
        cmocka_unit_test(a_guess_that_is_right_needs_no_iteration),
        cmocka_unit_test(a_solve_that_fails_says_how),
        cmocka_unit_test(threads_change_no_bit),
    };
    return cmocka_run_group_tests_name("solve", tests, NULL, NULL);
}
