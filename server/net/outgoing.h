/* SPDX-License-Identifier: BSD-3-Clause */
/* Replies on their way out: whole or not at all, never waiting for who shall read them. Their bytes are counted until ZeroMQ lets go
 * of them. For when there is no memory for a reply, one is kept in reserve that needs none. */
#ifndef NET_OUTGOING_H
#define NET_OUTGOING_H

#include "net/exchange.h"

/* Bytes that clients have not taken: beyond this no more large replies are begun, beyond twice that, nothing is sent. */
enum { OUTGOING_UNREAD = 128 << 20, OUTGOING_PARTS = 1 + EXCHANGE_ARRAYS };

typedef struct Outgoing {
    void *socket;          /* a ROUTER of ZeroMQ, borrowed */
    _Atomic size_t unread; /* [bytes] */
    uint8_t excuse[256];   /* the reply in reserve, packed; begins with room for the id */
    size_t excuse_size, brief_size;
} Outgoing;

/* Where a reply goes: a connection, and the request. */
typedef struct Recipient {
    const uint8_t *identity; /* [identity_size] */
    size_t identity_size;
    const uint8_t *id; /* [ORDER_ID]; NULL if it is not known */
} Recipient;

void outgoing_init(Outgoing *out, void *socket, uint64_t epoch);

/* Send n parts, from malloc; they are taken over. If the first is NULL or there is no memory for another one, what is sent is that there
 * is none. If the client is gone or reads nothing, nothing is sent; asked again, it will be. */
void outgoing_send(Outgoing *out, const Recipient *to, size_t n, void *const parts[], const size_t sizes[]);

#endif
