/* SPDX-License-Identifier: BSD-3-Clause */
/* Orders on their way to the runner: a bounded queue that says "full" rather than grow. Any thread may post, one takes. Those of one connection come
 * out in the order in which they went in; connections take turns, so that nobody waits for all that another wants. */
#ifndef RUN_MAILBOX_H
#define RUN_MAILBOX_H

#include "run/quota.h"
#include <pthread.h>
#include <stddef.h>

typedef struct Mailbox {
    pthread_mutex_t lock;
    pthread_cond_t filled;
    Order *urgent, *plain; /* first of each list */
    _Atomic size_t n;      /* changed with the lock held, and looked at without */
    size_t limit;          /* for those of this machine                         */
    bool woken;            /* whoever waits for an order is to look around first */
    uint64_t posted;
    uint64_t turn; /* of the order that was taken last */
} Mailbox;

/* Of orders that write a file, how many of one connection may wait. */
enum { MAILBOX_FILES = 64 };

/* limit: how many plain orders of this machine it holds, half of them such that only look; urgent ones always find room for as many again. Those
 * with a key have room besides, as run/quota.c says. */
void mailbox_init(Mailbox *box, size_t limit);

/* Orders still inside are the caller's business: take them first. */
void mailbox_done(Mailbox *box);

/* MNS_OK; MNS_E_LIMIT if it is full for this identity, or has too many files for this connection, and the order stays the caller's. */
MnsStatus mailbox_post(Mailbox *box, Order *order, MnsError *error);

/* The next order, urgent ones first unless one leads; waits for one until the moment `until` (clock_now()). NULL if there is none. */
Order *mailbox_take(Mailbox *box, double until);

/* The next order at once, as above, but none that only looks, or that writes a file, or neither; what came after such a one over the same connection waits
 * with it. NULL if there is none. */
Order *mailbox_take_but(Mailbox *box, bool looks, bool writes);

/* Whoever waits for an order, now or the next time, gets NULL at once: there is something else to see to. */
void mailbox_wake(Mailbox *box);

/* The next order that may be served while the run comes back after a crash; NULL if there is none now. */
Order *mailbox_take_meanwhile(Mailbox *box);

/* Take the first order out of the queue whose deadline lies before now; NULL if there is none. */
Order *mailbox_remove_late(Mailbox *box, double now);

/* Take the first order out of the queue that sets in motion and was posted before number; NULL if there is none. */
Order *mailbox_remove_motion(Mailbox *box, uint64_t before);

/* Is there one that ends the order of this id, while it is served? It stays where it is, and knows.
 *  recovering  the order leads back to a run after a crash: only one that may be served meanwhile ends it */
bool mailbox_ends(Mailbox *box, const uint8_t id[static ORDER_ID], bool recovering);

/* Take the order of this id out of the queue; NULL if it is not there. */
Order *mailbox_remove(Mailbox *box, const uint8_t id[static ORDER_ID]);

#endif
