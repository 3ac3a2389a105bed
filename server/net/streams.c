/* SPDX-License-Identifier: BSD-3-Clause */
/* The data socket and its thread. */
#include "net/streams_inside.h"

#include "base/clock.h"
#include "base/log.h"
#include "common/wire/frame.h"
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

enum { ROUNDS = 8, TICK_MS = 200, FAREWELL_MS = 200 };

static void set(void *socket, int option, int value)
{
    zmq_setsockopt(socket, option, &value, sizeof value);
}

static MnsStatus bind_one(void *socket, const char *address, MnsError *error)
{
    if (!address[0] || !zmq_bind(socket, address)) return MNS_OK;
    return mns_fail(error, MNS_E_IO, "cannot listen at %s: %s", address, zmq_strerror(zmq_errno()));
}

/* Any number of ends may wait to be noted: none is told twice. */
static MnsStatus watch_socket(Streams *streams, MnsError *error)
{
    static const char address[] = "inproc://takers";
    void *monitor = streams->monitor = zmq_socket(streams->options.context, ZMQ_PAIR);
    if (monitor) set(monitor, ZMQ_LINGER, 0);
    if (monitor) set(monitor, ZMQ_RCVHWM, 0);
    if (monitor && !zmq_socket_monitor(streams->socket, address, ZMQ_EVENT_DISCONNECTED) &&
        !zmq_connect(monitor, address))
        return MNS_OK;
    return mns_fail(error, MNS_E_MEMORY, "cannot watch the data socket: %s", zmq_strerror(zmq_errno()));
}

static void close_sockets(Streams *streams, int linger)
{
    if (streams->monitor) zmq_socket_monitor(streams->socket, NULL, 0);
    if (streams->monitor) zmq_close(streams->monitor);
    if (!streams->socket) return;
    set(streams->socket, ZMQ_LINGER, linger);
    zmq_close(streams->socket);
}

/* The queues of ZeroMQ count messages; bytes are counted by stream_post.c, and so few messages are under way. */
static MnsStatus open_socket(Streams *streams, MnsError *error)
{
    const StreamsOptions *options = &streams->options;
    const Endpoint *at = options->at;
    const int64_t largest = FRAME_TAKEN;
    void *socket = streams->socket = zmq_socket(options->context, ZMQ_ROUTER);
    if (!socket) return mns_fail(error, MNS_E_MEMORY, "cannot make the data socket: %s", zmq_strerror(zmq_errno()));
    const MnsStatus watched = watch_socket(streams, error);
    if (watched) return watched;
    set(socket, ZMQ_LINGER, 0);
    set(socket, ZMQ_HEARTBEAT_IVL, 2000);
    set(socket, ZMQ_HEARTBEAT_TIMEOUT, 6000);
    set(socket, ZMQ_ROUTER_MANDATORY, 1);
    set(socket, ZMQ_SNDHWM, 0);
    set(socket, ZMQ_RCVHWM, 0); /* see net/pace.h */
    zmq_setsockopt(socket, ZMQ_MAXMSGSIZE, &largest, sizeof largest);
    access_guard_local(options->access, socket);
    const mode_t mask = umask(0177);
    MnsStatus status = bind_one(socket, at->data, error);
    if (!status) status = bind_one(socket, at->tcp_data, error);
    if (!status && at->far_data[0]) {
        access_guard_gate(options->access, socket);
        status = bind_one(socket, at->gate_data, error);
    }
    umask(mask);
    return status;
}

static void look_around(Streams *streams)
{
    eventfd_t count;
    eventfd_read(streams->wake, &count);
    eventfd_read(streams->post.wake, &count);
    tap_woken(run_tap(streams->options.run));
}

