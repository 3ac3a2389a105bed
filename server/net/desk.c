/* SPDX-License-Identifier: BSD-3-Clause */
/* The desk: the sockets of commands and news, and what goes through them. A client that sends rubbish gets a sentence; one that vanishes, nothing; none
 * is waited for. Answers nobody reads are bounded in bytes, and what a frame may ask of this thread in its size or its number. Messages that
 * ZeroMQ has not received to their end cannot be, and so those from afar come through a gate. */
#include "net/desk.h"

#include "base/clock.h"
#include "base/log.h"
#include "net/bell.h"
#include "net/gate.h"
#include "net/handlers.h"
#include "net/ledger.h"
#include "net/outgoing.h"
#include "net/pace.h"
#include "net/peers.h"
#include "net/streams.h"
#include "net/visitors.h"
#include "proto/frame.h"
#include <inttypes.h>
#include <math.h>
#include <poll.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <xxhash.h>
#include <zmq.h>

enum { AT_ONCE = 1024 }; /* frames taken before looking at anything else: a message may have any number */

/* ZeroMQ counts messages, not bytes. So the count is set high enough for a reply to every command under way, and the bytes that
 * clients have not taken are counted besides, see net/outgoing.h. */
enum { REPLIES_UNREAD = 10000 };

/* A client loses a reply it has received but not yet looked at, if the connection closes: ZeroMQ drops it with the
 * connection. So before the sockets close, clients get this long after the latest reply to hang up by themselves. */
enum { FAREWELL_MS = 500 };

/* A message that may not have been read to its end. */
typedef struct Reading {
    Sender sender;
    zmq_msg_t first; /* of the parts; empty before it came */
    uint64_t frames; /* taken so far, that of the sender too */
} Reading;

/* To be woken takes as long as to be asked and to answer. So who has answered stays awake for a moment [s], if the next question comes at once;
 * but not where a run computes, whose time that would be. */
static const double AWAKE = 1e-4;

/* How long [s] a refusal is kept: longer than clients take to ask again for an answer that was lost. */
enum { REFUSED_S = 60 };

enum { DOOR, CONTROL, TELEMETRY, VISITORS, LISTENERS, BELLS };

struct Desk {
    void *context, *control, *telemetry;
    Access *access;
    Gate *gate; /* NULL: nobody comes from afar */
    Run *run;
    /* Of what changed or wrote something, or is about to; of what looked; of what was refused. */
    Ledger *deeds, *questions, *refusals;
    Publisher *publisher;
    Streams *streams;             /* the third socket, which has a thread of its own */
    Visitors visitors, listeners; /* of control, of telemetry */
    Bell bells[BELLS];
    Reading reading;
    Pace pace;
    Outgoing outgoing;
    Traffic traffic;
    RunStatus status; /* looked at last: room that is there when there is no memory */
    double replied;   /* clock_now() of the latest reply */
    RunState state;   /* of the run, as the latest reply or note has it */
    uint64_t epoch;
};

/* --- sockets ----------------------------------------------------------------------------------------------------------- */

static void set(void *socket, int option, int value)
{
    zmq_setsockopt(socket, option, &value, sizeof value);
}

/* beat: [ms] between two questions whether anybody is there, who has three times as long to say so. */
static void set_common(void *socket, int beat)
{
    set(socket, ZMQ_LINGER, 0);
    set(socket, ZMQ_HEARTBEAT_IVL, beat);
    set(socket, ZMQ_HEARTBEAT_TIMEOUT, 3 * beat);
}

static MnsStatus bind_one(void *socket, const char *address, MnsError *error)
{
    if (!address[0] || !zmq_bind(socket, address)) return MNS_OK;
    return mns_fail(error, MNS_E_IO, "cannot listen at %s: %s", address, zmq_strerror(zmq_errno()));
}

/* Options hold for what is bound after them. */
static MnsStatus bind_gate(Desk *desk, const Endpoint *at, MnsError *error)
{
    access_guard_gate(desk->access, desk->control);
    MnsStatus status = bind_one(desk->control, at->gate_control, error);
    if (!status) status = bind_one(desk->telemetry, at->gate_telemetry, error);
    return status ? status : gate_new(at, &desk->gate, error);
}

