/* SPDX-License-Identifier: BSD-3-Clause */
/* Instruction sets. What is hot is compiled once for each level, from the same source, and the best that the machine has is
 * taken while running. All give the same bits: sums are kept in eight lanes however wide the vectors are (row.h), and
 * multiplications are not fused with additions. */
#ifndef SIM_LEVEL_H
#define SIM_LEVEL_H

#include <meniscus/sim.h>

/* Part of each function it is called from, and so compiled for that one's level. */
#define INLINE static inline __attribute__((always_inline))

/* Built for one machine with -march, there is that one level. */
#if defined __x86_64__ && !defined __AVX2__
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

#endif
