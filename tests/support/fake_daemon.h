/* SPDX-License-Identifier: BSD-3-Clause */
/* A daemon that answers as a test tells it to: refuses, stays silent, loses the connection, sends damaged arrays. */
#ifndef SUPPORT_FAKE_DAEMON_H
#define SUPPORT_FAKE_DAEMON_H

#include "meniscus.pb-c.h"
#include <stddef.h>

typedef struct FakeDaemon FakeDaemon;

typedef enum FakeManner {
    FAKE_ANSWER,
    FAKE_GARBAGE,    /* bytes that are no reply                              */
    FAKE_EMPTY,      /* a frame of no bytes, which reads as a reply          */
    FAKE_SILENCE,    /* no answer, ever                                      */
    FAKE_DISCONNECT, /* no answer; the sockets are closed and bound again    */
    FAKE_STALE_FIRST /* an answer to another request, then the right one     */
} FakeManner;

/* What goes back. The reply has the id of the request and, if not set otherwise, code OK and the daemon's epoch. */
typedef struct FakeAnswer {
    FakeManner manner;
    Meniscus__Reply *reply;
    const void *frame; /* raw array behind the reply; NULL: none */
    size_t frame_size;
} FakeAnswer;

/* Called on the daemon's thread for each request but `status`, which clients greet with and which is always
 * answered: see fake_daemon_set_status(). */
typedef void FakeHandler(void *arg, const Meniscus__Request *request, FakeAnswer *answer);

/* Listen at DIR/control.ipc and DIR/telemetry.ipc in a directory of its own; its name as for --daemon is ipc://..., see
 * fake_daemon_endpoint(). arg must be safe to use from another thread. */
FakeDaemon *fake_daemon_new(FakeHandler *handler, void *arg);

const char *fake_daemon_endpoint(const FakeDaemon *daemon);

/* From now on it is another process. */
void fake_daemon_set_epoch(FakeDaemon *daemon, uint64_t epoch);

/* What is answered to `status` from now on; borrowed. NULL, as at first: that there is somebody, and nothing else. */
void fake_daemon_set_status(FakeDaemon *daemon, Meniscus__Status *status);

/* Publish, from the thread that made the daemon. */
void fake_daemon_publish(FakeDaemon *daemon, const char *topic, const Meniscus__Telemetry *message);

/* Publish bytes that are no message. */
void fake_daemon_publish_bytes(FakeDaemon *daemon, const char *topic, const void *data, size_t size);

/* Wait until somebody has subscribed to n topics. */
void fake_daemon_await_subscribers(FakeDaemon *daemon, int n);

void fake_daemon_free(FakeDaemon *daemon);

#endif
