/* SPDX-License-Identifier: BSD-3-Clause */
/* The desk: sockets and what goes through them. A client that sends rubbish gets a sentence; one that vanishes, nothing; no
 * client can make the daemon wait. Answers nobody reads are bounded in bytes. Messages that ZeroMQ has not received to their end
 * cannot be: see DECISIONS.md. */
#include "net/desk.h"

#include "base/clock.h"
#include "base/log.h"
#include "net/handlers.h"
#include "net/ledger.h"
#include "net/visitors.h"
#include "proto/frame.h"
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <zmq.h>

enum { AT_ONCE = 1024 }; /* frames taken before looking at anything else: a message may have any number */

/* ZeroMQ counts messages, not bytes. So the count is set high enough for a reply to every command under way, and the bytes that
 * clients have not taken are counted here: beyond the first limit no more queries are answered, beyond twice that, nothing. */
enum { REPLIES_UNREAD = 10000 };
static const size_t BYTES_UNREAD = 128 << 20;

/* A client loses a reply it has received but not yet looked at, if the connection closes: ZeroMQ drops it with the
 * connection. So before the sockets close, clients get this long after the latest reply to hang up by themselves. */
enum { FAREWELL_MS = 500 };

/* Who sent the message being read. */
typedef struct Sender {
    uint8_t identity[EXCHANGE_IDENTITY];
    size_t size;
} Sender;

/* A message that may not have been read to its end. */
typedef struct Reading {
    Sender sender;
    zmq_msg_t first; /* of the parts; empty before it came */
    uint64_t frames; /* taken so far, that of the sender too */
} Reading;

struct Desk {
    void *context, *control, *telemetry;
    Run *run;
    Ledger *ledger;
    Publisher *publisher;
    Visitors visitors;
    Reading reading;
    double replied; /* clock_now() of the latest reply */
    uint64_t epoch;
    _Atomic size_t unread;
};

/* --- sockets ----------------------------------------------------------------------------------------------------------- */

static void set(void *socket, int option, int value)
{
    zmq_setsockopt(socket, option, &value, sizeof value);
}

static void set_common(void *socket)
{
    set(socket, ZMQ_LINGER, 0);
    set(socket, ZMQ_HEARTBEAT_IVL, 2000);
    set(socket, ZMQ_HEARTBEAT_TIMEOUT, 6000);
}

static MnsStatus bind_one(void *socket, const char *address, MnsError *error)
{
    if (!address[0] || !zmq_bind(socket, address)) return MNS_OK;
    return mns_fail(error, MNS_E_IO, "cannot listen at %s: %s", address, zmq_strerror(zmq_errno()));
}

/* Socket files get their mode from the umask, which is the whole process's; no other thread makes files before the first
 * request. */
static MnsStatus bind_all(Desk *desk, const Endpoint *at, MnsError *error)
{
    const mode_t mask = umask(0177);
    MnsStatus status = bind_one(desk->control, at->control, error);
    if (!status) status = bind_one(desk->telemetry, at->telemetry, error);
    umask(mask);
    if (!status) status = bind_one(desk->control, at->tcp_control, error);
    return status ? status : bind_one(desk->telemetry, at->tcp_telemetry, error);
}

static MnsStatus open_sockets(Desk *desk, MnsError *error)
{
    desk->context = zmq_ctx_new();
    desk->control = desk->context ? zmq_socket(desk->context, ZMQ_ROUTER) : NULL;
    desk->telemetry = desk->control ? zmq_socket(desk->context, ZMQ_XPUB) : NULL;
    if (!desk->telemetry) return mns_fail(error, MNS_E_MEMORY, "cannot make sockets: %s", zmq_strerror(zmq_errno()));
    const int64_t largest = FRAME_MAX, largest_subscription = 256;
    set_common(desk->control);
    set(desk->control, ZMQ_ROUTER_MANDATORY, 1);
    set(desk->control, ZMQ_ROUTER_HANDOVER, 0);
    set(desk->control, ZMQ_SNDHWM, REPLIES_UNREAD);
    zmq_setsockopt(desk->control, ZMQ_MAXMSGSIZE, &largest, sizeof largest);
    set_common(desk->telemetry);
    set(desk->telemetry, ZMQ_XPUB_VERBOSE, 1);
    zmq_setsockopt(desk->telemetry, ZMQ_MAXMSGSIZE, &largest_subscription, sizeof largest_subscription);
    return visitors_init(&desk->visitors, desk->context, desk->control, error);
}

