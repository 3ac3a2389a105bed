/* SPDX-License-Identifier: BSD-3-Clause */
/* Loops over the numbers of an array that is packed, in blocks that stay in the first cache and are simple enough for vector units. */
#include "common/wire/packing_numbers.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

/* Values of a block: whole rows, so that what belongs to a component is always at the same places of it. */
enum { ROWS = 16, BLOCK = PACKING_OFFSETS * ROWS };

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

typedef struct Extent {
    double low, high;
} Extent;

/* The extents of all components. False if a value is not finite. */
static bool measure(const double *x, size_t n, size_t components, Extent *ret)
{
    assert(components >= 1 && components <= PACKING_OFFSETS);
    const size_t block = components * ROWS;
    double low[BLOCK], high[BLOCK], doubt[BLOCK] = {0};
    for (size_t j = 0; j < block; j++) low[j] = high[j] = x[j % components];
    for (size_t k = 0; k < n; k += block) {
        const double *at = x + k;
        const size_t m = smaller(block, n - k);
        for (size_t j = 0; j < m; j++) {
            low[j] = at[j] < low[j] ? at[j] : low[j];
            high[j] = at[j] > high[j] ? at[j] : high[j];
            doubt[j] += at[j] - at[j]; /* 0, or NaN for ever */
        }
    }
    double sum = 0;
    for (size_t j = 0; j < block; j++) {
        const size_t c = j % components;
        if (j < components) ret[c] = (Extent){low[j], high[j]};
        else ret[c] = (Extent){fmin(ret[c].low, low[j]), fmax(ret[c].high, high[j])};
        sum += doubt[j];
    }
    return sum == 0;
}

/* Half a step is the bound less what rounding may add: to the quotient, of at most 2^32, before it becomes an integer, and to the value
 * that is made of that again. */
static double longest_step(double bound, double largest)
{
    const double half = bound * (1 - 0x1p-18) - largest * 0x1p-51;
    return half < DBL_MAX / 4 ? 2 * half : DBL_MAX / 2;
}

Meniscus__Departure grid_find(const double *x, size_t n, size_t components, double bound, Grid *ret)
{
    Extent extent[PACKING_OFFSETS];
    double largest = 0, range = 0;
    if (!measure(x, n, components, extent)) return MENISCUS__DEPARTURE__DEPARTURE_NOT_FINITE;
    Grid grid = {.components = components};
    for (size_t c = 0; c < components; c++) {
        grid.offset[c] = extent[c].low;
        largest = fmax(largest, fmax(fabs(extent[c].low), fabs(extent[c].high)));
        range = fmax(range, extent[c].high - extent[c].low);
    }
    grid.step = longest_step(bound, largest);
    if (!(grid.step >= DBL_MIN)) return MENISCUS__DEPARTURE__DEPARTURE_TOO_FINE;
    const double top = rint(range / grid.step * (1 + 4 * DBL_EPSILON)); /* no quotient is rounded to more */
    if (!(top <= UINT32_MAX)) return MENISCUS__DEPARTURE__DEPARTURE_TOO_FINE;
    grid.width = top <= UINT8_MAX ? 1 : top <= UINT16_MAX ? 2 : 4;
    *ret = grid;
    return MENISCUS__DEPARTURE__DEPARTURE_NONE;
}

static void store(const uint64_t *n, size_t m, unsigned width, void *ret)
{
    uint8_t *one = ret;
    uint16_t *two = ret;
    uint32_t *four = ret;
    if (width == 1)
        for (size_t j = 0; j < m; j++) one[j] = (uint8_t)n[j];
    else if (width == 2)
        for (size_t j = 0; j < m; j++) two[j] = (uint16_t)n[j];
    else
        for (size_t j = 0; j < m; j++) four[j] = (uint32_t)n[j];
}

bool grid_quantise(const Grid *grid, const double *x, size_t n, double bound, void *ret)
{
    const size_t block = grid->components * ROWS;
    const double to_integer = 0x1p52; /* what it is added to has its integer in the lowest bits */
    const double step = grid->step, inverse = 1 / step;
    double offset[BLOCK], shifted[BLOCK];
    uint64_t bits[BLOCK], off = 0;
    for (size_t j = 0; j < block; j++) offset[j] = grid->offset[j % grid->components];
    for (size_t k = 0; k < n; k += block) {
        const double *at = x + k;
        const size_t m = smaller(block, n - k);
        for (size_t j = 0; j < m; j++) {
            shifted[j] = (at[j] - offset[j]) * inverse + to_integer;
            const double back = offset[j] + step * (shifted[j] - to_integer);
            /* Rounding keeps order, so what is below the bound when it is rounded was so before. */
            off += (uint64_t) !(fabs(back - at[j]) < bound);
        }
        memcpy(bits, shifted, sizeof *bits * m);
        store(bits, m, grid->width, (uint8_t *)ret + k * grid->width);
    }
    return !off;
}

#define RESTORE(type)                                                                                                  \
    for (size_t j = 0; j < m; j++) ret[k + j] = offset[j] + step * (double)((const type *)integers)[k + j]

void grid_restore(const Grid *grid, const void *integers, size_t n, double *ret)
{
    const size_t block = grid->components * ROWS;
    const double step = grid->step;
    double offset[BLOCK];
    for (size_t j = 0; j < block; j++) offset[j] = grid->offset[j % grid->components];
    for (size_t k = 0; k < n; k += block) {
        const size_t m = smaller(block, n - k);
        if (grid->width == 1) RESTORE(uint8_t);
        else if (grid->width == 2) RESTORE(uint16_t);
        else RESTORE(uint32_t);
    }
}

bool numbers_narrow(const double *x, size_t n, float *ret)
{
    uint64_t lost = 0;
    for (size_t k = 0; k < n; k++) {
        ret[k] = (float)x[k];
        lost += (uint64_t)((fabs(x[k]) <= DBL_MAX) & !(fabsf(ret[k]) <= FLT_MAX));
    }
    return !lost;
}

/* --- bytes in another order --------------------------------------------------------------------------------------------- */

enum { TILE = 1024 }; /* rows that stay in the first cache while each of their bytes has its turn */

static inline void shuffle(const uint8_t *restrict rows, size_t n, size_t row, uint8_t *restrict ret)
{
    for (size_t first = 0; first < n; first += TILE) {
        const size_t end = smaller(n, first + TILE);
        for (size_t b = 0; b < row; b++)
            for (size_t k = first; k < end; k++) ret[b * n + k] = rows[k * row + b];
    }
}

static inline void unshuffle(const uint8_t *restrict planes, size_t n, size_t row, uint8_t *restrict ret)
{
    for (size_t first = 0; first < n; first += TILE) {
        const size_t end = smaller(n, first + TILE);
        for (size_t b = 0; b < row; b++)
            for (size_t k = first; k < end; k++) ret[k * row + b] = planes[b * n + k];
    }
}

/* Rows of a known length are several times as fast. */
void numbers_shuffle(const void *rows, size_t n, size_t row, void *ret)
{
    switch (row) {
    case 2: shuffle(rows, n, 2, ret); break;
    case 4: shuffle(rows, n, 4, ret); break;
    case 8: shuffle(rows, n, 8, ret); break;
    default: shuffle(rows, n, row, ret);
    }
}

void numbers_unshuffle(const void *planes, size_t n, size_t row, void *ret)
{
    switch (row) {
    case 2: unshuffle(planes, n, 2, ret); break;
    case 4: unshuffle(planes, n, 4, ret); break;
    case 8: unshuffle(planes, n, 8, ret); break;
    default: unshuffle(planes, n, row, ret);
    }
}
