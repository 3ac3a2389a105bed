/* SPDX-License-Identifier: BSD-3-Clause */
/* Sweeps over the vectors of a system. What is found of a chunk is found while that is in the cache. */
#include "sim/solve/vectors.h"
#include <string.h>

double vectors_partial_sum(const System *y, int k)
{
    const double *partial = partial_of(y, k);
    double sum = 0;
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) sum += partial[chunk];
    return sum;
}

double vectors_dot(const System *y, const double *a, const double *b)
{
    double *partial = partial_of(y, 0);
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) {
        Eight sum = {0};
        for (size_t i = chunk * ROWS; i < chunk_whole_end(y, chunk); i += ENTRIES)
#pragma omp simd
            for (size_t l = 0; l < ENTRIES; l++) sum.of[l] += a[i + l] * b[i + l];
        partial[chunk] = eight_sum(&sum);
    }
    return vectors_partial_sum(y, 0);
}

void vectors_clear(const System *y, double *a)
{
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++)
        memset(a + chunk * ROWS, 0, (chunk_end(y, chunk) - chunk * ROWS) * sizeof *a);
}

void vectors_copy(const System *y, double *restrict a, const double *restrict b)
{
#pragma omp parallel for simd schedule(static) num_threads(y->threads)
    for (size_t i = 0; i < y->matrix.n; i++) a[i] = b[i];
}

void vectors_add(const System *y, double *restrict a, double f, const double *restrict b)
{
#pragma omp parallel for simd schedule(static) num_threads(y->threads)
    for (size_t i = 0; i < y->matrix.n; i++) a[i] += f * b[i];
}

void vectors_add_to(const System *y, double *restrict a, double f, const double *restrict b)
{
#pragma omp parallel for simd schedule(static) num_threads(y->threads)
    for (size_t i = 0; i < y->matrix.n; i++) a[i] = b[i] + f * a[i];
}

void vectors_jacobi(System *y, const double *r, double *z)
{
    const double *restrict diagonal = y->matrix.diagonal;
#pragma omp parallel for simd schedule(static) num_threads(y->threads)
    for (size_t i = 0; i < y->matrix.n; i++) z[i] = diagonal[i] > 0 ? r[i] / diagonal[i] : 0;
}

/* --- means ---------------------------------------------------------------------------------------------------------------- */

static bool has_one_mean(const System *y)
{
    return y->parts == 1 && y->speaking > 0;
}

/* Over the rows of a chunk that say something. */
static double chunk_sum(const System *y, const double *restrict a, size_t chunk)
{
    const uint32_t *restrict blocks = y->matrix.blocks;
    Eight sum = {0};
    for (size_t i = chunk * ROWS; i < chunk_whole_end(y, chunk); i += ENTRIES)
#pragma omp simd
        for (size_t l = 0; l < ENTRIES; l++) sum.of[l] += blocks[i + l] ? a[i + l] : 0;
    return eight_sum(&sum);
}

static double mean_of(const System *y, int k)
{
    return vectors_partial_sum(y, k) / (double)y->speaking;
}

void vectors_remove_mean(const System *y, double *restrict a)
{
    if (y->parts > 1) parts_level(y, a, PARTS_MEAN);
    if (!has_one_mean(y)) return;
    const uint32_t *restrict blocks = y->matrix.blocks;
    double *sums = partial_of(y, 0);
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) sums[chunk] = chunk_sum(y, a, chunk);
    const double mean = mean_of(y, 0);
#pragma omp parallel for simd schedule(static) num_threads(y->threads)
    for (size_t i = 0; i < y->matrix.n; i++) a[i] -= blocks[i] ? mean : 0;
}

double vectors_multiply(const System *y, const double *x, double *ret)
{
    const bool one = has_one_mean(y);
    double *sums = partial_of(y, 0);
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) {
        matrix_rows(&y->matrix, x, ret, chunk * ROWS, chunk_end(y, chunk));
        if (one) sums[chunk] = chunk_sum(y, ret, chunk);
    }
    if (y->parts > 1) parts_level(y, ret, PARTS_MEAN);
    return one ? mean_of(y, 0) : 0;
}

Products vectors_level(const System *y, double *restrict a, double mean, const double *restrict b)
{
    const uint32_t *restrict blocks = y->matrix.blocks;
    double *aa = partial_of(y, 0), *ab = partial_of(y, 1);
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) {
        Eight sum_aa = {0}, sum_ab = {0};
        for (size_t i = chunk * ROWS; i < chunk_whole_end(y, chunk); i += ENTRIES)
#pragma omp simd
            for (size_t l = 0; l < ENTRIES; l++) {
                const double left = a[i + l] - (blocks[i + l] ? mean : 0);
                a[i + l] = left;
                sum_aa.of[l] += left * left;
                sum_ab.of[l] += left * b[i + l];
            }
        aa[chunk] = eight_sum(&sum_aa);
        ab[chunk] = eight_sum(&sum_ab);
    }
    return (Products){vectors_partial_sum(y, 0), vectors_partial_sum(y, 1)};
}
