/* SPDX-License-Identifier: BSD-3-Clause */
/* How many connections a socket has, as its monitor tells. A client that hangs up has read what it wanted to read. */
#ifndef NET_VISITORS_H
#define NET_VISITORS_H

#include <meniscus/status.h>
#include <stdint.h>

/* Why a connection ended before its handshake did: its key is not let in; it did not speak as it must; it fell silent or hung up. */
typedef enum Failure { FAILED_KEY, FAILED_PROTOCOL, FAILED_SILENCE, FAILURES } Failure;

typedef struct Visitors {
    void *socket, *monitor;    /* both NULL before visitors_init() */
    const char *aside;         /* an address whose connections are not counted; or NULL */
    long n;                    /* connections that are open */
    uint64_t failed[FAILURES]; /* since the beginning              */
} Visitors;

/* Begin to count, before the socket is bound. address: "inproc://NAME", of its own in the context. aside: borrowed, see above. MNS_E_MEMORY. */
MnsStatus visitors_init(Visitors *visitors, void *context, void *socket, const char *address, const char *aside,
                        MnsError *error);

/* Before the socket is closed. */
void visitors_done(Visitors *visitors);

/* Take note of all who came and went; must be called whenever the monitor is readable, or it would stop the sockets. */
void visitors_note(Visitors *visitors);

/* Wait until all have hung up, but no longer than so many milliseconds. */
void visitors_see_off(Visitors *visitors, long milliseconds);

#endif
