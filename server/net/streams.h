/* SPDX-License-Identifier: BSD-3-Clause */
/* The data socket and its thread: streams of values, fields, series and files, each at the pace of who takes it. So neither the desk nor the solver ever
 * waits for packing or sending:
 *
 *   step boundary -> run/tap: one copy -> net/selection: what of it -> proto/packing -> net/stream_post: messages, as far as there is credit -> socket */
#ifndef NET_STREAMS_H
#define NET_STREAMS_H

#include "http/traffic.h"
#include "net/access.h"
#include "net/endpoint.h"
#include "run/run.h"

typedef struct Streams Streams;

typedef struct StreamsOptions {
    void *context;
    Access *access;
    const Endpoint *at;
    Run *run;
    uint64_t epoch;
    StreamTraffic *traffic;
} StreamsOptions;

/* Bind the socket and start the thread. Items may take as much memory as the copies they are made of. MNS_E_IO, MNS_E_MEMORY. */
MnsStatus streams_new(const StreamsOptions *options, Streams **ret, MnsError *error);

/* Tell who listens, end the thread and close the socket, before the context of ZeroMQ is ended; NULL is fine. */
void streams_stop(Streams *streams);

/* After it is ended: ZeroMQ may have given back bytes until then. */
void streams_free(Streams *streams);

/* --- for any thread ---------------------------------------------------------------------------------------------------- */

/* An event of the run. */
void streams_tell(Streams *streams, const Note *note);

#endif
