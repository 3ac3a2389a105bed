/* SPDX-License-Identifier: BSD-3-Clause */
/* Matrices in rows of differences, and what methods of solution share. */
#include "base/array.h"
#include "sim/solve/vectors.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

bool matrix_init(Matrix *m, size_t n, int threads)
{
    *m = (Matrix){.n = n};
    m->start = array_new_team(n + 1, sizeof *m->start, threads);
    m->blocks = array_new_team(whole_blocks(n), sizeof *m->blocks, threads);
    m->diagonal = array_new_team(whole_blocks(n), sizeof *m->diagonal, threads);
    if (m->start && m->blocks && m->diagonal) return true;
    matrix_done(m);
    return false;
}

void matrix_done(Matrix *m)
{
    free(m->start);
    free(m->blocks);
    free(m->column);
    free(m->c);
    free(m->diagonal);
    *m = (Matrix){0};
}

/* A twentieth more than is asked for, as lists differ a little from one time to the next. */
static bool reserve(Matrix *m, size_t blocks, int threads)
{
    if (blocks <= m->room) return true;
    const size_t room = blocks + blocks / 20;
    uint32_t *column = array_new_team(room, ENTRIES * sizeof *column, threads);
    float *c = array_new_team(room, ENTRIES * sizeof *c, threads);
    if (!column || !c) {
        free(column);
        free(c);
        return false;
    }
    free(m->column);
    free(m->c);
    m->column = column;
    m->c = c;
    m->room = room;
    return true;
}

/* Starts within pieces of the rows, then those of the pieces, of which there are few, then both together. */
bool matrix_lay(Matrix *m, int threads)
{
    enum { PIECE = 8192 };
    const size_t n = m->n;
    size_t *start = m->start;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t first = 0; first < n; first += PIECE) {
        const size_t last = first + PIECE < n ? first + PIECE : n;
        size_t sum = 0;
        for (size_t i = first; i < last; i++) start[i + 1] = sum += m->blocks[i];
    }
    for (size_t end = PIECE; end < n; end += PIECE) start[end + PIECE < n ? end + PIECE : n] += start[end];
    if (!reserve(m, start[n], threads)) return false;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t first = PIECE; first < n; first += PIECE) {
        const size_t last = first + PIECE < n ? first + PIECE : n;
        for (size_t i = first + 1; i < last; i++) start[i] += start[first];
    }
    return true;
}

INLINE double row_product(const Matrix *m, const double *restrict x, size_t i)
{
    const uint32_t *restrict column = m->column + m->start[i] * ENTRIES;
    const float *restrict c = m->c + m->start[i] * ENTRIES;
    const double x_i = x[i];
    Eight sum = {0};
    for (size_t k = 0; k < m->blocks[i] * (size_t)ENTRIES; k += ENTRIES)
#pragma omp simd
        for (size_t l = 0; l < ENTRIES; l++) sum.of[l] += (double)c[k + l] * (x_i - x[column[k + l]]);
    return eight_sum(&sum);
}

/* Rows [first, last), for every level of instructions; nothing is fused, so all give the same bits. */
typedef void (*Multiply)(const Matrix *, const double *x, double *y, size_t first, size_t last);
#define MULTIPLY(level, target)                                                                                        \
    target static void multiply_##level(const Matrix *m, const double *x, double *y, size_t first, size_t last)        \
    {                                                                                                                  \
        for (size_t i = first; i < last; i++) y[i] = row_product(m, x, i);                                             \
    }
MULTIPLY(base, )
#if HAS_LEVELS
MULTIPLY(v3, FOR_V3)
MULTIPLY(v4, FOR_V4)
static const Multiply MULTIPLIES[LEVELS] = {multiply_base, multiply_v3, multiply_v4};
#else
static const Multiply MULTIPLIES[LEVELS] = {multiply_base};
#endif

void matrix_rows(const Matrix *m, const double *x, double *y, size_t first, size_t last)
{
    MULTIPLIES[level_in_use()](m, x, y, first, last);
}

