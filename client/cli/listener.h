/* SPDX-License-Identifier: BSD-3-Clause */
/* Sockets of daemons on this machine, seen from outside: without a word to the daemon. */
#ifndef CLI_LISTENER_H
#define CLI_LISTENER_H

#include <stdbool.h>

/* An ipc:// endpoint whose socket is there, or was, and at which nobody listens. */
bool listener_is_gone(const char *endpoint);

/* How many connections an ipc:// endpoint has, ours among them; -1 if that is not known. */
long listener_visitors(const char *endpoint);

#endif
