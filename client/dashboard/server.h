/* SPDX-License-Identifier: BSD-3-Clause */
/* The thread that serves browsers: files over HTTP, everything else over one WebSocket each. The only part that knows libwebsockets. */
#ifndef DASHBOARD_SERVER_H
#define DASHBOARD_SERVER_H

#include "client/dashboard/hub.h"
#include "common/wire/address.h"
#include "common/wire/guard.h"
#include "common/wire/token.h"

typedef struct ServerOptions {
    Address address;
    Token token; /* "": nobody is asked for one */
    Guard guard;
} ServerOptions;

/* Listen, then call started(arg, port, error), and unless that fails serve until server_stop(). MNS_E_IO: nobody can listen there;
 * MNS_E_INTERNAL: the library has given up. */
MnsStatus server_run(Hub *hub, const ServerOptions *options, MnsStatus (*started)(void *arg, int port, MnsError *error),
                     void *arg, MnsError *error);

/* End server_run(); safe in a signal handler. */
void server_stop(void);

#endif
