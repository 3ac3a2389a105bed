/* SPDX-License-Identifier: BSD-3-Clause */
/* One connection to a control socket. A monitor tells when it is made and lost, so that a dead daemon is noticed while
 * a reply may take hours. */
#include "client/lib/wire.h"
#include "common/host/open_files.h"
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum {
    REFUSALS =
        3, /* a tenth of a second apart: where nobody listens then, nobody is about to, as a daemon started just now is */
    CUTS =
        3, /* in a row: where handshakes end so often, it is for what we say, and not for who has just been started anew */
    RECONNECT_S = 5, /* to a daemon that was there: it may be restarted */
    HEARTBEAT_MS = 2000,
    HEARTBEAT_TIMEOUT_MS = 6000,
    RETRY_MS = 100,
    RETRY_MAX_MS = 1000,
    POLL_MAX_MS = 1000
};

double wire_clock(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void set(void *socket, int option, int value)
{
    zmq_setsockopt(socket, option, &value, sizeof value);
}

/* IMMEDIATE: a request is handed to a connection that exists, or we know that there is none. */
static void set_options(void *dealer)
{
    set(dealer, ZMQ_LINGER, 0);
    set(dealer, ZMQ_IMMEDIATE, 1);
    set(dealer, ZMQ_HEARTBEAT_IVL, HEARTBEAT_MS);
    set(dealer, ZMQ_HEARTBEAT_TIMEOUT, HEARTBEAT_TIMEOUT_MS);
    set(dealer, ZMQ_RECONNECT_IVL, RETRY_MS);
    set(dealer, ZMQ_RECONNECT_IVL_MAX, RETRY_MAX_MS);
}

static bool watch_dealer(Wire *wire)
{
    static const int events = ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_CONNECT_RETRIED |
                              ZMQ_EVENT_HANDSHAKE_FAILED_AUTH | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                              ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL;
    static const char address[] = "inproc://monitor"; /* every client has a context of its own */
    wire->monitor = zmq_socket(wire->context, ZMQ_PAIR);
    return wire->monitor && zmq_socket_monitor(wire->dealer, address, events) == 0 &&
           zmq_connect(wire->monitor, address) == 0;
}

/* Whoever cannot make sense of what we say ends the connection without a word, as does one that dies or is started anew at that moment: which it was is
 * seen when ZeroMQ has tried again. */
static void note_event(Wire *wire, int event)
{
    switch (event) {
    case ZMQ_EVENT_HANDSHAKE_SUCCEEDED:
        wire->connected = true;
        wire->failed = wire->cut = wire->refusals = 0;
        wire->was_cut = false;
        wire->connections++;
        break;
    case ZMQ_EVENT_DISCONNECTED:
        if (wire->connected) wire->lost_since = wire_clock();
        wire->connected = false;
        break;
    case ZMQ_EVENT_CONNECT_RETRIED: /* also after a cut, which is no refusal */
        wire->refusals += !wire->was_cut;
        wire->was_cut = false;
        break;
    case ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL:
        wire->was_cut = true;
        if (++wire->cut >= CUTS && !wire->failed) wire->failed = event;
        break;
    default: /* refused */
        if (wire->failed != ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) wire->failed = event;
    }
}

/* Take note of what the monitor has to say. */
static void note_events(Wire *wire)
{
    uint16_t event = 0;
    char data[6], address[MNS_ENDPOINT_SIZE];
    while (zmq_recv(wire->monitor, data, sizeof data, ZMQ_DONTWAIT) >= 0) {
        zmq_recv(wire->monitor, address, sizeof address, 0);
        memcpy(&event, data, sizeof event);
        note_event(wire, event);
    }
}

/* ZeroMQ does not try again after that. */
static bool is_denied(const Wire *wire)
{
    return wire->failed == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;
}

static MnsStatus deny(const Wire *wire, MnsError *error)
{
    return mns_fail(
        error, MNS_E_DENIED,
        "the daemon at %s does not let in the key %s; on its machine, `meniscus keys list` tells which it does",
        wire->endpoint, wire->keys.public_key);
}

/* A daemon whose places are used up ends a connection as one does that cannot make sense of the handshake: without a word. A socket file takes no keys, so there it is
 * the former. */
static MnsStatus closed_at_once(const Wire *wire, MnsError *error)
{
    static const char full[] =
        "its places for connections are used up (see its log, which names the process that has most of them)";
    if (!strncmp(wire->endpoint, "ipc://", 6))
        return mns_fail(error, MNS_E_UNAVAILABLE,
                        "the daemon at %s closes each connection at once: %s, or another program listens there",
                        wire->endpoint, full);
    if (!*wire->keys.public_key)
        return mns_fail(
            error, MNS_E_UNAVAILABLE,
            "the program at %s closes each connection at once: it takes no plain text (for a daemon with --listen set "
            "MENISCUS_KEY to the file of a key, or give it to `meniscus` with --key; `meniscus keys new` writes one on "
            "its machine), or %s",
            wire->endpoint, full);
    return mns_fail(
        error, MNS_E_UNAVAILABLE,
        "the program at %s closes each connection at once: it does not have the secret of the server key %s (it is "
        "another daemon, its keys were made anew, or it is at its --tcp, which takes no key), or %s",
        wire->endpoint, wire->keys.server_key, full);
}

/* Of a daemon by its socket, .../NAME/control.ipc; empty if that is not how it is reached, or if the name is the usual one. */
static void name_of(const char *endpoint, char ret[static 64])
{
    static const char last[] = "/control.ipc";
    const char *end = strstr(endpoint, last), *begin = end;
    *ret = 0;
    if (!end || end[sizeof last - 1]) return;
    while (begin > endpoint && begin[-1] != '/') begin--;
    if (end - begin < 64) snprintf(ret, 64, "%.*s", (int)(end - begin), begin);
    if (!strcmp(ret, "default")) *ret = 0;
}

static MnsStatus no_answer(const Wire *wire, MnsError *error)
{
    if (wire->cut)
        return mns_fail(
            error, MNS_E_UNAVAILABLE,
            "the connection to %s was lost before it stood, and trying again did not help in time; who listens "
            "there may be starting anew: try again",
            wire->endpoint);
    return mns_fail(error, MNS_E_UNAVAILABLE,
                    "no answer from %s: who listens there hangs, or the network loses what is sent; see `meniscus ls` "
                    "on its machine",
                    wire->endpoint);
}

static MnsStatus await_connection(Wire *wire, double deadline, MnsError *error)
{
    zmq_pollitem_t item = {.socket = wire->monitor, .events = ZMQ_POLLIN};
    while (!wire->connected && !wire->failed && wire->refusals < REFUSALS && wire_clock() < deadline) {
        zmq_poll(&item, 1, (long)fmax(1, 1e3 * (deadline - wire_clock())));
        note_events(wire);
    }
    if (wire->connected) return MNS_OK;
    if (wire->failed) return is_denied(wire) ? deny(wire, error) : closed_at_once(wire, error);
    if (!wire->refusals || wire->cut) return no_answer(wire, error);
    char name[64];
    name_of(wire->endpoint, name);
    return mns_fail(error, MNS_E_UNAVAILABLE,
                    "nobody listens at %s; start a daemon with `meniscusd%s%s`, or see `meniscus ls`", wire->endpoint,
                    *name ? " --name " : "", name);
}

bool wire_secure(const Wire *wire, void *socket)
{
    const KeyPair *keys = &wire->keys;
    return !*keys->public_key || (!zmq_setsockopt(socket, ZMQ_CURVE_SERVERKEY, keys->server_key, KEY_TEXT) &&
                                  !zmq_setsockopt(socket, ZMQ_CURVE_PUBLICKEY, keys->public_key, KEY_TEXT) &&
                                  !zmq_setsockopt(socket, ZMQ_CURVE_SECRETKEY, keys->secret_key, KEY_TEXT));
}

MnsStatus wire_open(Wire *wire, const char *endpoint, const KeyPair *keys, double deadline, MnsError *error)
{
    *wire = (Wire){.reconnect_s = RECONNECT_S};
    if (keys) wire->keys = *keys;
    snprintf(wire->endpoint, sizeof wire->endpoint, "%s", endpoint);
    const bool is_ipc = strncmp(endpoint, "ipc://", 6) == 0;
    if (is_ipc && access(endpoint + 6, F_OK) != 0)
        return mns_fail(error, MNS_E_UNAVAILABLE, "there is no socket %s (%s); start a daemon with `meniscusd`",
                        endpoint + 6, strerror(errno));
    const MnsStatus status = open_files_check(OPEN_FILES_CLIENT, error);
    if (status) return status;
    wire->context = zmq_ctx_new();
    wire->dealer = wire->context ? zmq_socket(wire->context, ZMQ_DEALER) : NULL;
    if (!wire->dealer || !watch_dealer(wire))
        return mns_fail(error, MNS_E_MEMORY, "cannot make a socket: %s", zmq_strerror(errno));
    set_options(wire->dealer);
    set(wire->dealer, ZMQ_IPV6, strchr(endpoint, '[') != NULL);
    if (!wire_secure(wire, wire->dealer))
        return mns_fail(error, MNS_E_INVALID, "these keys cannot be used: %s", zmq_strerror(errno));
    if (zmq_connect(wire->dealer, endpoint) != 0)
        return mns_fail(error, MNS_E_UNAVAILABLE, "cannot connect to %s: %s", endpoint, zmq_strerror(errno));
    return await_connection(wire, deadline, error);
}

void wire_close(Wire *wire)
{
    if (wire->dealer) {
        zmq_socket_monitor(wire->dealer, NULL, 0);
        zmq_close(wire->dealer);
    }
    if (wire->monitor) {
        set(wire->monitor, ZMQ_LINGER, 0);
        zmq_close(wire->monitor);
    }
    if (wire->context) zmq_ctx_term(wire->context);
    explicit_bzero(wire, sizeof *wire);
}

double wire_away(Wire *wire)
{
    note_events(wire);
    return wire->connected ? 0 : wire_clock() - wire->lost_since;
}

static MnsStatus gone(const Wire *wire, MnsError *error)
{
    return mns_fail(error, MNS_E_UNAVAILABLE,
                    "the daemon at %s went away; whether the command took effect is not known: "
                    "ask `meniscus status` when it is back",
                    wire->endpoint);
}

MnsStatus wire_check_size(size_t size, int most, MnsError *error)
{
    if (size <= (size_t)most) return MNS_OK;
    return mns_fail(error, MNS_E_LIMIT, "the request has %zu bytes, a daemon takes %d; send it in parts", size, most);
}

MnsStatus wire_send(Wire *wire, const void *data, size_t size, MnsError *error)
{
    const double deadline = wire_clock() + wire->reconnect_s;
    for (;;) {
        note_events(wire);
        if (zmq_send(wire->dealer, data, size, ZMQ_DONTWAIT) >= 0) {
            /* A connection took it, which we shall hear of: the one that was lost may have been so for long. */
            if (!wire->connected) wire->lost_since = wire_clock();
            return MNS_OK;
        }
        if (errno != EAGAIN && errno != EINTR)
            return mns_fail(error, MNS_E_UNAVAILABLE, "cannot send to %s: %s", wire->endpoint, zmq_strerror(errno));
        if (is_denied(wire)) return deny(wire, error);
        if (wire_clock() > deadline) return gone(wire, error);
        zmq_pollitem_t item = {.socket = wire->dealer, .events = ZMQ_POLLOUT};
        zmq_poll(&item, 1, RETRY_MS);
    }
}

/* How long to sleep: not past the deadline, nor past the moment at which a lost connection is given up. */
static long patience_ms(const Wire *wire, double deadline)
{
    double until = deadline;
    if (!wire->connected) until = fmin(until, wire->lost_since + wire->reconnect_s);
    return (long)fmin(POLL_MAX_MS, fmax(0, 1 + 1e3 * (until - wire_clock())));
}

MnsStatus wire_receive(Wire *wire, double deadline, Frames *ret, MnsError *error)
{
    const unsigned connections = wire->connections;
    ret->n = 0;
    for (;;) {
        zmq_pollitem_t items[] = {{.socket = wire->dealer, .events = ZMQ_POLLIN},
                                  {.socket = wire->monitor, .events = ZMQ_POLLIN}};
        zmq_poll(items, 2, patience_ms(wire, deadline));
        if (frames_receive(ret, wire->dealer)) return MNS_OK;
        note_events(wire);
        if (wire->connections > connections) return MNS_OK;
        if (is_denied(wire)) return deny(wire, error);
        const double now = wire_clock();
        if (!wire->connected && now > wire->lost_since + wire->reconnect_s) return gone(wire, error);
        if (now > deadline) return mns_fail(error, MNS_E_TIMEOUT, "no answer from %s in time", wire->endpoint);
    }
}

bool frames_receive(Frames *frames, void *socket)
{
    zmq_msg_t surplus;
    bool more = true;
    frames->n = 0;
    while (more) {
        const bool fits = frames->n < WIRE_MAX_FRAMES;
        zmq_msg_t *frame = fits ? &frames->frame[frames->n] : &surplus;
        zmq_msg_init(frame);
        const bool received = zmq_msg_recv(frame, socket, ZMQ_DONTWAIT) >= 0;
        more = received && zmq_msg_more(frame);
        if (received && fits) frames->n++;
        else zmq_msg_close(frame);
    }
    return frames->n > 0;
}

void frames_done(Frames *frames)
{
    for (int k = 0; k < frames->n; k++) zmq_msg_close(&frames->frame[k]);
    frames->n = 0;
}
