/* SPDX-License-Identifier: BSD-3-Clause */
/* How much of what all clients share one identity may hold, and how much its role: a key that takes all it can leaves a place for every other. Viewers, those who
 * may steer, and the user of this machine have pools of their own, so the last two always find a place. */
#ifndef RUN_QUOTA_H
#define RUN_QUOTA_H

#include "run/order.h"

typedef enum Quota {
    QUOTA_CONTROL,   /* connections to the control socket, through the gate      */
    QUOTA_TELEMETRY, /* the same to the telemetry socket                         */
    QUOTA_DATA,      /* the same to the data socket                              */
    QUOTA_STREAMS,
    QUOTA_WAITS,     /* commands `wait` that have begun                          */
    QUOTA_COMMANDS,  /* that are queued                                          */
    QUOTA_QUESTIONS, /* the same, of those that only look                        */
    QUOTA_SCHEDULED, /* commands for a later step or time                        */
    QUOTA_UNREAD,    /* MiB of replies that are not read                         */
    QUOTAS
} Quota;

typedef enum QuotaPool {
    POOL_VIEWERS,
    POOL_STEERERS, /* operators and admins with a key                    */
    POOL_LOCAL,    /* the user of this machine, and the daemon itself    */
    POOLS
} QuotaPool;

/* What is held now: by the identity that asks, and by its pool. Begins as zeros. */
typedef struct QuotaUse {
    size_t own, pool;
} QuotaUse;

/* Read "NAME=VIEWER" or "NAME=VIEWER,OPERATOR", as in "streams=64,128": what one key of each pool may hold from now on, at most what all of the pool may. Before any
 * other thread begins. MNS_E_INVALID. */
MnsStatus quota_set(const char *text, MnsError *error);

QuotaPool quota_pool(const Who *who);

/* Are both the same key, or both of this machine? */
bool quota_same(const Who *a, const Who *b);

/* What one identity of the pool may hold, and all of it together. */
size_t quota_each(Quota quota, QuotaPool pool);
size_t quota_all(Quota quota, QuotaPool pool);

/* Add one that the holder has to the use of the one who asks. */
void quota_count(QuotaUse *use, const Who *who, const Who *holder);

/* MNS_E_LIMIT with a sentence if the one who asks, or its pool, has no more. */
MnsStatus quota_check(Quota quota, const Who *who, const QuotaUse *use, MnsError *error);

#endif
