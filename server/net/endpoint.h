/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a daemon listens: its own directory, locked, with two sockets that only its user can open; and loopback TCP. */
#ifndef NET_ENDPOINT_H
#define NET_ENDPOINT_H

#include <meniscus/status.h>

enum { ENDPOINT_SIZE = 160 };

typedef struct Endpoint {
    char control[ENDPOINT_SIZE], telemetry[ENDPOINT_SIZE];         /* "ipc://..."                        */
    char tcp_control[ENDPOINT_SIZE], tcp_telemetry[ENDPOINT_SIZE]; /* "tcp://127.0.0.1:..."; or empty    */
    char directory[ENDPOINT_SIZE];
    int lock; /* file descriptor */
} Endpoint;

/* Find and make the directory of the daemon `name`: $RUNTIME_DIRECTORY (of systemd), $XDG_RUNTIME_DIR/meniscus/NAME or
 * /tmp/meniscus-UID/NAME; lock it; remove sockets left behind.
 *  tcp  NULL, "PORT" or "127.0.0.1:PORT": commands there, telemetry at the next port
 * MNS_E_INVALID; MNS_E_LIMIT if the path is too long for a socket; MNS_E_STATE if a daemon of that name is running; MNS_E_IO. */
MnsStatus endpoint_open(const char *name, const char *tcp, Endpoint *ret, MnsError *error);

/* Remove the sockets and let go of the lock. */
void endpoint_close(Endpoint *endpoint);

#endif
