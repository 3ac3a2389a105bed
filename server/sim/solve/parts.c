/* SPDX-License-Identifier: BSD-3-Clause */
/* Parts of a matrix that do not refer to each other, as of spaces on both sides of a wall: each has a constant of its own that nothing
 * determines. They are found anew for each solve, which costs about as much as a product, so that a restart need know nothing of them. The
 * sums of several, which are rare, are one thread's. */
#include "sim/solve/vectors.h"

/* Trees of rows, which all threads join at a time: who points elsewhere never points at itself again, and nobody points at a larger one.
 * So whatever their order, in the end the root of each is the least row of its part. */
static uint32_t parent(const uint32_t *up, uint32_t i)
{
    return __atomic_load_n(&up[i], __ATOMIC_RELAXED);
}

/* Rows on the way are made to point there more directly. */
static uint32_t root(uint32_t *up, uint32_t i)
{
    for (uint32_t above = parent(up, i); above != i; above = parent(up, i)) {
        const uint32_t next = parent(up, above);
        if (next != above) __atomic_store_n(&up[i], next, __ATOMIC_RELAXED);
        i = next;
    }
    return i;
}

static void unite(uint32_t *up, uint32_t i, uint32_t j)
{
    for (;;) {
        i = root(up, i);
        j = root(up, j);
        if (i == j) return;
        uint32_t high = i > j ? i : j;
        const uint32_t low = i > j ? j : i;
        if (__atomic_compare_exchange_n(&up[high], &high, low, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) return;
    }
}

/* Does row i count? One that says nothing determines nothing, unless it is held. */
static bool counts(const System *y, size_t i)
{
    return y->matrix.blocks[i] > 0 || i == y->held;
}

/* Join row i with those of one of its blocks. */
static void join(const System *y, uint32_t *up, uint32_t i, size_t block)
{
    const Matrix *m = &y->matrix;
    const size_t first = (m->start[i] + block) * ENTRIES;
    for (size_t k = first; k < first + ENTRIES; k++) {
        const uint32_t j = m->column[k];
        if (m->c[k] != 0 && counts(y, j)) unite(up, i, j);
    }
}

/* Numbers instead of least rows, which come before the others; those too many share the last, and what says nothing goes with the first. */
static size_t number(const System *y)
{
    uint32_t *part = y->part, least[PARTS_MAX];
    size_t n = 0;
    for (uint32_t i = 0; i < y->matrix.n; i++) part[i] = root(part, i);
    for (uint32_t i = 0; i < y->matrix.n; i++) {
        size_t k = 0;
        while (k < n && least[k] != part[i]) k++;
        if (k == n && n < PARTS_MAX && counts(y, i)) least[n++] = part[i];
        part[i] = (uint32_t)(k < n ? k : n && counts(y, i) ? n - 1 : 0);
    }
    return n;
}

static size_t count_roots(const System *y)
{
    size_t n = 0;
#pragma omp parallel for schedule(static) reduction(+ : n) num_threads(y->threads)
    for (size_t i = 0; i < y->matrix.n; i++) n += counts(y, i) && y->part[i] == i;
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

/* Of each part the sum of a over its rows, and over how many of them it is spread. Rows that say nothing count in the centre only. */
void parts_level(const System *y, double *a, PartsHow how)
{
    double sum[PARTS_MAX] = {0}, count[PARTS_MAX] = {0};
    const Matrix *m = &y->matrix;
    const bool all = how == PARTS_CENTRE;
    const size_t summed = all ? y->bulk : m->n, counted = how == PARTS_MEAN ? m->n : y->bulk;
    for (size_t i = 0; i < summed; i++) {
        if (m->blocks[i] == 0 && !all) continue;
        sum[y->part[i]] += a[i];
        count[y->part[i]] += i < counted;
    }
    for (size_t k = 0; k < y->parts; k++) sum[k] = count[k] > 0 ? sum[k] / count[k] : 0;
    if (y->held != NOT_HELD) sum[y->part[y->held]] = 0;
    for (size_t i = 0; i < (how == PARTS_BALANCE ? y->bulk : m->n); i++)
        if (m->blocks[i] || all) a[i] -= sum[y->part[i]];
}
