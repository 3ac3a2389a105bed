/* SPDX-License-Identifier: BSD-3-Clause */
/* A daemon that answers as a test tells it to, on a thread of its own. */
#include "tests/support/fake_daemon.h"
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zmq.h>

struct FakeDaemon {
    char directory[64], control[96], telemetry[96];
    void *context, *publisher;
    pthread_t thread;
    atomic_bool stop;
    atomic_ullong epoch;
    _Atomic(Meniscus__Status *) status;
    FakeHandler *handler;
    void *arg;
};

enum { POLL_MS = 10 };

static void *bind_socket(FakeDaemon *daemon, int type, const char *endpoint)
{
    const int none = 0;
    void *socket = zmq_socket(daemon->context, type);
    zmq_setsockopt(socket, ZMQ_LINGER, &none, sizeof none);
    if (zmq_bind(socket, endpoint) != 0) {
        fprintf(stderr, "cannot bind %s: %s\n", endpoint, zmq_strerror(zmq_errno()));
        abort();
    }
    return socket;
}

static void send_reply(void *router, zmq_msg_t *peer, const Meniscus__Reply *reply, const FakeAnswer *answer)
{
    const size_t size = meniscus__reply__get_packed_size(reply);
    uint8_t *packed = malloc(size + 1);
    meniscus__reply__pack(reply, packed);
    zmq_send(router, zmq_msg_data(peer), zmq_msg_size(peer), ZMQ_SNDMORE);
    zmq_send(router, packed, size, answer->frame ? ZMQ_SNDMORE : 0);
    if (answer->frame) zmq_send(router, answer->frame, answer->frame_size, 0);
    free(packed);
}

static void send_stale(void *router, zmq_msg_t *peer)
{
    uint8_t id[16] = {1, 2, 3};
    Meniscus__Reply stale = MENISCUS__REPLY__INIT;
    stale.has_id = stale.has_code = true;
    stale.id = (ProtobufCBinaryData){sizeof id, id};
    stale.code = MENISCUS__CODE__INTERNAL;
    send_reply(router, peer, &stale, &(FakeAnswer){0});
}

static FakeManner serve(FakeDaemon *daemon, void *router, zmq_msg_t *peer, const Meniscus__Request *request)
{
    Meniscus__Reply reply = MENISCUS__REPLY__INIT;
    FakeAnswer answer = {.manner = FAKE_ANSWER, .reply = &reply};
    reply.has_id = reply.has_code = reply.has_daemon_epoch = true;
    reply.id = request->id;
    reply.daemon_epoch = atomic_load(&daemon->epoch);
    if (request->command_case != MENISCUS__REQUEST__COMMAND_STATUS) daemon->handler(daemon->arg, request, &answer);
    else if ((reply.status = atomic_load(&daemon->status))) {
        reply.result_case = MENISCUS__REPLY__RESULT_STATUS;
        reply.has_state = reply.status->has_state;
        reply.state = reply.status->state;
        reply.has_case_version = reply.status->has_case_version;
        reply.case_version = reply.status->case_version;
    }
    if (answer.manner == FAKE_STALE_FIRST) send_stale(router, peer);
    if (answer.manner == FAKE_GARBAGE || answer.manner == FAKE_EMPTY) {
        zmq_send(router, zmq_msg_data(peer), zmq_msg_size(peer), ZMQ_SNDMORE);
        zmq_send(router, "\xff\xff\xff\xff", answer.manner == FAKE_EMPTY ? 0 : 4, 0);
    }
    if (answer.manner == FAKE_ANSWER || answer.manner == FAKE_STALE_FIRST)
        send_reply(router, peer, answer.reply, &answer);
    return answer.manner;
}

