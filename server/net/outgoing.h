/* SPDX-License-Identifier: BSD-3-Clause */
/* Replies on their way out: whole or not at all, never waiting for who shall read them. Their bytes are counted for each connection until ZeroMQ lets go
 * of them. For when there is no memory for a reply, one is kept in reserve that needs none. */
#ifndef NET_OUTGOING_H
#define NET_OUTGOING_H

#include "net/exchange.h"

/* Bytes that one connection has not read. Beyond this, or the shares of its key and role (QUOTA_UNREAD), it gets no more large replies; beyond twice that, none. */
enum { OUTGOING_UNREAD = 32 << 20, OUTGOING_PARTS = 1 + EXCHANGE_ARRAYS };

typedef struct OutgoingAccount OutgoingAccount;

typedef struct Outgoing {
    void *socket;              /* a ROUTER of ZeroMQ, borrowed */
    OutgoingAccount *accounts; /* of connections with unread replies; those of others are used again */
    uint8_t excuse[256];       /* the reply in reserve, packed; begins with room for the id */
    size_t excuse_size, brief_size;
} Outgoing;

/* Where a reply goes: a connection, and the request. */
typedef struct Recipient {
    const uint8_t *identity; /* [identity_size] */
    size_t identity_size;
    const Who *who;
    const uint8_t *id; /* [ORDER_ID]; NULL if it is not known */
} Recipient;

void outgoing_init(Outgoing *out, void *socket, uint64_t epoch);

/* When ZeroMQ has let go of all. */
void outgoing_done(Outgoing *out);

/* Bytes that clients have not read. */
size_t outgoing_unread(const Outgoing *out);

/* May this connection have one more large reply? MNS_E_LIMIT with a sentence if it, its key or its role has too much unread. */
MnsStatus outgoing_check(const Outgoing *out, const Recipient *to, MnsError *error);

/* Send n parts, from malloc; they are taken over. If the first is NULL or there is no memory for another one, what is sent is that there
 * is none. If the client is gone or reads nothing, nothing is sent; asked again, it will be. Returns true if the client is gone. */
bool outgoing_send(Outgoing *out, const Recipient *to, size_t n, void *const parts[], const size_t sizes[]);

#endif
