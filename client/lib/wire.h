/* SPDX-License-Identifier: BSD-3-Clause */
/* One connection to a control socket: frames out, frames in, and whether the other side is there. Knows no message. */
#ifndef CLIENT_WIRE_H
#define CLIENT_WIRE_H

#include "common/wire/keys.h"
#include <meniscus/client.h>
#include <zmq.h>

enum { WIRE_MAX_FRAMES = 66, WIRE_OPENING_S = 5 /* for a daemon that should be there */ };

typedef struct Wire {
    void *context, *dealer, *monitor;
    char endpoint[MNS_ENDPOINT_SIZE];
    bool connected;       /* the last the monitor said                                     */
    unsigned connections; /* how often a connection was made: more than before = reconnected */
    double lost_since;    /* monotonic time [s] at which it was lost                        */
    int refusals;         /* how often nobody listened                                      */
    int cut;              /* handshakes in a row that ended without a word                  */
    bool was_cut;         /* the last attempt did                                           */
    double reconnect_s;   /* for so long it is waited for after that                        */
    int failed;           /* the event of a handshake that failed since; 0: none            */
    KeyPair keys;         /* empty: plain text                                              */
} Wire;

/* The frames of one message. */
typedef struct Frames {
    int n;
    zmq_msg_t frame[WIRE_MAX_FRAMES];
} Frames;

/* Monotonic time [s]. */
double wire_clock(void);

/* Connect. keys: NULL for plain text. MNS_OK; MNS_E_UNAVAILABLE at once if the connection is refused, at the deadline (monotonic) if there
 * is no answer; MNS_E_DENIED if our key is refused. */
MnsStatus wire_open(Wire *wire, const char *endpoint, const KeyPair *keys, double deadline, MnsError *error);

/* Have a socket that is not connected yet use the keys. False if they cannot be. */
bool wire_secure(const Wire *wire, void *socket);

void wire_close(Wire *wire);

/* For how long there has been no connection [s]; 0: there is one. */
double wire_away(Wire *wire);

/* A request that is longer than a daemon takes is not sent: MNS_E_LIMIT. most: [bytes]. */
MnsStatus wire_check_size(size_t size, int most, MnsError *error);

/* Send one frame; waits for a connection as long as a daemon may take to be restarted. MNS_E_UNAVAILABLE. */
MnsStatus wire_send(Wire *wire, const void *data, size_t size, MnsError *error);

/* Receive one message into ret, which the caller passes to frames_done(). Comes back with ret->n = 0 when the
 * connection was made anew, because an answer may be lost then. MNS_OK; MNS_E_TIMEOUT at `deadline` (monotonic,
 * INFINITY for none); MNS_E_UNAVAILABLE when the connection is lost and does not come back, MNS_E_DENIED when our key is let in no more. */
MnsStatus wire_receive(Wire *wire, double deadline, Frames *ret, MnsError *error);

/* Receive all frames of one message from a socket that has one. Frames beyond the limit are dropped. @return false:
 * none. */
bool frames_receive(Frames *frames, void *socket);

void frames_done(Frames *frames);

#endif
