/* SPDX-License-Identifier: BSD-3-Clause */
/* Instruction sets. What is hot is compiled once for each level, from the same source, and the best that the machine has is
 * taken while running. Sums are kept in eight lanes however wide the vectors are (row.h), and where multiplications are fused with
 * additions is written down (mul_add), so all levels that have such instructions give the same bits: all but that of machines older
 * than 2013. */
#ifndef SIM_LEVEL_H
#define SIM_LEVEL_H

#include <meniscus/sim.h>
#include <stdbool.h>

/* Part of each function it is called from, and so compiled for that one's level. */
#define INLINE static inline __attribute__((always_inline))

/* Before a call of which gcc knows what it clobbers it leaves the upper halves of vectors dirty: of such a function it knows nothing. */
#ifdef __clang__
#define OPAQUE
#else
#define OPAQUE __attribute__((noipa))
#endif

/* a b + c; fused: rounded once. Only where what it is part of stays the same, or the opposite, if the two of a pair are exchanged. */
INLINE double mul_add(double a, double b, double c, bool fused)
{
    return fused ? __builtin_fma(a, b, c) : a * b + c;
}

/* Has the plainest level that is built instructions for it? The others have. */
#if defined __FMA__ || defined __ARM_FEATURE_FMA
#define BASE_FUSES true
#else
#define BASE_FUSES false
#endif

/* Built for one machine with -march, there is that one level; under a sanitizer too, as gcc takes minutes for all of them. */
#if defined __x86_64__ && !defined __AVX2__ && !defined MENISCUS_SANITIZED
#define HAS_LEVELS 1
typedef enum Level { LEVEL_BASE, LEVEL_V3, LEVEL_V4, LEVELS } Level;
#define FOR_V3 __attribute__((target("arch=x86-64-v3")))
#define FOR_V4 __attribute__((target("arch=x86-64-v4")))
#else
#define HAS_LEVELS 0
typedef enum Level { LEVEL_BASE, LEVELS } Level;
#endif

/* The best of this machine, or the one that was asked for with mns_level_force(). */
Level level_in_use(void);

/* As mns_level() and mns_arithmetic() name them. */
const char *level_name(Level level);
const char *level_arithmetic(Level level);

#endif
