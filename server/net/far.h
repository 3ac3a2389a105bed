/* SPDX-License-Identifier: BSD-3-Clause */
/* An address for those from afar. ZeroMQ ends no connection of a socket by itself, but those that came through an address end when
 * it is let go of. Who has a key then connects again by itself, and repeats what was not answered. */
#ifndef NET_FAR_H
#define NET_FAR_H

#include "net/access.h"
#include "net/endpoint.h"

enum { FAR_RETRY_MS = 20 };

typedef struct Far {
    void *socket; /* NULL: there is no such address */
    char address[ENDPOINT_SIZE];
    bool bound, told; /* whether it can be bound again, after it was let go */
    double cut;       /* clock_now() of that */
} Far;

/* Bind the socket there, for those who are let in; whatever it binds later too. MNS_E_IO. */
MnsStatus far_bind(Far *far, const Access *access, void *socket, const char *address, MnsError *error);

/* End the connections that came through it. */
void far_cut(Far *far);

/* Is it let go of, and not bound again? Then call far_mend() every FAR_RETRY_MS. */
bool far_is_cut(const Far *far);
void far_mend(Far *far);

#endif
