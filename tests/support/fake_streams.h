/* SPDX-License-Identifier: BSD-3-Clause */
/* The data socket of a daemon that sends what a test tells it to, beside a fake daemon. */
#ifndef SUPPORT_FAKE_STREAMS_H
#define SUPPORT_FAKE_STREAMS_H

#include "stream.pb-c.h"
#include "tests/support/fake_daemon.h"
#include <meniscus/stream.h>
#include <stdbool.h>

typedef struct FakeStreams FakeStreams;

/* Called on its thread for each request. */
typedef void FakeStreamHandler(void *arg, FakeStreams *streams, const Meniscus__StreamRequest *request);

FakeStreams *fake_streams_new(const FakeDaemon *daemon, FakeStreamHandler *handler, void *arg);
void fake_streams_free(FakeStreams *streams);

/* To whoever sent the request last. From the handler. */
void fake_streams_reply(FakeStreams *streams, const Meniscus__StreamRequest *request, Meniscus__StreamReply *reply);
void fake_streams_reply_without_code(FakeStreams *streams, const Meniscus__StreamRequest *request);
void fake_streams_send(FakeStreams *streams, Meniscus__StreamItem *item, const void *bytes, size_t size);

/* Bytes that are no message. */
void fake_streams_garbage(FakeStreams *streams);

/* Close the socket when the handler returns, and bind it anew. */
void fake_streams_disconnect(FakeStreams *streams);

/* Such a daemon, whose control socket answers nothing but `status`, and a client of it. */
typedef struct StreamStand {
    FakeDaemon *daemon;
    FakeStreams *streams;
    MnsClient *client;
} StreamStand;

/* 0, or -1 if the client cannot connect; what is begun is to be ended in any case. */
int stream_stand_begin(StreamStand *stand, FakeStreamHandler *handler, void *arg);
void stream_stand_end(const StreamStand *stand);

/* Take a stream: of this field, or where it is none of fields, of all there is. Fails the test. */
MnsStream *stream_stand_take(const StreamStand *stand, MnsStreamKind kind, const char *field, size_t memory);

#endif
