/* SPDX-License-Identifier: BSD-3-Clause */
/* Memory that ends. Only allocations of the thread that says so fail, and none under a sanitizer, which has an allocator of its own. */
#ifndef TESTS_MEMORY_H
#define TESTS_MEMORY_H

#include <stdbool.h>

/* Whether it can be made to fail. */
extern const bool memory_can_fail;

/* After n more, one allocation fails; negative: none. */
void memory_fails_after(long n);

/* From now on all fail, or none. */
void memory_is_gone(bool gone);

#endif
