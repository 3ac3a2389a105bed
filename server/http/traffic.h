/* SPDX-License-Identifier: BSD-3-Clause */
/* What goes over the sockets of the control plane, counted by the desk's thread for any other to look at. */
#ifndef HTTP_TRAFFIC_H
#define HTTP_TRAFFIC_H

#include <stddef.h>
#include <stdint.h>

enum { TRAFFIC_TOPICS = 4 };

typedef struct TopicTraffic {
    const char *name;                 /* set before there is any other thread */
    _Atomic uint64_t messages, bytes; /* published */
} TopicTraffic;

typedef struct Traffic {
    _Atomic long clients;               /* connections to the control socket */
    _Atomic uint64_t requests, refused; /* requests; of those and of the answers since, the ones that failed */
    _Atomic size_t unread;              /* bytes of replies that clients have not taken */
    TopicTraffic topics[TRAFFIC_TOPICS];
} Traffic;

#endif