/* Socket files get their mode from the umask, which is the whole process's; no other thread makes files before the first
 * request. */
static MnsStatus bind_all(Desk *desk, const Endpoint *at, MnsError *error)
{
    const mode_t mask = umask(0177);
    MnsStatus status = bind_one(desk->control, at->control, error);
    if (!status) status = bind_one(desk->telemetry, at->telemetry, error);
    if (!status) status = bind_one(desk->control, at->tcp_control, error);
    if (!status) status = bind_one(desk->telemetry, at->tcp_telemetry, error);
    if (!status && at->far_control[0]) status = bind_gate(desk, at, error);
    umask(mask);
    return status;
}

static MnsStatus open_sockets(Desk *desk, const Endpoint *at, MnsError *error)
{
    desk->context = zmq_ctx_new();
    if (desk->context && at->far_control[0]) zmq_ctx_set(desk->context, ZMQ_IO_THREADS, 2);
    MnsStatus status = access_new(desk->context, at->keys, true, &desk->access, error);
    if (status) return status;
    desk->control = desk->context ? zmq_socket(desk->context, ZMQ_ROUTER) : NULL;
    desk->telemetry = desk->control ? zmq_socket(desk->context, ZMQ_XPUB) : NULL;
    if (!desk->telemetry) return mns_fail(error, MNS_E_MEMORY, "cannot make sockets: %s", zmq_strerror(zmq_errno()));
    const int64_t largest = FRAME_TAKEN, largest_subscription = 256;
    set_common(desk->control, 2000);
    set(desk->control, ZMQ_ROUTER_MANDATORY, 1);
    set(desk->control, ZMQ_ROUTER_HANDOVER, 0);
    set(desk->control, ZMQ_SNDHWM, REPLIES_UNREAD);
    /* We take all that comes: see net/pace.h. */
    set(desk->control, ZMQ_RCVHWM, 0);
    set(desk->telemetry, ZMQ_RCVHWM, 0);
    zmq_setsockopt(desk->control, ZMQ_MAXMSGSIZE, &largest, sizeof largest);
    set_common(desk->telemetry, 8000); /* there may be very many, to whom nobody owes an answer */
    set(desk->telemetry, ZMQ_XPUB_VERBOSE, 1);
    zmq_setsockopt(desk->telemetry, ZMQ_MAXMSGSIZE, &largest_subscription, sizeof largest_subscription);
    access_guard_local(desk->access, desk->control);
    access_guard_local(desk->access, desk->telemetry);
    status = visitors_init(&desk->listeners, desk->context, desk->telemetry, "inproc://listeners", at->gate_telemetry,
                           error);
    return status ? status
                  : visitors_init(&desk->visitors, desk->context, desk->control, "inproc://visitors", NULL, error);
}

static void hang_bells(Desk *desk)
{
    bell_init(&desk->bells[DOOR], access_socket(desk->access));
    bell_init(&desk->bells[CONTROL], desk->control);
    bell_init(&desk->bells[TELEMETRY], desk->telemetry);
    bell_init(&desk->bells[VISITORS], desk->visitors.monitor);
    bell_init(&desk->bells[LISTENERS], desk->listeners.monitor);
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
    MnsStatus status = open_sockets(desk, endpoint, error);
    outgoing_init(&desk->outgoing, desk->control, desk->epoch);
    if (!status) status = bind_all(desk, endpoint, error);
    const StreamsOptions options = {.context = desk->context,
                                    .access = desk->access,
                                    .at = endpoint,
                                    .run = run,
                                    .epoch = desk->epoch,
                                    .traffic = &desk->traffic.streams};
    if (!status) status = streams_new(&options, &desk->streams, error);
    if (!status) {
        desk->deeds = ledger_new(LEDGER_DEEDS, LEDGER_DEEDS_BYTES);
        desk->questions = ledger_new(LEDGER_OTHERS, LEDGER_OTHERS_BYTES);
        desk->refusals = ledger_new(LEDGER_OTHERS, LEDGER_OTHERS_BYTES);
        desk->publisher = publisher_new(desk->telemetry, desk->epoch, desk->traffic.topics);
        if (!desk->deeds || !desk->questions || !desk->refusals || !desk->publisher)
            status = mns_fail(error, MNS_E_MEMORY, "no memory for the desk");
    }
    if (status) {
        desk_free(desk);
        return status;
    }
    hang_bells(desk);
    *ret = desk;
    return MNS_OK;
}