static void wait_for_news(Streams *streams, bool busy)
{
    const double due = pace_due(&streams->pace) - clock_now(), tick_s = 1e-3 * TICK_MS;
    const long tick = due < tick_s ? (long)(1e3 * fmax(due, 0)) + 1 : TICK_MS;
    zmq_pollitem_t items[] = {{.socket = streams->socket, .events = ZMQ_POLLIN},
                              {.fd = streams->wake, .events = ZMQ_POLLIN},
                              {.fd = streams->post.wake, .events = ZMQ_POLLIN},
                              {.fd = tap_wake(run_tap(streams->options.run)), .events = ZMQ_POLLIN},
                              {.socket = streams->monitor, .events = ZMQ_POLLIN}};
    zmq_poll(items, 5, busy ? 0 : tick);
}

static void note_traffic(Streams *streams)
{
    StreamTraffic *traffic = streams->options.traffic;
    const TapTally *tally = tap_tally(run_tap(streams->options.run));
    traffic->memory = streams->memory;
    traffic->copies = tally->bytes;
    traffic->without_room = tally->without_room;
}

static void *streams_thread(void *arg)
{
    Streams *streams = arg;
    MnsError leaving;
    bool busy = false;
    pthread_setname_np(pthread_self(), "streams");
    while (!streams->leaving) {
        wait_for_news(streams, busy);
        look_around(streams);
        streams_see_off(streams);
        streams_receive(streams);
        streams_refresh(streams);
        busy = true;
        for (int k = 0; k < ROUNDS && busy; k++) busy = streams_pump(streams);
        note_traffic(streams);
    }
    mns_fail(&leaving, MNS_E_UNAVAILABLE, "the daemon is leaving");
    while (streams->first) streams_drop(streams, streams->first, &leaving);
    return NULL;
}

MnsStatus streams_new(const StreamsOptions *options, Streams **ret, MnsError *error)
{
    Streams *streams = calloc(1, sizeof *streams);
    if (!streams) return mns_fail(error, MNS_E_MEMORY, "no memory for streams");
    streams->options = *options;
    streams->limit = tap_limit(run_tap(options->run));
    pthread_mutex_init(&streams->lock, NULL);
    streams->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    streams->post.wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    MnsStatus status = streams->wake < 0 || streams->post.wake < 0
                           ? mns_fail(error, MNS_E_LIMIT, "the operating system refuses an eventfd: %m")
                           : open_socket(streams, error);
    streams->post.socket = streams->socket;
    streams->post.epoch = options->epoch;
    streams->post.limit = streams->limit / 4;
    streams->post.memory = &streams->memory;
    streams->post.traffic = options->traffic;
    tap_case(run_tap(options->run), &streams->now);
    if (!status && pthread_create(&streams->thread, NULL, streams_thread, streams))
        status = mns_fail(error, MNS_E_MEMORY, "the operating system refuses a thread for streams");
    if (!status) {
        *ret = streams;
        return MNS_OK;
    }
    close_sockets(streams, 0);
    streams_free(streams);
    return status;
}

void streams_stop(Streams *streams)
{
    if (!streams || streams->leaving) return;
    streams->leaving = true;
    eventfd_write(streams->wake, 1);
    pthread_join(streams->thread, NULL);
    close_sockets(streams, FAREWELL_MS);
}

void streams_free(Streams *streams)
{
    if (!streams) return;
    stream_item_leave(streams->news);
    document_leave(streams->now.document);
    snapshots_done(&streams->snapshots);
    stream_post_done(&streams->post);
    pace_done(&streams->pace);
    pthread_mutex_destroy(&streams->lock);
    if (streams->wake >= 0) close(streams->wake);
    if (streams->post.wake >= 0) close(streams->post.wake);
    free(streams);
}

void streams_tell(Streams *streams, const Note *note)
{
    StreamItem *item = stream_item_event(note, &streams->memory);
    streams->steps = run_state_steps(note->state);
    pthread_mutex_lock(&streams->lock);
    if (item) {
        stream_item_leave(streams->news);
        streams->news = item;
    }
    streams->told++;
    pthread_mutex_unlock(&streams->lock);
    eventfd_write(streams->wake, 1);
}
