/* SPDX-License-Identifier: BSD-3-Clause */
/* Pick the few of many: loops that compilers do not vectorise, since how much they write depends on the data, and what marks them. Written
 * for the instruction sets that have what it takes, chosen while running, with a plain twin that gives the same. */
#ifndef SIM_SELECT_H
#define SIM_SELECT_H

#include "sim/level.h"
#include <stdbool.h>

enum { LANES = 8 };        /* pairs of a block */
enum { SELECT_SLACK = 8 }; /* entries behind the last that may be read, or written with rubbish */

/* Bit l of marks[b] is whether r[b * stride + l] < reach, l < 8, b < blocks. */
OPAQUE void select_marks(Level level, const double *r, size_t stride, size_t blocks, double reach, uint8_t *marks);

/* Entries of list[n] whose bit is set, bit l of bits[b] that of entry 8 b + l; bits from n on are 0. Returns how many;
 * out: [n + SELECT_SLACK]. */
size_t select_marked(Level level, const uint32_t *list, size_t n, const uint8_t *bits, uint32_t *out);

/* Where points are. period: of each direction, 0 where it is open, and frequency: one over it, or 0. */
typedef struct Points {
    const double *x[3], *period, *frequency; /* [dim] are used */
} Points;

/* Indices from first to last - 1, but for `self`, which is the one at `at`, of points of which the nearest image is nearer to `at` than the root of `distance2`.
 * Returns how many; sets *images if that image is another than the point itself for any of them. out: [last - first + SELECT_SLACK]. */
typedef size_t (*SelectNear)(const Points *points, uint32_t first, uint32_t last, const double at[3], double distance2,
                             uint32_t self, uint32_t *out, bool *images);

/* Where it is not periodic, periods are not looked at. */
SelectNear select_near(Level level, int dim, bool periodic);

#endif
