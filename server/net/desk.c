/* SPDX-License-Identifier: BSD-3-Clause */
/* The desk: the sockets of commands and news, and what comes through them. A client that sends rubbish gets a sentence; one that vanishes, nothing; none
 * is waited for. Answers that are not read are bounded in bytes, and what a frame may ask of this thread in its size or its number. Messages that
 * ZeroMQ has not received to their end cannot be, and so those from afar come through a gate. */
#include "net/desk.h"

#include "base/clock.h"
#include "base/log.h"
#include "common/wire/frame.h"
#include "net/bell.h"
#include "net/gate.h"
#include "net/hearing.h"
#include "net/peers.h"
#include "net/streams.h"
#include "net/visitors.h"
#include <math.h>
#include <poll.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
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

enum { DOOR, CONTROL, TELEMETRY, VISITORS, LISTENERS, BELLS };

struct Desk {
    void *context, *control, *telemetry;
    Access *access;
    Gate *gate; /* NULL: nobody comes from afar */
    Publisher *publisher;
    Streams *streams;             /* the third socket, which has a thread of its own */
    Visitors visitors, listeners; /* of control, of telemetry */
    Bell bells[BELLS];
    Reading reading;
    Hearing hearing;
    Answers answers;
    Traffic traffic;
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
    zmq_msg_init(&desk->reading.first);
    desk->answers.pace = &desk->hearing.pace;
    desk->answers.traffic = &desk->traffic;
    desk->hearing.answers = &desk->answers;
    const uint64_t epoch = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
    MnsStatus status = open_sockets(desk, endpoint, error);
    if (!status) status = answers_init(&desk->answers, desk->control, run, epoch, error);
    if (!status) status = bind_all(desk, endpoint, error);
    const StreamsOptions options = {.context = desk->context,
                                    .access = desk->access,
                                    .at = endpoint,
                                    .run = run,
                                    .epoch = epoch,
                                    .traffic = &desk->traffic.streams};
    if (!status) status = streams_new(&options, &desk->streams, error);
    if (!status) {
        desk->publisher = publisher_new(desk->telemetry, epoch, desk->traffic.topics);
        if (!desk->publisher) status = mns_fail(error, MNS_E_MEMORY, "no memory for the desk");
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
    const double patience = FAREWELL_MS - 1e3 * (clock_now() - desk->answers.replied);
    if (patience > 0) visitors_see_off(&desk->visitors, (long)patience);
    visitors_done(&desk->visitors);
    visitors_done(&desk->listeners);
    if (desk->control) set(desk->control, ZMQ_LINGER, FAREWELL_MS);
    if (desk->telemetry) set(desk->telemetry, ZMQ_LINGER, FAREWELL_MS);
    zmq_msg_close(&desk->reading.first);
    pace_done(&desk->hearing.pace);
    if (desk->control) zmq_close(desk->control);
    if (desk->telemetry) zmq_close(desk->telemetry);
    access_free(desk->access);
    if (desk->context) zmq_ctx_term(desk->context);
    answers_done(&desk->answers);
    gate_free(desk->gate); /* when it has all that was under way */
    streams_free(desk->streams);
    publisher_free(desk->publisher);
    free(desk);
}

void desk_tell(Desk *desk, const Note *note)
{
    publisher_send(desk->publisher, note);
    desk->answers.state = note->state;
    if (note->kind == NOTE_EVENT) streams_tell(desk->streams, note);
}

void desk_end_streams(Desk *desk)
{
    streams_stop(desk->streams);
}

Answers *desk_answers(Desk *desk)
{
    return &desk->answers;
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
    while (timeout && !run_state_moves(desk->answers.state) && clock_now() < desk->answers.replied + AWAKE) {
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
    return fmin(news, pace_due(&desk->hearing.pace));
}

/* Is nothing read for a moment, as much has been while a run takes steps? */
static bool rests(const Desk *desk)
{
    return run_state_steps(desk->answers.state) && pace_rests(&desk->hearing.pace, clock_now());
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
    const double due = fmin(next_due(desk), resting ? desk->hearing.pace.read : INFINITY) - clock_now();
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

/* --- requests ---------------------------------------------------------------------------------------------------------- */

/* Nobody who is not let in gets here, but whoever is no longer: then it is as if nothing had come. */
static void take_frame(Desk *desk, Sender *sender, zmq_msg_t *frame, uint64_t parts)
{
    look_at_keys(desk);
    peers_heard(zmq_msg_get(frame, ZMQ_SRCFD));
    if (!access_who(desk->access, frame, &sender->who)) return;
    sender->came = clock_now();
    desk->traffic.requests++;
    hearing_take(&desk->hearing, sender, frame, parts);
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
        pace_note_read(&desk->hearing.pace, clock_now());
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
    traffic->unread = outgoing_unread(&desk->answers.outgoing);
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
    hearing_go_on(&desk->hearing);
    if (bells[CONTROL].rings) bells[CONTROL].rings = take_all(desk, receive_frame);
    if (bells[TELEMETRY].rings) bells[TELEMETRY].rings = take_all(desk, receive_subscription);
    publisher_greet(desk->publisher);
}
