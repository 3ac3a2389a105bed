/* SPDX-License-Identifier: BSD-3-Clause */
/* Where HTTP is served: an address and a port. Which hosts are this machine. */
#ifndef COMMON_WIRE_ADDRESS_H
#define COMMON_WIRE_ADDRESS_H

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

enum { ADDRESS_HOST = 64 };

/* This machine by one of the names that every machine has, as "LOCALHOST" and "localhost.": its address in digits, in brackets where it is of IPv6.
 * NULL: no such name. */
const char *address_of_localhost(const char *name);

/* Does a host stand for all addresses of a machine, as the star and 0.0.0.0 do in each of their spellings? One can listen there, and connect nowhere. */
bool address_is_all(const char *host);

/* The same of numbers that only this machine reaches: all of 127.0.0.0/8, also in fewer parts ("127.1") or within IPv6 ("[::ffff:127.0.0.1]"), and
 * "[::1]". False: it is no such number. */
bool address_of_near_number(const char *host, char ret[static ADDRESS_HOST]);

/* Either, and the machine's own name where that means loopback: this asks the resolver, so what comes of it is what must be connected to. As near_host() of
 * client/python/src/meniscus/endpoint.py. */
bool address_of_near(const char *host, char ret[static ADDRESS_HOST]);

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