void desk_free(Desk *desk)
{
    if (!desk) return;
    streams_stop(desk->streams);
    const double patience = FAREWELL_MS - 1e3 * (clock_now() - desk->replied);
    if (patience > 0) visitors_see_off(&desk->visitors, (long)patience);
    visitors_done(&desk->visitors);
    visitors_done(&desk->listeners);
    if (desk->control) set(desk->control, ZMQ_LINGER, FAREWELL_MS);
    if (desk->telemetry) set(desk->telemetry, ZMQ_LINGER, FAREWELL_MS);
    zmq_msg_close(&desk->reading.first);
    pace_done(&desk->pace);
    if (desk->control) zmq_close(desk->control);
    if (desk->telemetry) zmq_close(desk->telemetry);
    access_free(desk->access);
    if (desk->context) zmq_ctx_term(desk->context);
    outgoing_done(&desk->outgoing);
    gate_free(desk->gate); /* when it has all that was under way */
    streams_free(desk->streams);
    ledger_free(desk->deeds);
    ledger_free(desk->questions);
    ledger_free(desk->refusals);
    publisher_free(desk->publisher);
    free(desk);
}

void desk_tell(Desk *desk, const Note *note)
{
    publisher_send(desk->publisher, note);
    desk->state = note->state;
    if (note->kind == NOTE_EVENT) streams_tell(desk->streams, note);
}

void desk_end_streams(Desk *desk)
{
    streams_stop(desk->streams);
}

const Traffic *desk_traffic(const Desk *desk)
{
    return &desk->traffic;
}

/* --- the door ----------------------------------------------------------------------------------------------------------- */

/* Before each connection and each request, not once in a turn: what comes after a change is judged by the keys after it. */
static void look_at_keys(Desk *desk)
{
    if (!access_refresh(desk->access)) return;
    log_line(LOG_NOTICE, "a key is gone: connections from afar are made anew");
    gate_renew(desk->gate);
}

/* Whether there may be more. */
static bool see_to_door(Desk *desk)
{
    bool more = true;
    for (int k = 0; k < AT_ONCE && more; k++) {
        look_at_keys(desk);
        more = access_answer(desk->access);
    }
    return more;
}

/* As poll(). */
static int wait_for(const Desk *desk, struct pollfd *items, nfds_t n, int timeout)
{
    while (timeout && !run_state_moves(desk->state) && clock_now() < desk->replied + AWAKE) {
        const int found = poll(items, n, 0);
        if (found) return found;
        sched_yield();
    }
    return poll(items, n, timeout);
}

/* clock_now() when there is something to do that does not ring. */
static double next_due(Desk *desk)
{
    const double news = fmin(publisher_flush(desk->publisher), gate_look(desk->gate, &desk->traffic));
    return fmin(news, pace_due(&desk->pace));
}

/* Is nothing read for a moment, as much has been while a run takes steps? */
static bool rests(const Desk *desk)
{
    return run_state_steps(desk->state) && pace_rests(&desk->pace, clock_now());
}

unsigned desk_poll(Desk *desk, const int fds[2], long timeout)
{
    struct pollfd items[BELLS + 4] = {{.fd = fds[0], .events = POLLIN},
                                      {.fd = fds[1], .events = POLLIN},
                                      {.fd = access_watch(desk->access), .events = POLLIN},
                                      {.fd = gate_line(desk->gate), .events = POLLIN}};
    struct pollfd *of_bells = items + 4;
    bool rings = false;
    const bool resting = rests(desk);
    const double due = fmin(next_due(desk), resting ? desk->pace.read : INFINITY) - clock_now();
    if (due < 1e-3 * (double)timeout) timeout = (long)(1e3 * fmax(due, 0)) + 1;
    if (!resting) bell_ask(&desk->bells[CONTROL]);
    bell_ask(&desk->bells[TELEMETRY]);
    for (int k = 0; k < BELLS; k++) {
        const bool asleep = resting && k == CONTROL;
        of_bells[k] = (struct pollfd){.fd = asleep ? -1 : desk->bells[k].fd, .events = POLLIN};
        rings = rings || (desk->bells[k].rings && !asleep);
    }
    if (wait_for(desk, items, BELLS + 4, rings ? 0 : (int)timeout) <= 0) return 0;
    for (int k = 0; k < BELLS; k++) desk->bells[k].rings |= of_bells[k].revents != 0;
    return (items[0].revents ? 1u : 0) | (items[1].revents ? 2u : 0);
}