MnsStatus desk_new(const Endpoint *endpoint, Run *run, Desk **ret, MnsError *error)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    Desk *desk = calloc(1, sizeof *desk);
    if (!desk) return mns_fail(error, MNS_E_MEMORY, "no memory for the desk");
    desk->run = run;
    desk->replied = -INFINITY;
    zmq_msg_init(&desk->reading.first);
    desk->epoch = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
    MnsStatus status = open_sockets(desk, error);
    if (!status) status = bind_all(desk, endpoint, error);
    if (!status) {
        desk->ledger = ledger_new();
        desk->publisher = publisher_new(desk->telemetry, desk->epoch);
        if (!desk->ledger || !desk->publisher) status = mns_fail(error, MNS_E_MEMORY, "no memory for the desk");
    }
    if (status) desk_free(desk);
    else *ret = desk;
    return status;
}

void desk_free(Desk *desk)
{
    if (!desk) return;
    const double patience = FAREWELL_MS - 1e3 * (clock_now() - desk->replied);
    if (patience > 0) visitors_see_off(&desk->visitors, (long)patience);
    visitors_done(&desk->visitors);
    if (desk->control) set(desk->control, ZMQ_LINGER, FAREWELL_MS);
    if (desk->telemetry) set(desk->telemetry, ZMQ_LINGER, FAREWELL_MS);
    zmq_msg_close(&desk->reading.first);
    if (desk->control) zmq_close(desk->control);
    if (desk->telemetry) zmq_close(desk->telemetry);
    if (desk->context) zmq_ctx_term(desk->context);
    ledger_free(desk->ledger);
    publisher_free(desk->publisher);
    free(desk);
}

Publisher *desk_publisher(Desk *desk)
{
    return desk->publisher;
}

unsigned desk_poll(Desk *desk, const int fds[2], long timeout)
{
    zmq_pollitem_t items[] = {{.fd = fds[0], .events = ZMQ_POLLIN},
                              {.fd = fds[1], .events = ZMQ_POLLIN},
                              {.socket = desk->control, .events = ZMQ_POLLIN},
                              {.socket = desk->telemetry, .events = ZMQ_POLLIN},
                              {.socket = desk->visitors.monitor, .events = ZMQ_POLLIN}};
    if (zmq_poll(items, 5, timeout) <= 0) return 0;
    return (items[0].revents ? 1u : 0) | (items[1].revents ? 2u : 0);
}

/* --- replies ----------------------------------------------------------------------------------------------------------- */

/* A raw frame on its way, to be counted until ZeroMQ lets go of it, on its own thread. The size is written last and read
 * first, so that what is handed over is in order for race detectors too, which do not see into ZeroMQ. */
typedef struct Parcel {
    _Atomic size_t *unread;
    _Atomic size_t size;
} Parcel;

static void let_go(void *data, void *hint)
{
    Parcel *parcel = hint;
    const size_t size = parcel->size;
    *parcel->unread -= size;
    free(parcel);
    free(data);
}

/* Takes over data, from malloc. */
static bool send_parcel(Desk *desk, void *data, size_t size, int flags)
{
    zmq_msg_t message;
    Parcel *parcel = malloc(sizeof *parcel);
    if (!parcel || zmq_msg_init_data(&message, data, size, let_go, parcel)) {
        free(parcel);
        free(data);
        return false;
    }
    parcel->unread = &desk->unread;
    parcel->size = size;
    desk->unread += size;
    if (zmq_msg_send(&message, desk->control, flags | ZMQ_DONTWAIT) >= 0) return true;
    zmq_msg_close(&message);
    return false;
}

