/* SPDX-License-Identifier: BSD-3-Clause */
/* How many connections the process takes, so that open files are left for the run and for commands. */
#ifndef NET_CROWD_H
#define NET_CROWD_H

#include "net/endpoint.h"

/* Keep some of the open files back from here on, wherever a library accepts connections: some for the run, some for HTTP, some for commands. Beyond
 * the places of its kind a connection takes that of another (see net/peers.h), or is closed at once.
 *  at    borrowed as long as any socket listens; NULL: connections are only counted, and none ends for another
 *  most  files that the process may open */
void crowd_begin(const Endpoint *at, int most);

#endif