void matrix_multiply(const Matrix *m, const double *x, double *y, int threads)
{
    enum { CHUNK = 256 };
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t k = 0; k < m->n; k += CHUNK) matrix_rows(m, x, y, k, k + CHUNK < m->n ? k + CHUNK : m->n);
}

bool system_init(System *y, size_t n, size_t bulk, int threads)
{
    *y = (System){.bulk = bulk, .zero = NO_ROW, .parts = 1, .threads = threads};
    bool well = matrix_init(&y->matrix, n, threads);
    well = well && (y->b = array_new_team(whole_blocks(n), sizeof(double), threads)) &&
           (y->x = array_new_team(whole_blocks(n), sizeof(double), threads)) &&
           (y->part = array_new_team(n, sizeof *y->part, threads));
    for (int k = 0; well && k < WORK_VECTORS; k++)
        well = (y->work[k] = array_new_team(whole_blocks(n), sizeof(double), threads));
    well = well && (y->partial = array_new((SUMS + SHARES) * chunks_of(y), sizeof(double)));
    if (!well) system_done(y);
    return well;
}

void system_done(System *y)
{
    matrix_done(&y->matrix);
    free(y->b);
    free(y->x);
    free(y->part);
    for (int k = 0; k < WORK_VECTORS; k++) free(y->work[k]);
    free(y->partial);
    for (int k = 0; k < MATRICES; k++) amg_free(y->amg[k]);
    *y = (System){0};
}

size_t system_bytes(const System *y)
{
    const Matrix *m = &y->matrix;
    return m->n * (sizeof *m->start + sizeof *m->blocks + sizeof *y->part + (3 + WORK_VECTORS) * sizeof(double)) +
           m->room * ENTRIES * (sizeof *m->column + sizeof *m->c);
}

void system_relax(System *y, size_t first)
{
    const Matrix *m = &y->matrix;
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t i = first; i < m->n; i++) {
        y->x[i] = 0;
        if (m->blocks[i]) y->x[i] = (y->b[i] - row_product(m, y->x, i)) / m->diagonal[i];
    }
}

static double mean_of_bulk(const System *y)
{
    double *sums = partial_of(y, 0);
    const double *restrict x = y->x;
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) {
        sums[chunk] = 0;
        for (size_t i = chunk * ROWS; i < chunk_end(y, chunk) && i < y->bulk; i++) sums[chunk] += x[i];
    }
    return vectors_partial_sum(y, 0) / (double)y->bulk;
}

void system_clear(System *y)
{
    vectors_clear(y, y->x);
}

void system_centre(System *y)
{
    double *restrict x = y->x;
    const bool counted = y->zero != NO_ROW;
    if (y->parts > 1) parts_level(y, x, PARTS_CENTRE);
    if (y->parts > 1 && !counted) return;
    const double from = counted ? x[y->zero] : mean_of_bulk(y);
    const uint32_t part = counted && y->parts > 1 ? y->part[y->zero] : 0;
#pragma omp parallel for simd schedule(static) num_threads(y->threads)
    for (size_t i = 0; i < y->matrix.n; i++) x[i] -= y->parts == 1 || y->part[i] == part ? from : 0;
}

bool solve_takes_amg(MnsSolver solver, double rows, double blocks, bool symmetric)
{
    /* Rows from which on it is faster (DECISIONS.md). */
    const double in_space = symmetric ? 1e7 : 3e6, large = rows_in_space(blocks) ? in_space : 5e4;
    return solver == MNS_SOLVER_AMG ||
           (solver == MNS_SOLVER_BY_SIZE && rows >= large && amg_holds(rows, blocks * ENTRIES));
}

const SolveMethod *solve_method(MnsSolver solver, const System *y, bool symmetric)
{
    const size_t n = y->matrix.n;
    if (solve_takes_amg(solver, (double)n, (double)y->matrix.start[n] / (double)n, symmetric))
        return symmetric ? &solve_amg : &solve_amg_bicgstab;
    return symmetric && solver != MNS_SOLVER_BICGSTAB ? &solve_cg : &solve_bicgstab;
}

