/* SPDX-License-Identifier: BSD-3-Clause */
/* Aligned memory for particle data. */
#ifndef BASE_ARRAY_H
#define BASE_ARRAY_H

#include <stddef.h>

enum { ARRAY_ALIGNMENT = 64 }; /* a cache line, and the widest vector register */

/* n * size bytes, aligned; NULL if there is no memory or the product overflows. Free with free().
 *  array_new       zeroed
 *  array_new_team  zeroed by so many threads, as a page comes to be near the one that writes to it first
 *  array_room      not zeroed, for what is filled at once */
void *array_new(size_t n, size_t size);
void *array_new_team(size_t n, size_t size, int threads);
void *array_room(size_t n, size_t size);

#endif
