/* SPDX-License-Identifier: BSD-3-Clause */
/* How many questions are heard in a second while a run computes. Each is cheap; but one after the other without end takes the processors that the steps need, in the
 * daemon and in clients beside it. Those that come sooner wait, and connections take turns. Commands that change something are not counted. */
#ifndef NET_PACE_H
#define NET_PACE_H

#include "net/exchange.h"
#include "run/quota.h"

/* Questions in a second, by who asks. A pool that was silent may ask a quarter of these at once. */
enum { PACE_VIEWERS = 100, PACE_STEERERS = 100, PACE_LOCAL = 200 };

/* Requests for streams in a second, of all together and but for credit. */
enum { PACE_STREAMS = 200 };

/* Note one of so many in a second. *spent: [s] time up to which credit is used: there is some where it is not later than now. */
void pace_spend(double *spent, int rate, double now);

enum { PACE_ID = 64 }; /* bytes of the longest id */

/* A question that waits, or one that cannot be read and waits for its refusal. */
typedef struct Held {
    struct Held *next;
    uint64_t turn;
    Sender sender;
    uint8_t id[PACE_ID];
    size_t id_size;
    Meniscus__Request *request; /* NULL: it is refused: */
    MnsError why;
} Held;

/* Begins as zeros. */
typedef struct Pace {
    struct PaceLine {
        Held *first;   /* in the order of turns               */
        uint64_t turn; /* of the one that was heard last      */
        double spent;  /* [s] time up to which credit is used */
    } lines[POOLS];
} Pace;

/* Frees what still waits. */
void pace_done(Pace *pace);

/* May this sender be heard at once? Then it is counted. Not while others of its pool wait. */
bool pace_admits(Pace *pace, const Sender *sender, double now);

/* Let it wait; takes over the request. MNS_E_LIMIT with a sentence if the key or its role has too many that wait, MNS_E_MEMORY: the request stays yours. */
MnsStatus pace_hold(Pace *pace, const Sender *sender, ProtobufCBinaryData id, Meniscus__Request *request,
                    const MnsError *why, MnsError *error);

/* The next that is heard now, counted and yours, free() and request_free(); NULL: none yet.
 *  hurried  nothing computes, so none need wait */
Held *pace_next(Pace *pace, bool hurried, double now);

/* The first that this connection, or any with that id, left waiting; yours; NULL: none. One of them NULL. */
Held *pace_pull(Pace *pace, const Sender *sender, const ProtobufCBinaryData *id);

/* [s] When pace_next() has one; INFINITY: none waits. */
double pace_due(const Pace *pace);

#endif
