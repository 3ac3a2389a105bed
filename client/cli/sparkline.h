/* SPDX-License-Identifier: BSD-3-Clause */
/* A chart one line high: the newest values of a series, each a block as high as it is great. */
#ifndef CLI_SPARKLINE_H
#define CLI_SPARKLINE_H

#include <stdbool.h>
#include <stddef.h>

enum { HISTORY_SIZE = 64, SPARKLINE_TEXT_SIZE = 3 * HISTORY_SIZE + 1 };

/* The newest values, in a ring. */
typedef struct History {
    double values[HISTORY_SIZE];
    size_t n; /* ever added */
} History;

void sparkline_add(History *history, double value);

/* Draw the newest, at most `width` of them, scaled to the least and greatest of them, which are told if there are any.
 * What is not finite is a gap.
 * ret: one character for each value
 * return: how many characters */
size_t sparkline(const History *history, size_t width, bool has_blocks, char ret[SPARKLINE_TEXT_SIZE],
                 double *ret_least, double *ret_greatest);

/* Does the locale of the environment have more than ASCII? */
bool terminal_has_blocks(void);

#endif
