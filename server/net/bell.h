/* SPDX-License-Identifier: BSD-3-Clause */
/* Which sockets of ZeroMQ have something, asked for with as few calls as can be: to ask a socket is two system calls, and an idle one need not be, as
 * its descriptor rings when something comes. Of a socket that rings all is taken, until there is no more; or it is left ringing. */
#ifndef NET_BELL_H
#define NET_BELL_H

#include <stdbool.h>

typedef struct Bell {
    void *socket; /* borrowed */
    int fd;
    bool rings; /* something may be there */
} Bell;

/* It rings at first, for what may have come before. */
void bell_init(Bell *bell, void *socket);

/* Before anybody waits for its descriptor: a socket by which something was sent may have taken in what came meanwhile, and the descriptor says
 * nothing of that. */
void bell_ask(Bell *bell);

#endif