/* --- replies ----------------------------------------------------------------------------------------------------------- */

static void send_parts(Desk *desk, const Recipient *to, size_t n, void *const parts[], const size_t sizes[])
{
    desk->replied = clock_now();
    if (outgoing_send(&desk->outgoing, to, n, parts, sizes)) pace_forget(&desk->pace, to->identity, to->identity_size);
}

static Recipient recipient(const Sender *sender, ProtobufCBinaryData id)
{
    return (Recipient){sender->identity, sender->size, &sender->who, id.len == ORDER_ID ? id.data : NULL};
}

/* Answer without an order. id: as far as it is known. */
static void refuse(Desk *desk, const Sender *sender, ProtobufCBinaryData id, const MnsError *why)
{
    Meniscus__Reply reply = MENISCUS__REPLY__INIT;
    const Recipient to = recipient(sender, id);
    desk->traffic.refused++;
    desk->traffic.denied += why->status == MNS_E_DENIED;
    run_status(desk->run, &desk->status);
    reply.has_id = id.len > 0;
    reply.id = id;
    reply.has_code = reply.has_daemon_epoch = reply.has_state = true;
    reply.code = code_of(why->status);
    reply.message = (char *)why->text;
    reply.path = why->path[0] ? (char *)why->path : NULL;
    reply.reason = (char *)mns_status_name(why->status);
    reply.daemon_epoch = desk->epoch;
    reply.state = (Meniscus__State)desk->status.state;
    const size_t size = meniscus__reply__get_packed_size(&reply);
    uint8_t *packed = malloc(size + 1);
    if (packed) meniscus__reply__pack(&reply, packed);
    send_parts(desk, &to, 1, (void *[]){packed}, &size);
}

/* NULL if there is none of it, or no memory. */
static void *copy_of(const void *data, size_t size)
{
    void *copy = data ? malloc(size + 1) : NULL;
    if (copy) memcpy(copy, data, size);
    return copy;
}

/* Send the reply to one of its senders: the original or a copy. packed: NULL if there was no memory for it. One whose share of unread replies is used up gets a
 * refusal in place of arrays. */
static void send_to(Desk *desk, Exchange *exchange, const Sender *sender, uint8_t *packed, size_t size, bool original)
{
    const Recipient to = {sender->identity, sender->size, &sender->who, exchange->order.id};
    MnsError why;
    if (packed && exchange->reply->n_arrays && outgoing_check(&desk->outgoing, &to, &why)) {
        refuse(desk, sender, (ProtobufCBinaryData){ORDER_ID, exchange->order.id}, &why);
        if (original) free(packed);
        return;
    }
    void *parts[OUTGOING_PARTS] = {original ? packed : copy_of(packed, size)};
    const size_t n = parts[0] ? exchange->reply->n_arrays : 0;
    size_t sizes[OUTGOING_PARTS] = {size};
    for (size_t k = 0; k < n; k++) {
        parts[1 + k] = original ? exchange->arrays[k] : copy_of(exchange->arrays[k], exchange->sizes[k]);
        sizes[1 + k] = exchange->sizes[k];
        if (original) exchange->arrays[k] = NULL;
    }
    send_parts(desk, &to, 1 + n, parts, sizes);
}

static void send_exchange(Desk *desk, Exchange *exchange, uint8_t *packed, size_t size)
{
    const size_t n = exchange->n_senders;
    for (size_t k = 0; k < n; k++) send_to(desk, exchange, &exchange->senders[k], packed, size, k + 1 == n);
    if (!n) free(packed);
}

