/* SPDX-License-Identifier: BSD-3-Clause */
/* One writer at a time: who may change the run now, and until when. A lease has an epoch, a number that rises with every new one:
 * what was sent under an old one is refused when it would take effect, however late it comes. It keeps people and programs from
 * working against each other by mistake; who may do what at all is a matter of roles (common/wire/keys.h). */
#ifndef RUN_LEASE_H
#define RUN_LEASE_H

#include "common/wire/lease.h"
#include <meniscus/status.h>
#include <stdbool.h>
#include <stdint.h>

enum { LEASE_HOLDER = 64 };

typedef struct Lease {
    uint64_t epoch;            /* of the last one that was given; 0: none yet                     */
    double until;              /* [s] of clock_now(); it is over from there on                    */
    uint32_t ttl_ms;           /* that it was asked for                                           */
    char holder[LEASE_HOLDER]; /* what others are told                                            */
} Lease;

/* What is asked for: a lease, more time for that of `epoch`, or its end. */
typedef struct LeaseWish {
    uint64_t epoch; /* 0: a new one                                                     */
    uint64_t ttl_ms;
    bool release;
    const char *holder; /* of a new one                                                 */
} LeaseWish;

/* Is somebody's under way? */
bool lease_live(const Lease *lease, double now);

/* MNS_OK; MNS_E_INVALID: a time to live out of LEASE_MS_MIN to LEASE_MS_MAX, a name too long or none; MNS_E_HELD: another has it;
 * MNS_E_EXPIRED: that of this epoch is over. An epoch given out is above all before and at least `least`. */
MnsStatus lease_take(Lease *lease, const LeaseWish *wish, uint64_t least, double now, MnsError *error);

/* May a command change something that came with this epoch, 0 for none? What lease_take() returns. */
MnsStatus lease_admits(const Lease *lease, uint64_t epoch, double now, MnsError *error);

#endif
