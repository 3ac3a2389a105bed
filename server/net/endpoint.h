/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a daemon listens: its own directory, locked, with three sockets that only its user can open, and three more for its gate; loopback TCP;
 * and, for those who have a key, any address. */
#ifndef NET_ENDPOINT_H
#define NET_ENDPOINT_H

#include "common/wire/keys.h"

enum { ENDPOINT_SIZE = 160 };

typedef struct Endpoint {
    char control[ENDPOINT_SIZE], telemetry[ENDPOINT_SIZE], data[ENDPOINT_SIZE]; /* "ipc://..." */
    char tcp_control[ENDPOINT_SIZE], tcp_telemetry[ENDPOINT_SIZE],
        tcp_data[ENDPOINT_SIZE]; /* "tcp://127.0.0.1:..."; or empty    */
    char far_control[ENDPOINT_SIZE], far_telemetry[ENDPOINT_SIZE],
        far_data[ENDPOINT_SIZE]; /* "tcp://ADDRESS:...", with keys; or empty */
    char gate_control[ENDPOINT_SIZE], gate_telemetry[ENDPOINT_SIZE],
        gate_data[ENDPOINT_SIZE]; /* "ipc://...", where the gate brings those in */
    char keys[KEYS_PATH];         /* their directory; or empty */
    char directory[ENDPOINT_SIZE];
    int lock; /* file descriptor */
} Endpoint;

/* What the command line says of it. */
typedef struct EndpointOptions {
    const char *name; /* of the daemon */
    const char *
        tcp; /* NULL, "PORT" or "127.0.0.1:PORT": commands there, telemetry and data at the two ports after it, for whoever is on this machine */
    const char *
        listen; /* NULL, or "tcp://ADDRESS:PORT": the same for those who have a key, at an address of this machine or all (*) */
    const char *keys; /* directory of the keys; NULL: where a user keeps them. See common/wire/keys.h */
} EndpointOptions;

/* Find and make the directory of the daemon `name`: $RUNTIME_DIRECTORY (of systemd), $XDG_RUNTIME_DIR/meniscus/NAME or
 * /tmp/meniscus-UID/NAME; lock it; remove sockets left behind. MNS_E_INVALID; MNS_E_LIMIT if the path is too long for a socket;
 * MNS_E_STATE if a daemon of that name is running, and is not about to leave; MNS_E_IO. */
MnsStatus endpoint_open(const EndpointOptions *options, Endpoint *ret, MnsError *error);

/* Let who starts the next daemon of this name wait for us instead of being refused. */
void endpoint_leave(const Endpoint *endpoint);

/* Remove the sockets and let go of the lock. */
void endpoint_close(Endpoint *endpoint);

#endif
