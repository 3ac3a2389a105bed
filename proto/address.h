/* SPDX-License-Identifier: BSD-3-Clause */
/* Where HTTP is served: an address and a port. */
#ifndef PROTO_ADDRESS_H
#define PROTO_ADDRESS_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <sys/socket.h>

typedef struct Address {
    struct sockaddr_storage where;
    socklen_t size;
    bool loopback; /* only this machine reaches it */
} Address;

/* Read "[ADDRESS:]PORT": a port of 127.0.0.1, or after an IPv4 address, an IPv6 address in brackets, or "localhost"; port 0 is any free one.
 * MNS_E_INVALID. */
MnsStatus address_parse(const char *text, Address *ret, MnsError *error);

/* A socket that listens there. MNS_E_IO. */
MnsStatus address_listen(const Address *address, int *ret_fd, MnsError *error);

/* Write an address with this port as in a URL: "127.0.0.1:9464". */
void address_print(const Address *address, int port, char ret[static 64]);

/* Does only this machine reach it, or call from it? */
bool address_is_loopback(const struct sockaddr *where);

/* Is it all addresses of this machine, "0.0.0.0" or "[::]", which nobody can open? */
bool address_is_any(const Address *address);

/* Write where a socket listens. */
void address_of(int fd, char ret[static 64]);

#endif
