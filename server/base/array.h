/* SPDX-License-Identifier: BSD-3-Clause */
/* Aligned memory for particle data. */
#ifndef BASE_ARRAY_H
#define BASE_ARRAY_H

#include <stddef.h>

enum { ARRAY_ALIGNMENT = 64 }; /* a cache line, and the widest vector register */

/* n * size bytes, zeroed and aligned; NULL if there is no memory or the product overflows. Free with free(). */
void *array_new(size_t n, size_t size);

#endif
