/* SPDX-License-Identifier: BSD-3-Clause */
/* Loops over the numbers of an array that is packed: fewer bytes for each, and their bytes in another order. */
#ifndef COMMON_WIRE_PACKING_NUMBERS_H
#define COMMON_WIRE_PACKING_NUMBERS_H

#include "common/wire/packing.h"
#include <stdbool.h>
#include <stdint.h>

/* How doubles become integers: x = offset + step n. */
typedef struct Grid {
    size_t components; /* offsets: that of value k is the one of k % components */
    double offset[PACKING_OFFSETS], step;
    unsigned width; /* bytes of an integer: 1, 2 or 4 */
} Grid;

/* The grid of fewest bytes on which no value should be off by the bound; the number of values is a multiple of the components. DEPARTURE_NONE, or why
 * there is none. */
Meniscus__Departure grid_find(const double *x, size_t n, size_t components, double bound, Grid *ret);

/* Integers of grid->width bytes into ret. False if a value of this grid would be off by the bound or more, in exact arithmetic. */
bool grid_quantise(const Grid *grid, const double *x, size_t n, double bound, void *ret);

/* And back. */
void grid_restore(const Grid *grid, const void *integers, size_t n, double *ret);

/* False if a finite value is too large for a float. */
bool numbers_narrow(const double *x, size_t n, float *ret);

/* The first bytes of all n rows, then the second ones ...; and back. */
void numbers_shuffle(const void *rows, size_t n, size_t row, void *ret);
void numbers_unshuffle(const void *planes, size_t n, size_t row, void *ret);

#endif