/* Begin a reply to one connection with its first frame, which is taken over. If the client is gone or reads nothing, it is not
 * sent; asked again, it will be. */
static bool send_first(Desk *desk, const uint8_t *identity, size_t identity_size, uint8_t *packed, size_t size,
                       bool more)
{
    const bool room = desk->unread < 2 * BYTES_UNREAD;
    desk->replied = clock_now();
    if (room && zmq_send(desk->control, identity, identity_size, ZMQ_SNDMORE | ZMQ_DONTWAIT) >= 0)
        return send_parcel(desk, packed, size, more ? ZMQ_SNDMORE : 0);
    log_line(LOG_DETAIL, "a reply is not sent: %s", room ? zmq_strerror(zmq_errno()) : "clients leave too many unread");
    free(packed);
    return false;
}

static void send_exchange(Desk *desk, Exchange *exchange, uint8_t *packed, size_t size)
{
    const size_t n = exchange->reply->n_arrays;
    if (!send_first(desk, exchange->identity, exchange->identity_size, packed, size, n > 0)) return;
    for (size_t k = 0; k < n; k++) {
        send_parcel(desk, exchange->arrays[k], exchange->sizes[k], k + 1 < n ? ZMQ_SNDMORE : 0);
        exchange->arrays[k] = NULL;
    }
}

static void complete(Desk *desk, Exchange *exchange)
{
    Order *order = &exchange->order;
    if (!order->status && exchange->handler && exchange->handler->complete)
        order->status = exchange->handler->complete(exchange, &order->error);
    exchange_seal(exchange, desk->epoch);
}

void desk_reply(Desk *desk, Exchange *exchange)
{
    complete(desk, exchange);
    const Meniscus__Reply *reply = exchange->reply;
    const size_t size = reply ? meniscus__reply__get_packed_size(reply) : 0;
    uint8_t *packed = malloc(size + 1);
    if (reply && packed) {
        meniscus__reply__pack(reply, packed);
        ledger_end(desk->ledger, exchange, reply->n_arrays ? NULL : packed, size);
    } else ledger_end(desk->ledger, exchange, NULL, 0);
    if (reply && packed && exchange->identity_size) send_exchange(desk, exchange, packed, size);
    else free(packed);
    exchange_free(exchange);
}

/* --- requests ---------------------------------------------------------------------------------------------------------- */

/* Answer without an order. request may be NULL; what is known of its id is used. */
static void refuse(Desk *desk, const Sender *sender, const Meniscus__Request *request, const MnsError *why)
{
    Meniscus__Reply reply = MENISCUS__REPLY__INIT;
    RunStatus *status = malloc(sizeof *status);
    if (!status) return;
    run_status(desk->run, status);
    reply.has_id = request && request->has_id && request->id.len <= 64;
    if (reply.has_id) reply.id = request->id;
    reply.has_code = reply.has_daemon_epoch = reply.has_state = true;
    reply.code = code_of(why->status);
    reply.message = (char *)why->text;
    reply.path = why->path[0] ? (char *)why->path : NULL;
    reply.reason = (char *)mns_status_name(why->status);
    reply.daemon_epoch = desk->epoch;
    reply.state = (Meniscus__State)status->state;
    free(status);
    const size_t size = meniscus__reply__get_packed_size(&reply);
    uint8_t *packed = malloc(size + 1);
    if (!packed) return;
    meniscus__reply__pack(&reply, packed);
    send_first(desk, sender->identity, sender->size, packed, size, false);
}

/* The same request again: its reply again, or when it comes, to where it was asked last. */
static void repeat(Desk *desk, const Sender *sender, const LedgerEntry *entry)
{
    uint8_t *copy = entry->reply ? malloc(entry->size + 1) : NULL;
    if (copy) {
        memcpy(copy, entry->reply, entry->size);
        send_first(desk, sender->identity, sender->size, copy, entry->size, false);
    }
    if (!entry->under_way) return;
    memcpy(entry->under_way->identity, sender->identity, sender->size);
    entry->under_way->identity_size = sender->size;
}