static Ledger *ledger_of(const Desk *desk, const Handler *handler)
{
    return handler && handler->traits & LOOKS ? desk->questions : desk->deeds;
}

/* packed: NULL: not to be remembered. */
static void note_reply(Desk *desk, const Exchange *exchange, const uint8_t *packed, size_t size)
{
    Ledger *ledger = ledger_of(desk, exchange->handler);
    const bool refused = ledger == desk->deeds && exchange->order.status && !exchange->order.begun;
    ledger_end(ledger, exchange, refused ? NULL : packed, size);
    if (refused && packed) ledger_recall(desk->refusals, exchange->order.id, exchange->command, packed, size);
}

void desk_reply(Desk *desk, Exchange *exchange)
{
    if (!exchange->sealed) exchange_seal(exchange);
    if (exchange->order.status) desk->traffic.refused++;
    desk->state = exchange->order.state;
    const Meniscus__Reply *reply = exchange->reply;
    const bool whole = reply && reply->has_id; /* else there was no memory, and without its id nobody knows it */
    const size_t size = whole ? meniscus__reply__get_packed_size(reply) : 0;
    uint8_t *packed = whole ? malloc(size + 1) : NULL;
    if (packed) meniscus__reply__pack(reply, packed);
    note_reply(desk, exchange, packed && !reply->n_arrays ? packed : NULL, size);
    send_exchange(desk, exchange, packed, size);
    exchange_free(exchange);
}

/* --- requests ---------------------------------------------------------------------------------------------------------- */

/* To one who does not wait for what comes of a scheduled command. */
static void acknowledge(Desk *desk, const Exchange *exchange, const Sender *sender)
{
    Meniscus__Reply reply = MENISCUS__REPLY__INIT;
    char text[sizeof exchange->order.notice.text + 16];
    const Recipient to = {sender->identity, sender->size, &sender->who, exchange->order.id};
    snprintf(text, sizeof text, "scheduled: %s", exchange->order.notice.text);
    run_status(desk->run, &desk->status);
    reply.has_id = reply.has_code = reply.has_daemon_epoch = reply.has_state = true;
    reply.id = (ProtobufCBinaryData){.len = ORDER_ID, .data = (uint8_t *)exchange->order.id};
    reply.code = MENISCUS__CODE__OK;
    reply.message = text;
    reply.daemon_epoch = desk->epoch;
    reply.state = (Meniscus__State)desk->status.state;
    reply.has_step = reply.has_time = true;
    reply.step = desk->status.progress.step;
    reply.time = desk->status.progress.t;
    reply.has_case_version = desk->status.version > 0;
    reply.case_version = desk->status.version;
    const size_t size = meniscus__reply__get_packed_size(&reply);
    uint8_t *packed = malloc(size + 1);
    if (packed) meniscus__reply__pack(&reply, packed);
    send_parts(desk, &to, 1, (void *[]){packed}, &size);
}

void desk_scheduled(Desk *desk, Exchange *exchange)
{
    size_t n = 0;
    exchange->scheduled = true;
    for (size_t k = 0; k < exchange->n_senders; k++) {
        if (exchange->senders[k].no_wait) acknowledge(desk, exchange, &exchange->senders[k]);
        else exchange->senders[n++] = exchange->senders[k];
    }
    exchange->n_senders = n;
}

/* One more who wants the reply. Connections that were lost are among them, so there is an end: the first is told to ask again. */
static void add_sender(Desk *desk, Exchange *exchange, const Sender *sender, ProtobufCBinaryData id)
{
    MnsError why;
    if (exchange->n_senders == EXCHANGE_SENDERS) {
        mns_fail(&why, MNS_E_LIMIT, "the command is under way, and %d others wait for the same reply; ask again later",
                 EXCHANGE_SENDERS);
        refuse(desk, &exchange->senders[0], id, &why);
        memmove(exchange->senders, exchange->senders + 1, --exchange->n_senders * sizeof *exchange->senders);
    }
    exchange->senders[exchange->n_senders++] = *sender;
}

