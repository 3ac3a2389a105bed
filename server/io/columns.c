/* SPDX-License-Identifier: BSD-3-Clause */
/* Component by component in memory, row by row on the disk, through a buffer of bounded size. */
#include "io/columns.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCK = 1 << 16, WIDEST = 3 }; /* rows, columns */

static void interleave(char *rows, const void *column, size_t first, size_t n, int d, int width, size_t size)
{
    for (size_t k = 0; k < n; k++) {
        char *to = rows + (k * (size_t)width + (size_t)d) * size;
        if (column) memcpy(to, (const char *)column + (first + k) * size, size);
        else memset(to, 0, size);
    }
}

static char *new_block(H5 *h, size_t size)
{
    char *rows = malloc((size_t)BLOCK * WIDEST * size);
    if (!rows) h5_raise(h, MNS_E_MEMORY, "no memory for a buffer of %d rows", BLOCK);
    return rows;
}

void columns_put(H5 *h, const char *name, MnsType type, size_t n, int width, const void *const *columns)
{
    const size_t size = h5_size(type);
    h5_make(h, name, h5_type(type), width > 1 ? 2 : 1, (hsize_t[]){n, (hsize_t)width});
    char *rows = new_block(h, size);
    for (size_t first = 0; first < n && !h->status; first += BLOCK) {
        const size_t count = n - first < BLOCK ? n - first : BLOCK;
        for (int d = 0; d < width; d++) interleave(rows, columns[d], first, count, d, width, size);
        h5_put_rows(h, name, h5_type(type), first, count, rows);
    }
    free(rows);
}
