/* SPDX-License-Identifier: BSD-3-Clause */
/* Aligned memory for particle data. */
#include "base/array.h"
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void *array_new(size_t n, size_t size)
{
    if (size && n > (SIZE_MAX - ARRAY_ALIGNMENT) / size) return NULL;
    size_t bytes = (n * size + ARRAY_ALIGNMENT - 1) / ARRAY_ALIGNMENT * ARRAY_ALIGNMENT;
    if (!bytes) bytes = ARRAY_ALIGNMENT;
    void *p = aligned_alloc(ARRAY_ALIGNMENT, bytes);
    if (p) memset(p, 0, bytes);
    return p;
}
