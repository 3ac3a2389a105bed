/* SPDX-License-Identifier: BSD-3-Clause */
/* Aligned memory for particle data. */
#include "base/array.h"
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { HUGE_PAGE = 1 << 21, SHARE = 1 << 20 }; /* bytes: of a huge page, of what one thread clears at a time */

/* Neighbours are looked up all over an array, which takes hundreds of small pages. The rest behind the last whole huge page stays
 * on small ones. An old kernel, or one that is told not to, just has small pages everywhere. */
static void *large(size_t bytes)
{
    void *p = NULL;
    if (posix_memalign(&p, HUGE_PAGE, bytes)) return NULL;
    (void)madvise(p, bytes / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
#pragma omp parallel for schedule(static) /* pages come to be where they are first written, so all threads write */
    for (size_t k = 0; k < bytes; k += SHARE) memset((char *)p + k, 0, bytes - k < SHARE ? bytes - k : SHARE);
    return p;
}

void *array_new(size_t n, size_t size)
{
    if (size && n > (SIZE_MAX - ARRAY_ALIGNMENT) / size) return NULL;
    size_t bytes = (n * size + ARRAY_ALIGNMENT - 1) / ARRAY_ALIGNMENT * ARRAY_ALIGNMENT;
    if (!bytes) bytes = ARRAY_ALIGNMENT;
    if (bytes >= HUGE_PAGE) return large(bytes);
    void *p = aligned_alloc(ARRAY_ALIGNMENT, bytes);
    if (p) memset(p, 0, bytes);
    return p;
}
