/* SPDX-License-Identifier: BSD-3-Clause */
/* What goes over the sockets of the control plane, counted by the thread of the socket concerned for any other to look at. */
#ifndef HTTP_TRAFFIC_H
#define HTTP_TRAFFIC_H

#include <stddef.h>
#include <stdint.h>

/* Topics of the telemetry. */
enum { TRAFFIC_EVENT, TRAFFIC_LOG, TRAFFIC_PROGRESS, TRAFFIC_PROBE, TRAFFIC_TOPICS };

enum { TRAFFIC_ROLES = 3, TRAFFIC_FAILURES = 3, TRAFFIC_STREAMS = 5 };

typedef struct TopicTraffic {
    const char *name;                 /* set before there is any other thread */
    _Atomic uint64_t messages, bytes; /* published */
    _Atomic uint64_t thinned;         /* left out, as very many listen and a newer one came */
} TopicTraffic;

/* Of streams, by what they have: probes, fields, events, series, snapshots. Counted by their thread. */
typedef struct StreamTraffic {
    _Atomic uint64_t items[TRAFFIC_STREAMS], bytes[TRAFFIC_STREAMS]; /* sent whole; sent, with what is said of them */
    _Atomic uint64_t skipped[TRAFFIC_STREAMS], cancelled[TRAFFIC_STREAMS];
    _Atomic uint64_t open[TRAFFIC_STREAMS]; /* streams */
    _Atomic uint64_t packed;                /* items, each once for all who get it */
    _Atomic uint64_t too_slow;     /* items given up for want of memory, under way to those who did not take them */
    _Atomic uint64_t let_go;       /* items that waited for those who had no credit, and made room for others */
    _Atomic uint64_t not_made;     /* items that were due and for which there was no memory */
    _Atomic uint64_t refused;      /* requests */
    _Atomic uint64_t unheard;      /* requests of those who do not read the replies */
    _Atomic size_t memory;         /* bytes of items, whether they wait or are on their way */
    _Atomic size_t copies;         /* bytes of room for copies of fields, of which items are made */
    _Atomic uint64_t without_room; /* step boundaries at which something was due and all that room was in use */
} StreamTraffic;

typedef struct Traffic {
    _Atomic long clients, listeners;    /* connections to the control socket, and to that of telemetry */
    _Atomic uint64_t requests, refused; /* requests; of those and of the answers since, the ones that failed */
    _Atomic size_t unread;              /* bytes of replies that clients have not taken */
    TopicTraffic topics[TRAFFIC_TOPICS];
    StreamTraffic streams;

    _Atomic size_t keys[TRAFFIC_ROLES]; /* that are let in from afar: of viewers, operators, admins */
    _Atomic uint64_t denied;            /* requests that the role of their key may not make         */
    /* Connections to the control socket that ended before the handshake did: their key is not let in; they did not speak as they
     * must; they fell silent or hung up. */
    _Atomic uint64_t failures[TRAFFIC_FAILURES];
    _Atomic uint64_t gate_failures[TRAFFIC_FAILURES]; /* those from afar           */
    _Atomic uint64_t gate_restarts;                   /* of the gate, that it was not told to end */
    _Atomic uint64_t shown_out;                       /* connections from afar that the gate has ended */
} Traffic;

#endif
