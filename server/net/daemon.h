/* SPDX-License-Identifier: BSD-3-Clause */
/* The daemon: a run, a desk, signals and the service manager, wired together. */
#ifndef NET_DAEMON_H
#define NET_DAEMON_H

#include "http/http.h"
#include "net/endpoint.h"

typedef struct DaemonOptions {
    EndpointOptions at;    /* its name, by which its sockets are found, and where else it listens */
    const char *state_dir; /* run directories go there; NULL: where users keep state */
    HttpOptions http;      /* where metrics are served, or not                     */
    size_t stream_memory;  /* bytes that streams may hold: half are copies of fields, half items made of them */
    int threads;           /* for cases that do not say; -1: their default        */
    const char *load;      /* case to load at the start, or NULL                   */
    size_t n_settings;
    char **settings; /* [n_settings] changes to it, "resolution=40"          */
    bool resume;     /* it goes on from its newest whole checkpoint          */
    bool start;      /* and is set in motion                                 */
} DaemonOptions;

/* Serve until told to leave. Returns an exit code of <meniscus/exit.h>. Must be called before any thread is started. */
int daemon_run(const DaemonOptions *options);

#endif