static FakeManner serve_one(FakeDaemon *daemon, void *router)
{
    zmq_msg_t peer, body;
    FakeManner manner = FAKE_SILENCE;
    zmq_msg_init(&peer);
    zmq_msg_init(&body);
    if (zmq_msg_recv(&peer, router, 0) >= 0 && zmq_msg_recv(&body, router, 0) >= 0) {
        Meniscus__Request *request = meniscus__request__unpack(NULL, zmq_msg_size(&body), zmq_msg_data(&body));
        if (request) manner = serve(daemon, router, &peer, request);
        if (request) meniscus__request__free_unpacked(request, NULL);
    }
    zmq_msg_close(&body);
    zmq_msg_close(&peer);
    return manner;
}

static void *live(void *arg)
{
    FakeDaemon *daemon = arg;
    void *router = bind_socket(daemon, ZMQ_ROUTER, daemon->control);
    while (!atomic_load(&daemon->stop)) {
        zmq_pollitem_t item = {.socket = router, .events = ZMQ_POLLIN};
        if (zmq_poll(&item, 1, POLL_MS) <= 0) continue;
        if (serve_one(daemon, router) != FAKE_DISCONNECT) continue;
        zmq_close(router);
        usleep(50000); /* sockets close in the background */
        router = bind_socket(daemon, ZMQ_ROUTER, daemon->control);
    }
    zmq_close(router);
    return NULL;
}

FakeDaemon *fake_daemon_new(FakeHandler *handler, void *arg)
{
    FakeDaemon *daemon = calloc(1, sizeof *daemon);
    strcpy(daemon->directory, "/tmp/meniscus-fake-XXXXXX");
    if (!mkdtemp(daemon->directory)) abort();
    snprintf(daemon->control, sizeof daemon->control, "ipc://%s/control.ipc", daemon->directory);
    snprintf(daemon->telemetry, sizeof daemon->telemetry, "ipc://%s/telemetry.ipc", daemon->directory);
    daemon->context = zmq_ctx_new();
    daemon->handler = handler;
    daemon->arg = arg;
    atomic_store(&daemon->epoch, 1);
    daemon->publisher = bind_socket(daemon, ZMQ_XPUB, daemon->telemetry);
    pthread_create(&daemon->thread, NULL, live, daemon);
    while (access(daemon->control + strlen("ipc://"), F_OK) != 0) usleep(1000);
    return daemon;
}

const char *fake_daemon_endpoint(const FakeDaemon *daemon)
{
    return daemon->control;
}

void fake_daemon_set_epoch(FakeDaemon *daemon, uint64_t epoch)
{
    atomic_store(&daemon->epoch, epoch);
}

void fake_daemon_set_status(FakeDaemon *daemon, Meniscus__Status *status)
{
    atomic_store(&daemon->status, status);
}

void fake_daemon_publish_bytes(FakeDaemon *daemon, const char *topic, const void *data, size_t size)
{
    zmq_send(daemon->publisher, topic, strlen(topic), ZMQ_SNDMORE);
    zmq_send(daemon->publisher, data, size, 0);
}

void fake_daemon_publish(FakeDaemon *daemon, const char *topic, const Meniscus__Telemetry *message)
{
    const size_t size = meniscus__telemetry__get_packed_size(message);
    uint8_t *packed = malloc(size + 1);
    meniscus__telemetry__pack(message, packed);
    fake_daemon_publish_bytes(daemon, topic, packed, size);
    free(packed);
}

void fake_daemon_await_subscribers(FakeDaemon *daemon, int n)
{
    char subscription[64];
    for (int k = 0; k < n; k++) zmq_recv(daemon->publisher, subscription, sizeof subscription, 0);
}

void fake_daemon_free(FakeDaemon *daemon)
{
    atomic_store(&daemon->stop, true);
    pthread_join(daemon->thread, NULL);
    zmq_close(daemon->publisher);
    zmq_ctx_term(daemon->context);
    unlink(daemon->control + strlen("ipc://"));
    unlink(daemon->telemetry + strlen("ipc://"));
    rmdir(daemon->directory);
    free(daemon);
}