void system_forget(System *y)
{
    for (int k = 0; k < MATRICES; k++) amg_forget(y->amg[k]);
}

void system_keep(System *y, int matrix)
{
    y->kept = matrix;
}

bool system_is_ready(const System *y)
{
    return amg_is_ready(y->amg[y->kept]);
}

/* r = b - L x */
static void subtract_product(const System *y, double *restrict r)
{
    const double *restrict b = y->b;
    matrix_multiply(&y->matrix, y->x, r, y->threads);
#pragma omp parallel for simd schedule(static) num_threads(y->threads)
    for (size_t i = 0; i < y->matrix.n; i++) r[i] = b[i] - r[i];
}

bool system_is_left(System *y, const SolveGoal *goal, SolveReport *report, double *r, double size)
{
    const double rounded = 1e-8; /* with larger tolerances than this the check would cost more than it finds */
    if (!report->converged || report->iterations == 0 || goal->tolerance >= rounded) return false;
    subtract_product(y, r);
    vectors_remove_mean(y, r);
    report->residual = sqrt(vectors_dot(y, r, r)) / size;
    report->converged = report->residual <= goal->tolerance;
    return !report->converged;
}

/* Take away from b the mean over the bulk. */
static void balance(const System *y)
{
    const uint32_t *restrict blocks = y->matrix.blocks;
    double *sums = partial_of(y, 0), *counts = partial_of(y, 1), *restrict b = y->b;
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) {
        sums[chunk] = counts[chunk] = 0;
        for (size_t i = chunk * ROWS; i < chunk_end(y, chunk) && i < y->bulk; i++) {
            sums[chunk] += b[i]; /* 0 of a row that says nothing */
            counts[chunk] += blocks[i] > 0;
        }
    }
    const double count = vectors_partial_sum(y, 1), mean = count > 0 ? vectors_partial_sum(y, 0) / count : 0;
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t i = 0; i < y->bulk; i++)
        if (blocks[i]) b[i] -= mean;
}

double system_begin(System *y, double *r)
{
    const size_t n = y->matrix.n;
    double *restrict b = y->b;
    size_t speaking = 0;
#pragma omp parallel for schedule(static) reduction(+ : speaking) num_threads(y->threads)
    for (size_t i = 0; i < n; i++) {
        if (y->matrix.blocks[i] == 0) b[i] = 0;
        else speaking++;
    }
    y->speaking = speaking;
    parts_find(y);
    if (y->parts > 1) parts_level(y, b, PARTS_BALANCE);
    else balance(y);
    subtract_product(y, r);
    vectors_remove_mean(y, r);
    const double size = sqrt(vectors_dot(y, b, b));
    return size < y->least ? y->least : size;
}

static bool is_noted(unsigned iteration)
{
    return (iteration & (iteration - 1)) == 0; /* 0, 1, 2, 4 ... */
}

bool system_note(const System *y, SolveReport *report, const SolveGoal *goal, unsigned iteration, double residual)
{
    watcher_tell(&y->watcher);
    const bool last = !(residual > goal->tolerance) || iteration >= goal->iterations;
    report->iterations = iteration;
    report->residual = residual;
    report->converged = residual <= goal->tolerance;
    if ((last || is_noted(iteration)) && report->n < HISTORY_MAX) {
        report->at[report->n] = iteration;
        report->of[report->n++] = residual;
    }
    return last;
}

void solve_history(const SolveReport *report, char *text, size_t size)
{
    size_t used = 0;
    if (size) *text = 0;
    for (int k = 0; k < report->n && used < size; k++) {
        const int n =
            snprintf(text + used, size - used, "%s%.2g after %u", k ? ", " : "", report->of[k], report->at[k]);
        used += n > 0 ? (size_t)n : 0;
    }
}