static MnsStatus begin(Desk *desk, Exchange *exchange, MnsError *error)
{
    const Meniscus__Request *request = exchange->request;
    const Handler *handler = handler_find(request->command_case);
    if (request->has_deadline_ms) exchange->order.deadline = clock_now() + 1e-3 * (double)request->deadline_ms;
    if (request->command_case == MENISCUS__REQUEST__COMMAND_QUERY && desk->unread > BYTES_UNREAD)
        return mns_fail(error, MNS_E_LIMIT,
                        "clients have not yet read %zu bytes of earlier answers; read them, or wait",
                        (size_t)desk->unread);
    const bool noted = handler && handler->where == AT_STEP;
    MnsStatus status = noted ? ledger_begin(desk->ledger, exchange, error) : MNS_OK;
    if (status) return status;
    status = handle(desk->run, exchange, error);
    if (status && noted) ledger_end(desk->ledger, exchange, NULL, 0);
    return status;
}

/* Takes over the request. */
static void take_request(Desk *desk, const Sender *sender, Meniscus__Request *request)
{
    LedgerEntry entry;
    MnsError error;
    if (ledger_find(desk->ledger, request->id.data, &entry)) {
        repeat(desk, sender, &entry);
        request_free(request);
        return;
    }
    Exchange *exchange = exchange_new(request);
    if (!exchange) return;
    memcpy(exchange->identity, sender->identity, sender->size);
    exchange->identity_size = sender->size;
    if (!begin(desk, exchange, &error)) return;
    refuse(desk, sender, request, &error);
    exchange_free(exchange);
}

static void take_frame(Desk *desk, const Sender *sender, const void *data, size_t size, uint64_t parts)
{
    MnsError error;
    Meniscus__Request *request = NULL;
    MnsStatus status =
        parts == 1 ? MNS_OK : mns_fail(&error, MNS_E_INVALID, "a request is one frame; these are %" PRIu64, parts);
    if (!status) status = request_read(data, size, &request, &error);
    if (!status) {
        take_request(desk, sender, request);
        return;
    }
    refuse(desk, sender, request, &error);
    request_free(request);
}

/* Take one frame: who sent the message, then its parts. The first part is looked at, the others are dropped as they come, without
 * a copy, and only counted. False if there is none now. */
static bool receive_frame(Desk *desk)
{
    zmq_msg_t frame;
    Reading *reading = &desk->reading;
    zmq_msg_init(&frame);
    if (zmq_msg_recv(&frame, desk->control, ZMQ_DONTWAIT) < 0) return false;
    const bool more = zmq_msg_more(&frame);
    const size_t size = zmq_msg_size(&frame);
    if (reading->frames == 0) {
        reading->sender.size = size < EXCHANGE_IDENTITY ? size : EXCHANGE_IDENTITY;
        memcpy(reading->sender.identity, zmq_msg_data(&frame), reading->sender.size);
    } else if (reading->frames == 1) zmq_msg_move(&reading->first, &frame);
    zmq_msg_close(&frame);
    reading->frames++;
    if (more) return true;
    take_frame(desk, &reading->sender, zmq_msg_data(&reading->first), zmq_msg_size(&reading->first),
               reading->frames - 1);
    zmq_msg_close(&reading->first);
    zmq_msg_init(&reading->first);
    reading->frames = 0;
    return true;
}

/* Subscriptions come as one byte, 1 to begin and 0 to end, and the topic. */
static bool receive_subscription(Desk *desk)
{
    char frame[256];
    const int got = zmq_recv(desk->telemetry, frame, sizeof frame, ZMQ_DONTWAIT);
    if (got < 0) return false;
    if (got >= 1 && got <= (int)sizeof frame && frame[0] == 1)
        publisher_welcome(desk->publisher, frame + 1, (size_t)got - 1);
    return true;
}

void desk_receive(Desk *desk)
{
    visitors_note(&desk->visitors);
    for (int k = 0; k < AT_ONCE && receive_frame(desk); k++) continue;
    for (int k = 0; k < AT_ONCE && receive_subscription(desk); k++) continue;
}
