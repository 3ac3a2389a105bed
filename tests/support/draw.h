/* SPDX-License-Identifier: BSD-3-Clause */
/* Numbers at random by a seed, so that a failure can be had again: splitmix64 (Steele, Lea and Flood 2014). */
#ifndef SUPPORT_DRAW_H
#define SUPPORT_DRAW_H

#include <stddef.h>
#include <stdint.h>

static inline uint64_t draw(uint64_t *seed)
{
    uint64_t z = *seed += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* n > 0. */
static inline size_t draw_below(uint64_t *seed, size_t n)
{
    return (size_t)(draw(seed) % n);
}

/* In [0, 1). */
static inline double draw_share(uint64_t *seed)
{
    return 0x1p-53 * (double)(draw(seed) >> 11);
}

/* In [-1, 1). */
static inline double draw_signed(uint64_t *seed)
{
    return 2 * draw_share(seed) - 1;
}

#endif
