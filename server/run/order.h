/* SPDX-License-Identifier: BSD-3-Clause */
/* What somebody wants of the runner, and the answer: an order travels through the mailbox, is served between two steps, and
 * comes back through the outbox exactly once. */
#ifndef RUN_ORDER_H
#define RUN_ORDER_H

#include "common/wire/keys.h"
#include "meniscus.pb-c.h"
#include "run/lease.h"
#include "run/note.h"

struct Run;

enum { ORDER_ID = 16 };

/* Who gave an order: the name of a key, or one of those that no key has (common/wire/keys.h). */
typedef struct Who {
    char name[KEY_NAME_SIZE];
    Role role;
} Who;

/* When a scheduled order takes effect: at the step, or at the first boundary from the time on [s]. UINT64_MAX, INFINITY: no matter. */
typedef struct Moment {
    uint64_t step;
    double t;
} Moment;

typedef struct Order {
    struct Order *next;

    /* If it changes something, what the journal says of it: the answer leaves only when that is on the disk. */
    const Meniscus__Request *request; /* as it was sent; NULL: it changes nothing                */
    bool begun;                       /* the journal has it already, and must tell how it ended   */

    const struct Lineage
        *lineage; /* of a load after a crash, and of a command that was under way: what is come back to; borrowed */

    bool scheduled; /* it waits for its moment: */
    Moment at;
    bool durable;              /* what the journal says of its answer is on the disk                     */
    bool appointed, announced; /* the journal has it; and whoever listens has been told                   */
    bool rescues;              /* it is answered whether the journal can be written or not                */
    bool filed;                /* its file is written, or could not be: status and error tell             */
    Note notice;               /* that it is scheduled: comes through the outbox before its answer        */

    /* Could it take effect now, but for the moment? As serve() would find, without doing it. */
    MnsStatus (*check)(const struct Run *run, struct Order *order, MnsError *error);

    /* What the reply will be, once it is answered; on the runner's thread. May be NULL; the result too. */
    const Meniscus__Reply *(*seal)(struct Order *order);

    uint8_t id[ORDER_ID];
    Who who;
    uint64_t from;   /* the connection that it came over: those of one keep their order; 0: it is our own */
    uint64_t number; /* rises in the order of posting                                        */
    uint64_t turn;   /* of its connection, see run/mailbox.c                                 */
    bool heads;      /* it is the first of its connection that waits                         */
    bool urgent;     /* overtakes all that are not                                           */
    bool leads;      /* nothing overtakes it: what comes after the start is for the run that it brings  */
    bool looks;      /* changes nothing, writes nothing: may be kept waiting by what does, and by steps */
    bool writes;     /* a file: while the run goes on, it waits until the writer has room for it        */
    bool meanwhile;  /* served also while the run comes back after a crash                   */
    bool motion;     /* sets the run in motion: called off by a later pause or stop           */
    bool ends;       /* what is being loaded is given up for it: the order of `ends_id`      */
    bool ends_any;   /* or whichever it is                                                   */
    bool ended;      /* that has happened */
    uint8_t ends_id[ORDER_ID];
    bool conditional; /* refused unless the run is at if_step                                */
    uint64_t if_step;
    uint64_t if_version;  /* refused unless the case is at it; 0: at whichever                */
    uint64_t lease_epoch; /* that it came with; 0: none                                      */
    bool leased;          /* refused while somebody else holds the lease                     */
    double deadline;      /* [s] of clock_now(); INFINITY: none                                   */

    /* Called on the runner's thread. Must lead to one run_answer(), at once or later. */
    void (*serve)(struct Run *run, struct Order *order);

    /* The answer: */
    bool from_checkpoint; /* what was loaded or restored */
    uint64_t from_sum;    /* of that checkpoint         */
    MnsStatus status;
    MnsError error; /* if status is not MNS_OK                                              */
    RunState state; /* after the effect                                                     */
    uint64_t step, effect_step;
    uint64_t short_of;  /* given up on the way back after a crash, before this step was reached; 0: it was not */
    uint64_t reached;   /* and at this one */
    uint64_t version;   /* of the case; 0 without one */
    Lease lease;        /* that was given or renewed; none of epoch 0 */
    double t, effect_t; /* [s]                                                                  */
    char path[4096];    /* of the file written, or the run directory; empty if there is none    */
    Document *document; /* a share of the case after a change of it; NULL if there was none     */
    unsigned threads;   /* used then                                                            */
    Note note;          /* that carries it through the outbox: an answer needs no memory to get there */
} Order;

/* Where it took effect. On the way back after a crash the run is, for the journal and in effect_step, where it was; for people it is where it
 * had come to. */
static inline uint64_t order_effect(const Order *order)
{
    return order->short_of ? order->reached : order->effect_step;
}

#endif
