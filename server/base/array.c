/* SPDX-License-Identifier: BSD-3-Clause */
/* Aligned memory for particle data. */
#include "base/array.h"
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { HUGE_PAGE = 1 << 21, SHARE = 1 << 20 }; /* bytes: of a huge page, of what one thread clears at a time */

/* SIZE_MAX: that is no size. */
static size_t bytes_of(size_t n, size_t size)
{
    if (size && n > (SIZE_MAX - ARRAY_ALIGNMENT) / size) return SIZE_MAX;
    const size_t bytes = (n * size + ARRAY_ALIGNMENT - 1) / ARRAY_ALIGNMENT * ARRAY_ALIGNMENT;
    return bytes ? bytes : ARRAY_ALIGNMENT;
}

/* Neighbours are looked up all over an array, which takes hundreds of small pages. The rest behind the last whole huge page stays
 * on small ones. An old kernel, or one that is told not to, just has small pages everywhere. */
static void *take(size_t bytes)
{
    void *p = NULL;
    if (bytes == SIZE_MAX || posix_memalign(&p, bytes < HUGE_PAGE ? ARRAY_ALIGNMENT : HUGE_PAGE, bytes)) return NULL;
    if (bytes >= HUGE_PAGE) (void)madvise(p, bytes / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
    return p;
}

void *array_room(size_t n, size_t size)
{
    return take(bytes_of(n, size));
}

void *array_new(size_t n, size_t size)
{
    const size_t bytes = bytes_of(n, size);
    void *p = take(bytes);
    return p ? memset(p, 0, bytes) : NULL;
}

void *array_new_team(size_t n, size_t size, int threads)
{
    const size_t bytes = bytes_of(n, size);
    char *p = take(bytes);
    if (!p) return NULL;
#pragma omp parallel for schedule(static) num_threads(threads) if (bytes > SHARE)
    for (size_t k = 0; k < bytes; k += SHARE) memset(p + k, 0, bytes - k < SHARE ? bytes - k : SHARE);
    return p;
}