/* The same request again: its reply again, or when it comes. */
static void repeat(Desk *desk, const Sender *sender, ProtobufCBinaryData id, const LedgerEntry *entry)
{
    if (entry->under_way && entry->under_way->scheduled && sender->no_wait) {
        acknowledge(desk, entry->under_way, sender);
        return;
    }
    if (entry->under_way) {
        add_sender(desk, entry->under_way, sender, id);
        return;
    }
    const Recipient to = recipient(sender, id);
    send_parts(desk, &to, 1, (void *[]){copy_of(entry->reply, entry->size)}, &entry->size);
}

static MnsStatus begin(Desk *desk, Exchange *exchange, MnsError *error)
{
    const Meniscus__Request *request = exchange->request;
    const Handler *handler = handler_find(request->command_case);
    const Sender *sender = exchange->n_senders ? &exchange->senders[0] : NULL;
    const double came = sender ? sender->came : clock_now();
    if (request->has_deadline_ms) exchange->order.deadline = came + 1e-3 * (double)request->deadline_ms;
    if (handler && handler->traits & LARGE && sender) {
        const Recipient to = {sender->identity, sender->size, &sender->who, exchange->order.id};
        const MnsStatus status = outgoing_check(&desk->outgoing, &to, error);
        if (status) return status;
    }
    const bool noted = handler && handler->where == AT_STEP;
    Ledger *ledger = ledger_of(desk, handler);
    MnsStatus status = noted ? ledger_begin(ledger, exchange, error) : MNS_OK;
    if (status) return status;
    status = handle(desk->run, exchange, error);
    if (status && noted) ledger_end(ledger, exchange, NULL, 0);
    return status;
}

/* Of a request by its id. A refusal has done nothing: it is kept for who has not heard it and asks again at once, and then tried anew. */
static bool find_answer(Desk *desk, ProtobufCBinaryData id, LedgerEntry *ret)
{
    ledger_forget(desk->refusals, clock_now() - REFUSED_S);
    return ledger_find(desk->deeds, id.data, ret) || ledger_find(desk->questions, id.data, ret) ||
           ledger_find(desk->refusals, id.data, ret);
}

/* Who may not give a command is not told what came of it either. */
static void repeat_or_refuse(Desk *desk, const Sender *sender, const Who *who, ProtobufCBinaryData id,
                             const LedgerEntry *entry, const Meniscus__Request *request)
{
    MnsError error;
    const bool same = !entry->command || entry->command == exchange_command(request);
    const MnsStatus status = handler_check_role(handler_find(request->command_case), who, &error);
    if (!status && same) {
        repeat(desk, sender, id, entry);
        return;
    }
    if (!status)
        mns_fail(&error, MNS_E_INVALID,
                 "the id is that of another request, which was answered or is under way; each needs an id of its own");
    refuse(desk, sender, id, &error);
}

/* Takes over the request. */
static void take_request(Desk *desk, const Sender *from, const Who *who, ProtobufCBinaryData id,
                         Meniscus__Request *request, const Lineage *lineage)
{
    LedgerEntry entry;
    MnsError error;
    Sender sender = *from;
    sender.no_wait = request->has_no_wait && request->no_wait;
    if (find_answer(desk, request->id, &entry)) {
        repeat_or_refuse(desk, &sender, who, id, &entry, request);
        request_free(request);
        return;
    }
    Exchange *exchange = exchange_new(request, who);
    if (!exchange) {
        mns_fail(&error, MNS_E_MEMORY, "no memory for the command; nothing was done");
        refuse(desk, &sender, id, &error);
        return;
    }
    exchange->epoch = desk->epoch;
    exchange->streams = &desk->traffic.streams;
    exchange->order.lineage = lineage;
    exchange->order.begun = lineage != NULL;
    exchange->order.from = sender.size ? XXH64(sender.identity, sender.size, 0) : 0;
    if (sender.size) exchange->senders[exchange->n_senders++] = sender;
    if (!begin(desk, exchange, &error)) return;
    refuse(desk, &sender, id, &error);
    exchange_free(exchange);
}

void desk_recall(Desk *desk, const Meniscus__Request *request, const uint8_t *reply, size_t size)
{
    ledger_recall(desk->deeds, request->id.data, exchange_command(request), reply, size);
}

