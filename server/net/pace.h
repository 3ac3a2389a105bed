/* SPDX-License-Identifier: BSD-3-Clause */
/* How many questions are heard in a second while a run takes steps. Each is cheap; but one after the other without end takes the processors that the steps need, in
 * the daemon and in clients beside it. Those that come sooner wait, connections in turn; of more than may wait, the last is refused. Sockets are read all the while: ZeroMQ
 * ends the process if a connection ends that it has stopped reading. Of one thread. */
#ifndef NET_PACE_H
#define NET_PACE_H

#include "net/exchange.h"
#include "run/quota.h"
#include <zmq.h>

/* Questions in a second, by who asks. A pool that was silent may ask a quarter of these at once. */
enum { PACE_VIEWERS = 100, PACE_STEERERS = 100, PACE_LOCAL = 200 };

/* Requests of any kind that are read in a second, and as many at once after silence: to refuse one takes time too. */
enum { PACE_READ = 1000 };

/* How many wait: of one connection, and of a pool; and their bytes. What is one's share of a pool that is full may wait nevertheless. */
enum { PACE_EACH = 1024, PACE_POOL = 4096, PACE_EACH_BYTES = 4 << 20, PACE_POOL_BYTES = 32 << 20 };

/* A question that waits. */
typedef struct Held {
    struct Held *next;
    Sender sender;
    double deadline; /* [s] of clock_now(): it waits no longer; INFINITY: none */
    zmq_msg_t frame; /* its first part */
    uint64_t parts;  /* that it had    */
} Held;

/* Begins as zeros. */
typedef struct Pace {
    struct PaceLine {
        struct PaceQueue *first; /* of connections that have questions here, whose turn is next */
        size_t queues, n, bytes; /* all together                                                */
        double spent;            /* [s] time up to which credit is used                         */
        double soonest;          /* [s] none of them has an earlier deadline; with a queue      */
    } lines[POOLS];
    double read; /* [s] time up to which credit to read is used: then it goes on */
} Pace;

/* Frees what still waits. */
void pace_done(Pace *pace);

/* Have so many been read that reading rests for a moment? What is not read stays in its connection, and connections take turns. */
bool pace_rests(const Pace *pace, double now);

/* One has been read. */
void pace_note_read(Pace *pace, double now);

/* May this sender be heard at once? Then it is counted. Not while others of its pool wait. */
bool pace_admits(Pace *pace, const Sender *sender, double now);

/* Let it wait; takes over the frame.
 *
 * Returns MNS_E_LIMIT with a sentence if as many wait as may, MNS_E_MEMORY. */
MnsStatus pace_hold(Pace *pace, const Sender *sender, zmq_msg_t *frame, uint64_t parts, double deadline,
                    MnsError *error);

/* The next that is heard now, counted and yours; NULL: none yet.
 *  hurried  nothing computes, so none need wait */
Held *pace_next(Pace *pace, bool hurried, double now);

/* The first that this connection, or any with that id, left waiting; yours; NULL: none. One of them NULL. */
Held *pace_pull(Pace *pace, const Sender *sender, const ProtobufCBinaryData *id);

/* A connection has ended, that with this descriptor or this one: what it asked is dropped. */
void pace_forget_fd(Pace *pace, int fd);
void pace_forget(Pace *pace, const uint8_t identity[], size_t size);

/* [s] When pace_next() has one; INFINITY: none waits. */
double pace_due(const Pace *pace);

/* NULL is fine. */
void held_free(Held *held);

#endif
