/* SPDX-License-Identifier: BSD-3-Clause */
/* A range given out to the threads of a team: each goes through a part of its own, which lies together, from its beginning; who is done with it helps the
 * one that has most left, from its end. So nobody waits for a thread that something else keeps from its processor. */
#ifndef SIM_SHARES_H
#define SIM_SHARES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { SHARES_MAX = 64 }; /* more threads than that have parts in common */

/* Front and behind the back of what is left of a part; on a line of the cache of its own. */
typedef struct Share {
    _Alignas(64) _Atomic uint64_t left;
} Share;

typedef struct Shares {
    int n;
    Share of[SHARES_MAX];
} Shares;

/* Of 0 <= k < n, n < 2^32, among so many threads. */
void shares_init(Shares *shares, size_t n, int threads);

/* Something for this thread to do, which nobody else gets; false: all is done or under way. */
bool shares_take(Shares *shares, int thread, size_t *ret);

#endif
