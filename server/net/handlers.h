/* SPDX-License-Identifier: BSD-3-Clause */
/* The commands of the protocol: what each is called, where and when it is possible, who does it. */
#ifndef NET_HANDLERS_H
#define NET_HANDLERS_H

#include "net/exchange.h"

typedef enum Where {
    HERE,   /* by the thread of the sockets, at once, from what the run last published */
    AT_STEP /* by the runner's thread, between two steps                              */
} Where;

/* What else there is to know of a command. */
typedef enum Trait {
    URGENT = 1 << 0,    /* overtakes all that is queued                             */
    MOTION = 1 << 1,    /* sets the run in motion; a later pause calls it off       */
    LARGE = 1 << 2,     /* its reply may be: not while its sender leaves much unread   */
    LAST = 1 << 3,      /* the daemon leaves after it                               */
    ENDS = 1 << 4,      /* gives up what is being loaded; a cancel, what it names   */
    CHANGES = 1 << 5,   /* something: the journal has it before its reply leaves   */
    LEASED = 1 << 6,    /* refused while somebody else holds the lease             */
    AT_MOMENT = 1 << 7, /* may be scheduled, see scheduled.h                      */
    LOOKS = 1 << 8,     /* and does no more: it changes nothing, and writes nothing */
    WRITES = 1 << 9     /* a file of the particles: not while others wait for the disk */
} Trait;

typedef struct Handler {
    const char *name;
    const char *typed; /* what people type for it; NULL: its name                  */
    Where where;
    Role role;       /* that it takes at least                                   */
    unsigned states; /* bits 1 << RunState in which it is possible               */
    unsigned traits; /* of Trait                                                 */

    /* Answers the order of the exchange, now or when done. */
    void (*serve)(Run *run, Exchange *exchange);

    /* Completes the reply after a success from what the order brought back, on the thread of the sockets; of what CHANGES something,
     * on the runner's. May be NULL. By then the run may be another one. */
    MnsStatus (*complete)(Exchange *exchange, MnsError *error);
} Handler;

/* NULL for a command that is not known. */
const Handler *handler_find(Meniscus__Request__CommandCase command);

/* Names of all, then NULL. */
enum { HANDLER_NAMES = 64 };
void handler_names(const char *ret[static HANDLER_NAMES]);

/* Is the command known, MNS_E_VERSION, and may they give it? MNS_E_DENIED. handler: NULL: it is not known. */
MnsStatus handler_check_role(const Handler *handler, const Who *who, MnsError *error);

/* Are these few enough, MNS_E_LIMIT, and each there once? MNS_E_INVALID. */
MnsStatus handler_check_set(const Meniscus__Set *set, MnsError *error);

/* Names of states, with commas. */
void handler_states(unsigned states, char ret[static 128]);

/* What to do first, for who is refused in a state. */
const char *handler_way_out(const Handler *handler, RunState state);

/* Set the exchange on its way: serve it here, or post it to the run. MNS_OK: its order will come back. MNS_E_LIMIT: the
 * mailbox is full. MNS_E_DENIED: whoever asks may not. */
MnsStatus handle(Run *run, Exchange *exchange, MnsError *error);

#endif