void desk_take(Desk *desk, const Who *who, Meniscus__Request *request, const Lineage *lineage)
{
    const Sender nobody = {.size = 0};
    take_request(desk, &nobody, who, request->id, request, lineage);
}

/* --- which requests are heard when ------------------------------------------------------------------------------------- */

/* Does it only ask? What the sender may not do, and what is not understood, is refused in the same time. */
static bool is_question(const Sender *sender, const Meniscus__Request *request)
{
    const Handler *handler = request ? handler_find(request->command_case) : NULL;
    return !handler || handler->where == HERE || handler->traits & LOOKS || sender->who.role < handler->role;
}

/* A request as its frame has it. */
typedef struct Heard {
    Meniscus__Request *request; /* NULL: it could not be read */
    MnsError why;
} Heard;

static void read_frame(zmq_msg_t *frame, uint64_t parts, Heard *ret)
{
    const void *data = zmq_msg_data(frame);
    ret->request = NULL;
    MnsStatus status =
        parts == 1 ? MNS_OK : mns_fail(&ret->why, MNS_E_INVALID, "a request is one frame; these are %" PRIu64, parts);
    if (!status) status = request_read(data, zmq_msg_size(frame), &ret->request, &ret->why);
    if (!status) return;
    request_free(ret->request);
    ret->request = NULL;
}

/* Takes over the request. */
static void hear(Desk *desk, const Sender *sender, zmq_msg_t *frame, Heard *heard)
{
    const ProtobufCBinaryData id = request_id(zmq_msg_data(frame), zmq_msg_size(frame));
    if (heard->request) take_request(desk, sender, &sender->who, id, heard->request, NULL);
    else refuse(desk, sender, id, &heard->why);
}

static void hear_held(Desk *desk, Held *held)
{
    Heard heard;
    if (!held) return;
    read_frame(&held->frame, held->parts, &heard);
    hear(desk, &held->sender, &held->frame, &heard);
    held_free(held);
}

static void hear_due(Desk *desk)
{
    for (Held *held; (held = pace_next(&desk->pace, !run_state_steps(desk->state), clock_now()));)
        hear_held(desk, held);
}

/* What a connection asked before a command is heard before it. */
static void hear_all_of(Desk *desk, const Sender *sender)
{
    for (Held *held; (held = pace_pull(&desk->pace, sender, NULL));) hear_held(desk, held);
}

/* And what a command cancels is known. */
static void hear_cancelled(Desk *desk, const Meniscus__Request *request)
{
    if (request->command_case == MENISCUS__REQUEST__COMMAND_CANCEL && request->cancel->has_id)
        hear_held(desk, pace_pull(&desk->pace, NULL, &request->cancel->id));
}

/* Let a question wait, or refuse it. What is too long for a request is refused at once. */
static void hold(Desk *desk, const Sender *sender, zmq_msg_t *frame, uint64_t parts, Heard *heard)
{
    const bool ends = heard->request && heard->request->has_deadline_ms;
    const double deadline = ends ? sender->came + 1e-3 * (double)heard->request->deadline_ms : INFINITY;
    MnsStatus status = zmq_msg_size(frame) > FRAME_MAX ? heard->why.status : MNS_OK;
    if (!status) status = pace_hold(&desk->pace, sender, frame, parts, deadline, &heard->why);
    if (status) refuse(desk, sender, request_id(zmq_msg_data(frame), zmq_msg_size(frame)), &heard->why);
    request_free(heard->request);
}

/* As hear(), when its turn has come. */
static void hear_in_turn(Desk *desk, const Sender *sender, zmq_msg_t *frame, uint64_t parts)
{
    Heard heard;
    read_frame(frame, parts, &heard);
    const bool asks = is_question(sender, heard.request);
    if (asks && run_state_steps(desk->state) && !pace_admits(&desk->pace, sender, clock_now())) {
        hold(desk, sender, frame, parts, &heard);
        return;
    }
    if (!asks) hear_cancelled(desk, heard.request);
    hear_all_of(desk, sender);
    hear(desk, sender, frame, &heard);
}

