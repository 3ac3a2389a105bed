/* SPDX-License-Identifier: BSD-3-Clause */
/* The data socket of a fake daemon, on a thread of its own. */
#include "tests/support/fake_streams.h"

#include "tests/support/check.h"
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zmq.h>

struct FakeStreams {
    char endpoint[96];
    void *context, *router;
    pthread_t thread;
    atomic_bool stop;
    bool disconnect;
    uint8_t peer[256];
    size_t peer_size;
    FakeStreamHandler *handler;
    void *arg;
};

enum { POLL_MS = 10 };

static void bind_router(FakeStreams *streams)
{
    static const int none = 0;
    streams->router = zmq_socket(streams->context, ZMQ_ROUTER);
    zmq_setsockopt(streams->router, ZMQ_LINGER, &none, sizeof none);
    zmq_setsockopt(streams->router, ZMQ_SNDHWM, &none, sizeof none); /* nothing is dropped */
    if (zmq_bind(streams->router, streams->endpoint) != 0) abort();
}

static void post(FakeStreams *streams, const Meniscus__StreamMessage *message, const void *bytes, size_t size)
{
    const size_t length = meniscus__stream_message__get_packed_size(message);
    uint8_t *packed = malloc(length + 1);
    meniscus__stream_message__pack(message, packed);
    zmq_send(streams->router, streams->peer, streams->peer_size, ZMQ_SNDMORE);
    zmq_send(streams->router, packed, length, bytes ? ZMQ_SNDMORE : 0);
    if (bytes) zmq_send(streams->router, bytes, size, 0);
    free(packed);
}

static void post_reply(FakeStreams *streams, const Meniscus__StreamRequest *request, Meniscus__StreamReply *reply)
{
    Meniscus__StreamMessage message = MENISCUS__STREAM_MESSAGE__INIT;
    reply->has_id = true;
    reply->id = request->id;
    message.what_case = MENISCUS__STREAM_MESSAGE__WHAT_REPLY;
    message.reply = reply;
    post(streams, &message, NULL, 0);
}

void fake_streams_reply(FakeStreams *streams, const Meniscus__StreamRequest *request, Meniscus__StreamReply *reply)
{
    reply->has_code = true;
    post_reply(streams, request, reply);
}

void fake_streams_reply_without_code(FakeStreams *streams, const Meniscus__StreamRequest *request)
{
    post_reply(streams, request, &(Meniscus__StreamReply)MENISCUS__STREAM_REPLY__INIT);
}

void fake_streams_send(FakeStreams *streams, Meniscus__StreamItem *item, const void *bytes, size_t size)
{
    Meniscus__StreamMessage message = MENISCUS__STREAM_MESSAGE__INIT;
    item->has_stream = item->has_sequence = item->has_offset = item->has_size = true;
    message.what_case = MENISCUS__STREAM_MESSAGE__WHAT_ITEM;
    message.item = item;
    post(streams, &message, bytes, size);
}

void fake_streams_garbage(FakeStreams *streams)
{
    static const char garbage[] = "\xff\xff\xff no message";
    zmq_send(streams->router, streams->peer, streams->peer_size, ZMQ_SNDMORE);
    zmq_send(streams->router, garbage, sizeof garbage, 0);
}

void fake_streams_disconnect(FakeStreams *streams)
{
    streams->disconnect = true;
}

static void serve(FakeStreams *streams)
{
    zmq_msg_t body;
    const int size = zmq_recv(streams->router, streams->peer, sizeof streams->peer, 0);
    zmq_msg_init(&body);
    if (size > 0 && zmq_msg_recv(&body, streams->router, 0) >= 0) {
        streams->peer_size = (size_t)size;
        Meniscus__StreamRequest *request =
            meniscus__stream_request__unpack(NULL, zmq_msg_size(&body), zmq_msg_data(&body));
        if (request) streams->handler(streams->arg, streams, request);
        if (request) meniscus__stream_request__free_unpacked(request, NULL);
    }
    zmq_msg_close(&body);
}

static void *live(void *arg)
{
    FakeStreams *streams = arg;
    while (!atomic_load(&streams->stop)) {
        zmq_pollitem_t item = {.socket = streams->router, .events = ZMQ_POLLIN};
        if (zmq_poll(&item, 1, POLL_MS) <= 0) continue;
        serve(streams);
        if (!streams->disconnect) continue;
        streams->disconnect = false;
        usleep(50000); /* for what was sent to get there */
        zmq_close(streams->router);
        usleep(50000);
        bind_router(streams);
    }
    zmq_close(streams->router);
    return NULL;
}

FakeStreams *fake_streams_new(const FakeDaemon *daemon, FakeStreamHandler *handler, void *arg)
{
    FakeStreams *streams = calloc(1, sizeof *streams);
    const char *control = fake_daemon_endpoint(daemon);
    snprintf(streams->endpoint, sizeof streams->endpoint, "%.*s/data.ipc", (int)(strrchr(control, '/') - control),
             control);
    streams->context = zmq_ctx_new();
    streams->handler = handler;
    streams->arg = arg;
    bind_router(streams);
    pthread_create(&streams->thread, NULL, live, streams);
    return streams;
}

void fake_streams_free(FakeStreams *streams)
{
    atomic_store(&streams->stop, true);
    pthread_join(streams->thread, NULL);
    zmq_ctx_term(streams->context);
    unlink(streams->endpoint + strlen("ipc://"));
    free(streams);
}

static void answer_nothing(void *arg, const Meniscus__Request *request, FakeAnswer *answer)
{
    (void)arg, (void)request, (void)answer;
}

int stream_stand_begin(StreamStand *stand, FakeStreamHandler *handler, void *arg)
{
    stand->daemon = fake_daemon_new(answer_nothing, NULL);
    stand->streams = fake_streams_new(stand->daemon, handler, arg);
    return mns_client_open(fake_daemon_endpoint(stand->daemon), &stand->client, NULL) == MNS_OK ? 0 : -1;
}

void stream_stand_end(const StreamStand *stand)
{
    mns_client_close(stand->client);
    fake_streams_free(stand->streams);
    fake_daemon_free(stand->daemon);
}

MnsStream *stream_stand_take(const StreamStand *stand, MnsStreamKind kind, const char *field, size_t memory)
{
    const MnsStreamOptions options = {
        .kind = kind, .n_names = kind == MNS_STREAM_FIELDS, .names = &field, .memory = memory};
    MnsStream *stream = NULL;
    MnsError error = {0};
    if (mns_stream_open(stand->client, &options, &stream, &error)) fail_msg("%s", error.text);
    return stream;
}
