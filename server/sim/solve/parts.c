/* SPDX-License-Identifier: BSD-3-Clause */
/* Parts of a matrix that do not refer to each other, as of spaces on both sides of a wall: each has a constant of its own that nothing
 * determines. They are found anew for each solve, which costs about as much as a product, so that a restart need know nothing of them. */
#include "base/forest.h"
#include "sim/solve/vectors.h"
#include <string.h>

/* Does row i count? One that says nothing determines nothing. */
static bool counts(const System *y, size_t i)
{
    return y->matrix.blocks[i] > 0;
}

/* Join row i with those of one of its blocks. */
static void join(const System *y, uint32_t *up, uint32_t i, size_t block)
{
    const Matrix *m = &y->matrix;
    const size_t first = (m->start[i] + block) * ENTRIES;
    for (size_t k = first; k < first + ENTRIES; k++) {
        const uint32_t j = m->column[k];
        if (m->c[k] != 0 && counts(y, j)) forest_join(up, i, j);
    }
}

static bool is_root(const System *y, size_t i)
{
    return y->part[i] == i && counts(y, i);
}

/* How many there are; of each chunk it is left in the partial sums. */
static size_t count_roots(const System *y)
{
    double *roots = partial_of(y, 0);
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) {
        size_t n = 0;
        for (size_t i = chunk * ROWS; i < chunk_end(y, chunk); i++) n += is_root(y, i);
        roots[chunk] = (double)n;
    }
    return (size_t)vectors_partial_sum(y, 0);
}

/* The first PARTS_MAX of those that were counted; returns how many. Chunks without one are passed over. */
static size_t first_roots(const System *y, uint32_t *ret)
{
    const double *roots = partial_of(y, 0);
    size_t n = 0;
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++)
        for (size_t i = chunk * ROWS; roots[chunk] > 0 && n < PARTS_MAX && i < chunk_end(y, chunk); i++)
            if (is_root(y, i)) ret[n++] = (uint32_t)i;
    return n;
}

/* Numbers instead of least rows, which come before the others; those too many share the last, and what says nothing goes with the first.
 * A row's number must not be taken for a row, so all are at their roots before. */
static size_t number(const System *y)
{
    uint32_t *part = y->part, least[PARTS_MAX];
    const size_t n = first_roots(y, least), rows = y->matrix.n;
#pragma omp parallel num_threads(y->threads)
    {
#pragma omp for schedule(static)
        for (size_t i = 0; i < rows; i++) forest_settle(part, (uint32_t)i);
#pragma omp for schedule(static)
        for (size_t i = 0; i < rows; i++) {
            size_t k = 0;
            while (k < n && least[k] != part[i]) k++;
            part[i] = (uint32_t)(k < n ? k : counts(y, i) ? n - 1 : 0);
        }
    }
    return n;
}

/* Block by block: one or two of each row are enough where there is one part only. */
void parts_find(System *y)
{
    const Matrix *m = &y->matrix;
    size_t most = 0;
#pragma omp parallel for schedule(static) reduction(max : most) num_threads(y->threads)
    for (size_t i = 0; i < m->n; i++) {
        y->part[i] = (uint32_t)i;
        most = m->blocks[i] > most ? m->blocks[i] : most;
    }
    size_t separate = count_roots(y);
    for (size_t block = 0; block < most && separate > 1; block++) {
#pragma omp parallel for schedule(static) num_threads(y->threads)
        for (size_t i = 0; i < m->n; i++)
            if (block < m->blocks[i]) join(y, y->part, (uint32_t)i, block);
        separate = count_roots(y);
    }
    y->parts = separate > 1 ? number(y) : 1;
}

/* Of each part a sum, and over how many rows it is spread. */
typedef struct Shares {
    double sum[PARTS_MAX], rows[PARTS_MAX];
} Shares;

_Static_assert(sizeof(Shares) == SHARES * sizeof(double), "room in the partial sums");

static Shares *shares_of(const System *y)
{
    return (Shares *)partial_of(y, SUMS);
}

/* Those of each chunk. Rows that say nothing count in the centre only. */
static void share(const System *y, const double *a, PartsHow how)
{
    const size_t summed = how == PARTS_CENTRE ? y->bulk : y->matrix.n,
                 counted = how == PARTS_MEAN ? y->matrix.n : y->bulk;
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++) {
        Shares *of = &shares_of(y)[chunk];
        memset(of->sum, 0, y->parts * sizeof *of->sum);
        memset(of->rows, 0, y->parts * sizeof *of->rows);
        for (size_t i = chunk * ROWS; i < chunk_end(y, chunk) && i < summed; i++) {
            if (y->matrix.blocks[i] == 0 && how != PARTS_CENTRE) continue;
            of->sum[y->part[i]] += a[i];
            of->rows[y->part[i]] += i < counted;
        }
    }
}

/* What is too much in each row of a part, by the shares of all chunks. */
static void excess(const System *y, double *ret)
{
    double rows[PARTS_MAX] = {0};
    memset(ret, 0, y->parts * sizeof *ret);
    for (size_t chunk = 0; chunk < chunks_of(y); chunk++)
        for (size_t k = 0; k < y->parts; k++) {
            ret[k] += shares_of(y)[chunk].sum[k];
            rows[k] += shares_of(y)[chunk].rows[k];
        }
    for (size_t k = 0; k < y->parts; k++) ret[k] = rows[k] > 0 ? ret[k] / rows[k] : 0;
}

void parts_level(const System *y, double *a, PartsHow how)
{
    double less[PARTS_MAX];
    const size_t n = how == PARTS_BALANCE ? y->bulk : y->matrix.n;
    share(y, a, how);
    excess(y, less);
#pragma omp parallel for schedule(static) num_threads(y->threads)
    for (size_t i = 0; i < n; i++)
        if (y->matrix.blocks[i] || how == PARTS_CENTRE) a[i] -= less[y->part[i]];
}