/* Nobody who is not let in gets here, but whoever is no longer: then it is as if nothing had come. */
static void take_frame(Desk *desk, Sender *sender, zmq_msg_t *frame, uint64_t parts)
{
    look_at_keys(desk);
    peers_heard(zmq_msg_get(frame, ZMQ_SRCFD));
    if (!access_who(desk->access, frame, &sender->who)) return;
    sender->came = clock_now();
    desk->traffic.requests++;
    hear_in_turn(desk, sender, frame, parts);
}

/* Take one frame: who sent the message, then its parts. The first part is looked at, the others are dropped as they come, without
 * a copy, and only counted. False if there is none now. */
static bool receive_frame(Desk *desk)
{
    zmq_msg_t frame;
    Reading *reading = &desk->reading;
    if (!reading->frames && rests(desk)) return false;
    zmq_msg_init(&frame);
    if (zmq_msg_recv(&frame, desk->control, ZMQ_DONTWAIT) < 0) return false;
    const bool more = zmq_msg_more(&frame);
    const size_t size = zmq_msg_size(&frame);
    if (reading->frames == 0) {
        pace_note_read(&desk->pace, clock_now());
        reading->sender.size = size < EXCHANGE_IDENTITY ? size : EXCHANGE_IDENTITY;
        memcpy(reading->sender.identity, zmq_msg_data(&frame), reading->sender.size);
    } else if (reading->frames == 1) zmq_msg_move(&reading->first, &frame);
    zmq_msg_close(&frame);
    reading->frames++;
    if (more) return true;
    take_frame(desk, &reading->sender, &reading->first, reading->frames - 1);
    zmq_msg_close(&reading->first);
    zmq_msg_init(&reading->first);
    reading->frames = 0;
    return true;
}

/* Subscriptions come as one byte, 1 to begin and 0 to end, and the topic. */
static bool receive_subscription(Desk *desk)
{
    zmq_msg_t frame;
    zmq_msg_init(&frame);
    if (zmq_msg_recv(&frame, desk->telemetry, ZMQ_DONTWAIT) < 0) return false;
    const char *text = zmq_msg_data(&frame);
    const size_t size = zmq_msg_size(&frame);
    peers_heard(zmq_msg_get(&frame, ZMQ_SRCFD));
    if (size && (text[0] == 1 || text[0] == GATE_LISTENER)) publisher_welcome(desk->publisher, text + 1, size - 1);
    zmq_msg_close(&frame);
    return true;
}

_Static_assert((int)TRAFFIC_ROLES == ROLE_ADMIN - ROLE_VIEWER + 1, "keys are counted by all roles");
_Static_assert((int)TRAFFIC_FAILURES == (int)FAILURES, "failures are counted by all reasons");

static void note_traffic(Desk *desk)
{
    Traffic *traffic = &desk->traffic;
    if (desk->bells[VISITORS].rings) visitors_note(&desk->visitors);
    if (desk->bells[LISTENERS].rings) visitors_note(&desk->listeners);
    desk->bells[VISITORS].rings = desk->bells[LISTENERS].rings = false;
    traffic->clients = desk->visitors.n;
    traffic->listeners = desk->listeners.n + gate_listeners(desk->gate);
    publisher_crowd(desk->publisher, traffic->listeners);
    traffic->unread = outgoing_unread(&desk->outgoing);
    for (int k = 0; k < TRAFFIC_ROLES; k++) traffic->keys[k] = access_count(desk->access, (Role)(ROLE_VIEWER + k));
    for (int k = 0; k < TRAFFIC_FAILURES; k++) traffic->failures[k] = desk->visitors.failed[k];
}

/* Whether there may be more, when so much was taken at once. */
static bool take_all(Desk *desk, bool (*take)(Desk *))
{
    int k = 0;
    while (k < AT_ONCE && take(desk)) k++;
    return k == AT_ONCE;
}

void desk_receive(Desk *desk)
{
    Bell *bells = desk->bells;
    note_traffic(desk);
    look_at_keys(desk);
    if (bells[DOOR].rings) bells[DOOR].rings = see_to_door(desk);
    hear_due(desk);
    if (bells[CONTROL].rings) bells[CONTROL].rings = take_all(desk, receive_frame);
    if (bells[TELEMETRY].rings) bells[TELEMETRY].rings = take_all(desk, receive_subscription);
    publisher_greet(desk->publisher);
}
