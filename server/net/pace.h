/* SPDX-License-Identifier: BSD-3-Clause */
/* How many questions are heard in a second while a run takes steps. Each is cheap; but one after the other without end takes the processors that the steps need, in
 * the daemon and in clients beside it. Those that come sooner wait, connections in turn; none is refused for it. Sockets are read all the while: ZeroMQ
 * ends the process if a connection ends that it has stopped reading. Of one thread. */
#ifndef NET_PACE_H
#define NET_PACE_H

#include "net/exchange.h"
#include "run/quota.h"
#include <zmq.h>

/* Questions in a second, by who asks. A pool that was silent may ask a quarter of these at once. */
enum { PACE_VIEWERS = 100, PACE_STEERERS = 100, PACE_LOCAL = 200 };

/* How many wait: of one connection, and of all. */
enum { PACE_EACH = 64, PACE_ALL = 2048 };

enum { PACE_ID = 64, PACE_BYTES = 4096 }; /* bytes of the longest id; of a frame that waits */

/* A question that waits. */
typedef struct Held {
    struct Held *next;
    uint64_t turn;
    Sender sender;
    double deadline; /* [s] of clock_now(): it waits no longer; INFINITY: none */
    zmq_msg_t frame; /* its first part */
    uint64_t parts;  /* that it had    */
} Held;

/* Begins as zeros. */
typedef struct Pace {
    struct PaceLine {
        Held *first;   /* in the order of turns               */
        uint64_t turn; /* of the one that was heard last      */
        double spent;  /* [s] time up to which credit is used */
    } lines[POOLS];
    size_t n; /* that wait */
} Pace;

/* Frees what still waits. */
void pace_done(Pace *pace);

/* May this sender be heard at once? Then it is counted. Not while others of its pool wait. */
bool pace_admits(Pace *pace, const Sender *sender, double now);

/* Has its connection, or have all together, as many waiting as may? */
bool pace_is_full(const Pace *pace, const Sender *sender);

/* Let it wait; takes over the frame. False: it cannot, as it is full, the frame too long, or there is no memory. */
bool pace_hold(Pace *pace, const Sender *sender, zmq_msg_t *frame, uint64_t parts, double deadline);

/* The next that is heard now, counted and yours; NULL: none yet.
 *  hurried  nothing computes, so none need wait */
Held *pace_next(Pace *pace, bool hurried, double now);

/* The first that this connection, or any with that id, left waiting; yours; NULL: none. One of them NULL. */
Held *pace_pull(Pace *pace, const Sender *sender, const ProtobufCBinaryData *id);

/* The connection with this descriptor has ended: what it asked is dropped. */
void pace_forget(Pace *pace, int fd);

/* [s] When pace_next() has one; INFINITY: none waits. */
double pace_due(const Pace *pace);

/* NULL is fine. */
void held_free(Held *held);

#endif
