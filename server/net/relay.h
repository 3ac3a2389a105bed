/* SPDX-License-Identifier: BSD-3-Clause */
/* Those from afar at one of the gate's sockets, each with a connection of its own to the daemon, as who it is: requests in, replies and items out, at the
 * pace of who takes them. Nothing waits; what is under way is bounded by bytes, for each and in all. Of one thread. */
#ifndef NET_RELAY_H
#define NET_RELAY_H

#include "net/access.h"
#include "net/links.h"
#include "run/quota.h"

typedef struct RelayOptions {
    void *context;
    Access *access;
    int fd;              /* that listens                                             */
    const char *daemon;  /* "ipc://...", where it takes those whom the gate has let in */
    const char *monitor; /* "inproc://NAME"                                          */
    size_t largest;      /* bytes of a request                                       */
    size_t most;         /* clients, at most RELAY_CLIENTS */
    Quota quota;         /* and of one key                                           */
    size_t window;       /* bytes on their way to each, that are not taken           */
    int ahead;           /* messages of each that are read before there is room      */
    uint64_t threads;    /* of ZeroMQ, which may serve it: bits                      */
} RelayOptions;

typedef struct Relay Relay;

/* MNS_E_MEMORY, MNS_E_IO. NULL in *ret on failure. */
MnsStatus relay_new(const RelayOptions *options, Relay **ret, MnsError *error);

/* Close the sockets; what is under way may take so many milliseconds. Its memory stays until relay_free(), after the context is ended. */
void relay_close(Relay *relay, int linger);
void relay_free(Relay *relay);

/* What to wait for: returns how many, at most RELAY_ITEMS. */
enum { RELAY_CLIENTS = 500, RELAY_ITEMS = RELAY_CLIENTS + 3 };
size_t relay_items(Relay *relay, zmq_pollitem_t *ret);

/* Carry what is there. True if there may be more at once. items: as relay_items() wrote them, and zmq_poll(). */
bool relay_turn(Relay *relay, const zmq_pollitem_t *items);

/* Must relay_turn() be called soon, whatever comes? */
bool relay_is_busy(const Relay *relay);

Links *relay_links(Relay *relay);

#endif
