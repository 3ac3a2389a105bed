/* SPDX-License-Identifier: BSD-3-Clause */
/* Memory that ends: malloc, calloc and posix_memalign in front of those of the C library. */
#include "tests/support/memory.h"

#include <errno.h>
#include <stdlib.h>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED
#endif

static _Thread_local long left = -1;
static _Thread_local bool none;

void memory_fails_after(long n)
{
    left = n;
}

void memory_is_gone(bool gone)
{
    none = gone;
}

#ifdef SANITIZED
const bool memory_can_fail = false;
#else
const bool memory_can_fail = true;

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t n, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static bool refused(void)
{
    return none || (left >= 0 && left-- == 0);
}

void *malloc(size_t size)
{
    return refused() ? NULL : __libc_malloc(size);
}

void *calloc(size_t n, size_t size)
{
    return refused() ? NULL : __libc_calloc(n, size);
}

int posix_memalign(void **ret, size_t alignment, size_t size)
{
    void *p = refused() ? NULL : __libc_memalign(alignment, size);
    if (!p) return ENOMEM;
    *ret = p;
    return 0;
}
#endif
