/* SPDX-License-Identifier: BSD-3-Clause */
/* How many connections the process takes, so that open files are left for the run and for commands. */
#ifndef NET_CROWD_H
#define NET_CROWD_H

#include "net/endpoint.h"

/* Keep some of the open files back from here on: connections beyond are closed at once, wherever a library accepts them. The last of those that
 * are taken are for the sockets of commands.
 *  at    borrowed as long as any socket listens; NULL: no socket is for commands alone
 *  most  files that the process may open */
void crowd_begin(const Endpoint *at, int most);

#endif
