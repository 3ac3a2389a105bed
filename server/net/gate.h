/* SPDX-License-Identifier: BSD-3-Clause */
/* The gate: a process of its own, through which all that comes from afar must go. It takes connections, knows who has a key, and brings each to the daemon
 * as one of its own. Whatever those from afar can do to it, at worst it ends, and those who have a key connect again and repeat what was not answered:
 * the daemon starts another one and has lost nothing. It is this same program, begun with other words (net/gate_keeper.h). Of one thread, which never
 * waits for it, but in the end. */
#ifndef NET_GATE_H
#define NET_GATE_H

#include "http/traffic.h"
#include "net/endpoint.h"

typedef struct Gate Gate;

/* Listen at the addresses for those from afar. MNS_E_IO, MNS_E_MEMORY. */
MnsStatus gate_new(const Endpoint *at, Gate **ret, MnsError *error);

/* Let it carry what is under way, for a second at most; end it. NULL is fine here and below: there is none. */
void gate_free(Gate *gate);

/* Where to wait for news of it: a file descriptor, or -1. */
int gate_line(const Gate *gate);

/* Take the news; start it if there is none. Returns when that should be done again, whatever comes (clock_now()); INFINITY: there is no need. */
double gate_look(Gate *gate, Traffic *traffic);

/* A key is gone: end all connections from afar. Another gate comes at once. */
void gate_renew(Gate *gate);

/* Those who listen to telemetry from afar. */
long gate_listeners(const Gate *gate);

/* --- between the two -------------------------------------------------------------------------------------------------------- */

/* The first word of the program that is to be the gate; then come the log level, the directory of keys, and three addresses of the daemon. */
#define GATE_WORD "--gate"
enum { GATE_WORDS = 7 };

/* The variable of its environment with the quotas that are not the default, each with a space behind it. */
#define GATE_QUOTAS "MENISCUS_GATE_QUOTAS"

/* Descriptors that it begins with: a line to the daemon, and what listens. */
enum { GATE_LINE = 3, GATE_CONTROL, GATE_TELEMETRY, GATE_DATA, GATE_REST };

/* Begins the word by which the daemon's telemetry socket learns that somebody subscribes from afar; the topic follows, as in a subscription. */
enum { GATE_LISTENER = 2 };

/* It says so this often at least, as a sign of life [s]. */
#define GATE_SIGN 0.5

/* What it says of itself, each time all of it. */
typedef struct GateNews {
    uint64_t failures[TRAFFIC_FAILURES]; /* handshakes at the control socket, by why, since it began */
    uint64_t shown_out;                  /* connections, since it began                              */
    int64_t listeners;                   /* connections to the telemetry socket                      */
} GateNews;

#endif
