/* SPDX-License-Identifier: BSD-3-Clause */
/* How long a lease may live before it is renewed: for the daemon, which refuses the rest, and for clients, who know by what name it was said. */
#ifndef COMMON_WIRE_LEASE_H
#define COMMON_WIRE_LEASE_H

#include <stdbool.h>

enum { LEASE_MS_MIN = 100, LEASE_MS_MAX = 86400000 };

/* In whole milliseconds, as it is sent; not for a NAN. */
static inline bool lease_can_live(double seconds)
{
    const double ms = 1e3 * seconds + 0.5;
    return ms >= LEASE_MS_MIN && ms < LEASE_MS_MAX + 1.0;
}

#endif
