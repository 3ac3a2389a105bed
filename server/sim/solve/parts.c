/* SPDX-License-Identifier: BSD-3-Clause */
/* Parts of a matrix that do not refer to each other, as of spaces on both sides of a wall: each has a constant of its own that nothing
 * determines. They are found anew for each solve, which costs about as much as a product, so that a restart need know nothing of them; and
 * by one thread, as are the sums of several, which are rare. */
#include "sim/solve/vectors.h"

/* The least row of its part, so far. Rows on the way are made to point there more directly. */
static uint32_t root(uint32_t *up, uint32_t i)
{
    while (up[i] != i) i = up[i] = up[up[i]];
    return i;
}

/* Does row i count? One that says nothing determines nothing, unless it is held. */
static bool counts(const System *y, uint32_t i)
{
    return y->matrix.blocks[i] > 0 || i == y->held;
}

/* How many fewer parts there are after row i was joined with those of one of its blocks. */
static size_t join(const System *y, uint32_t *up, uint32_t i, size_t block)
{
    const Matrix *m = &y->matrix;
    size_t joined = 0;
    const size_t first = (m->start[i] + block) * ENTRIES;
    uint32_t mine = root(up, i);
    for (size_t k = first; k < first + ENTRIES; k++) {
        const uint32_t j = m->column[k];
        if (m->c[k] == 0 || up[j] == mine || !counts(y, j)) continue;
        const uint32_t its = root(up, j);
        if (its == mine) continue;
        const uint32_t high = its > mine ? its : mine;
        mine = its > mine ? mine : its;
        up[high] = mine;
        joined++;
    }
    return joined;
}

/* Numbers instead of least rows, which come before the others; those too many share the last. */
static size_t number(const System *y)
{
    uint32_t *part = y->part, least[PARTS_MAX];
    size_t n = 0;
    for (uint32_t i = 0; i < y->matrix.n; i++) part[i] = root(part, i);
    for (uint32_t i = 0; i < y->matrix.n; i++) {
        size_t k = 0;
        while (k < n && least[k] != part[i]) k++;
        if (k == n && n < PARTS_MAX && counts(y, i)) least[n++] = part[i];
        part[i] = (uint32_t)(k < n ? k : n ? n - 1 : 0);
    }
    return n;
}

/* Block by block: one or two of each row are enough where there is one part only. */
void parts_find(System *y)
{
    const Matrix *m = &y->matrix;
    size_t separate = 0, most = 0;
    for (uint32_t i = 0; i < m->n; i++) {
        y->part[i] = i;
        separate += counts(y, i);
        most = m->blocks[i] > most ? m->blocks[i] : most;
    }
    for (size_t block = 0; block < most && separate > 1; block++)
        for (uint32_t i = 0; i < m->n && separate > 1; i++)
            if (block < m->blocks[i]) separate -= join(y, y->part, i, block);
    y->parts = separate > 1 ? number(y) : 1;
}

void parts_level(const System *y, double *a, PartsHow how)
{
    double sum[PARTS_MAX] = {0}, count[PARTS_MAX] = {0};
    const Matrix *m = &y->matrix;
    const size_t summed = how == PARTS_CENTRE ? y->bulk : m->n, counted = how == PARTS_MEAN ? m->n : y->bulk;
    for (size_t i = 0; i < summed; i++) {
        if (m->blocks[i] == 0) continue;
        sum[y->part[i]] += a[i];
        count[y->part[i]] += i < counted;
    }
    for (size_t k = 0; k < y->parts; k++) sum[k] = count[k] > 0 ? sum[k] / count[k] : 0;
    if (y->held != NOT_HELD) sum[y->part[y->held]] = 0;
    for (size_t i = 0; i < (how == PARTS_BALANCE ? y->bulk : m->n); i++)
        if (m->blocks[i]) a[i] -= sum[y->part[i]];
}
