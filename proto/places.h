/* SPDX-License-Identifier: BSD-3-Clause */
/* Where daemons of this user are and keep their files if nobody says otherwise: for the daemon, and for who looks after it. */
#ifndef PROTO_PLACES_H
#define PROTO_PLACES_H

#include <stddef.h>

/* The directory that holds one directory of sockets per daemon: $XDG_RUNTIME_DIR/meniscus or /tmp/meniscus-UID. */
void places_sockets(char *ret, size_t size);

/* Where a daemon's runs keep their files: $STATE_DIRECTORY, $XDG_STATE_HOME/meniscus/NAME, $HOME/.local/state/meniscus/NAME or
 * ./meniscus-NAME. */
void places_state(const char *name, char *ret, size_t size);

#endif
