/* SPDX-License-Identifier: BSD-3-Clause */
/* Disjoint sets of numbers as trees, which all threads may join at a time: who points elsewhere never points at itself again, and nobody
 * points at a larger one. So whatever the order of joins, in the end the root of a set is the least of it. In the beginning up[i] = i. */
#ifndef BASE_FOREST_H
#define BASE_FOREST_H

#include <stdbool.h>
#include <stdint.h>

static inline uint32_t forest_parent(const uint32_t *up, uint32_t i)
{
    return __atomic_load_n(&up[i], __ATOMIC_RELAXED);
}

/* Those on the way are made to point there more directly. */
static inline uint32_t forest_root(uint32_t *up, uint32_t i)
{
    for (uint32_t above = forest_parent(up, i); above != i; above = forest_parent(up, i)) {
        const uint32_t next = forest_parent(up, above);
        if (next != above) __atomic_store_n(&up[i], next, __ATOMIC_RELAXED);
        i = next;
    }
    return i;
}

static inline void forest_join(uint32_t *up, uint32_t i, uint32_t j)
{
    while ((i = forest_root(up, i)) != (j = forest_root(up, j))) {
        uint32_t high = i > j ? i : j; /* is still a root, unless another thread has joined it meanwhile */
        const uint32_t low = i > j ? j : i;
        if (__atomic_compare_exchange_n(&up[high], &high, low, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) return;
    }
}

/* When all are joined: point at the root. */
static inline void forest_settle(uint32_t *up, uint32_t i)
{
    __atomic_store_n(&up[i], forest_root(up, i), __ATOMIC_RELAXED);
}

#endif
