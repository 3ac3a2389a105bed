/* SPDX-License-Identifier: BSD-3-Clause */
/* Fields are kept component by component in memory, but row by row in snapshots, as plotting programs want them. */
#ifndef IO_COLUMNS_H
#define IO_COLUMNS_H

#include "io/h5.h"

/* Make and fill dataset name [n][width], or [n] if width is 1, from columns [width][n]; a NULL column is all zeros. */
void columns_put(H5 *h, const char *name, MnsType type, size_t n, int width, const void *const *columns);

#endif
