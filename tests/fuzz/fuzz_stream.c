/* SPDX-License-Identifier: BSD-3-Clause */
/* What clients send to the data socket, against the streams of a run: all of it but the thread and the door. Input: frames, each behind its length in
 * two bytes; for one without any the run makes a step. Each gets the replies that proto/README.md promises, items are no more than was granted, and whoever leaves takes all with
 * it. A stream from 1 to 8 is the one that was opened so long ago; nobody can guess the others. */
#include "base/log.h"
#include "common/case/file.h"
#include "common/wire/frame.h"
#include "net/exchange.h"
#include "net/handlers.h"
#include "net/streams_inside.h"
#include "tests/fuzz/scratch.h"
#include <poll.h>
#include <sys/eventfd.h>
#include <zmq.h>

enum { OPENED = 8, ROUNDS = 16, FRAMES = 64, MEMORY = 64 << 20, WAIT_MS = 2, STEPS = 64 };

static const char case_text[] =
    "{dimensions: 2, resolution: 4, domain: {min: [0, 0], max: [2, 1]}, gravity: [0, -1], end_time: 10, threads: 1, "
    "fluids: [{name: water, density: 1000, sound_speed: 20, shape: [{box: {min: [0, 0], max: [1, 0.5]}}]}], "
    "walls: [{name: tank, shape: [{outside: true, box: {min: [0, 0], max: [2, 1]}}]}], "
    "probes: [{name: front, front: {fluid: water}}, {name: energy, kinetic_energy: {}}], "
    "output: {snapshot_interval: 0.5, probe_interval: 0.01}}";

static const uint8_t identity[] = "fuzz";
static StreamTraffic traffic;
static Streams streams;
static void *peer;
static uint64_t opened[OPENED], granted;

/* --- a run that has written some files -------------------------------------------------------------------------------------- */

static void order(Run *run, Meniscus__Request *request)
{
    MnsError error;
    const size_t size = meniscus__request__get_packed_size(request);
    uint8_t *packed = malloc(size + 1);
    PROMISE(packed);
    meniscus__request__pack(request, packed);
    Exchange *exchange = exchange_new(meniscus__request__unpack(NULL, size, packed), &(Who){WHO_LOCAL, ROLE_ADMIN});
    PROMISE(exchange && !handle(run, exchange, &error));
    free(packed);
    struct pollfd wake = {.fd = run_outbox(run)->wake, .events = POLLIN};
    for (bool answered = false; !answered;) {
        PROMISE(poll(&wake, 1, 20000) == 1);
        for (Note *note; (note = outbox_take(run_outbox(run)));) {
            if (note->kind != NOTE_ANSWER) {
                if (note->kind == NOTE_EVENT) streams_tell(&streams, note);
                note_free(note);
                continue;
            }
            PROMISE(!note->order->status);
            exchange_free((Exchange *)note->order);
            answered = true;
        }
    }
}

static void load_and_step(Run *run)
{
    CaseFile *file = NULL;
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Load load = MENISCUS__LOAD__INIT;
    Meniscus__RunUntil until = MENISCUS__RUN_UNTIL__INIT;
    PROMISE(!case_file_parse("case", case_text, strlen(case_text), &file, NULL));
    load.case_ = (Meniscus__Case *)case_file_message(file);
    request.command_case = MENISCUS__REQUEST__COMMAND_LOAD;
    request.load = &load;
    order(run, &request);
    case_file_free(file);
    until.has_time = true;
    until.time = 0.6;
    request.command_case = MENISCUS__REQUEST__COMMAND_RUN_UNTIL;
    request.run_until = &until;
    order(run, &request);
}

/* So many at most, as each leaves something in the files. */
static void step(void)
{
    static int left = STEPS;
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Step one = MENISCUS__STEP__INIT;
    request.command_case = MENISCUS__REQUEST__COMMAND_STEP;
    request.step = &one;
    if (left-- > 0) order(streams.options.run, &request);
}

static void remove_all(void)
{
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", scratch_home);
    if (system(command)) perror(command);
}

int LLVMFuzzerInitialize(int *argc, char ***argv);

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc, (void)argv;
    void *context = zmq_ctx_new();
    Run *run = NULL;
    scratch_begin("none");
    atexit(remove_all);
    log_set_level(LOG_ERROR);
    pthread_mutex_init(&streams.lock, NULL);
    streams.wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    PROMISE(!run_new(&(RunOptions){.parent = scratch_home, .stream_memory = MEMORY}, &run, NULL));
    load_and_step(run);
    streams.options = (StreamsOptions){.context = context, .run = run, .epoch = 1, .traffic = &traffic};
    streams.limit = tap_limit(run_tap(run));
    streams.socket = zmq_socket(context, ZMQ_ROUTER);
    peer = zmq_socket(context, ZMQ_DEALER);
    zmq_setsockopt(streams.socket, ZMQ_ROUTER_MANDATORY, &(int){1}, sizeof(int));
    zmq_setsockopt(peer, ZMQ_ROUTING_ID, identity, sizeof identity);
    PROMISE(!zmq_bind(streams.socket, "inproc://data") && !zmq_connect(peer, "inproc://data"));
    streams.post = (StreamPost){.socket = streams.socket,
                                .epoch = 1,
                                .wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK),
                                .limit = streams.limit / 4,
                                .memory = &streams.memory,
                                .traffic = &traffic};
    tap_case(run_tap(run), &streams.now);
    return 0;
}

/* --- what the client gets --------------------------------------------------------------------------------------------------- */

/* What is said besides the bytes of an item is never held back: that an item or a stream is over. */
static void take_item(const Meniscus__StreamItem *item, size_t cost, size_t n)
{
    if (item->cancelled || item->ended) return;
    PROMISE(item->offset + n <= item->size && cost <= granted);
    granted -= cost;
}

static void take_reply(const Meniscus__StreamReply *reply)
{
    PROMISE(reply->has_code && (!reply->code || (reply->message && *reply->message && reply->reason)));
    if (reply->code || !reply->has_chunk_bytes) return; /* not of a subscribe */
    memmove(opened + 1, opened, sizeof opened - sizeof *opened);
    opened[0] = reply->stream;
}

/* The next message; *ret NULL: there is none. Its second frame is counted. */
static size_t receive(Meniscus__StreamMessage **ret, size_t *ret_bytes)
{
    zmq_msg_t frame;
    size_t head = 0;
    *ret = NULL;
    *ret_bytes = 0;
    zmq_msg_init(&frame);
    if (zmq_msg_recv(&frame, peer, ZMQ_DONTWAIT) >= 0) {
        head = zmq_msg_size(&frame);
        *ret = meniscus__stream_message__unpack(NULL, head, zmq_msg_data(&frame));
        PROMISE(*ret);
        if (zmq_msg_more(&frame)) {
            PROMISE(zmq_msg_recv(&frame, peer, ZMQ_DONTWAIT) >= 0 && !zmq_msg_more(&frame));
            *ret_bytes = zmq_msg_size(&frame);
        }
    }
    zmq_msg_close(&frame);
    return head + *ret_bytes;
}

/* How many replies there are, and the code of the last. */
static size_t drain(Meniscus__Code *ret)
{
    Meniscus__StreamMessage *message;
    size_t replies = 0, n;
    for (size_t cost; cost = receive(&message, &n), message; meniscus__stream_message__free_unpacked(message, NULL)) {
        if (message->what_case == MENISCUS__STREAM_MESSAGE__WHAT_ITEM) take_item(message->item, cost, n);
        if (message->what_case != MENISCUS__STREAM_MESSAGE__WHAT_REPLY) continue;
        *ret = message->reply->code;
        take_reply(message->reply);
        replies++;
    }
    return replies;
}

/* --- what it sends ---------------------------------------------------------------------------------------------------------- */

static void name_stream(uint64_t *stream)
{
    if (*stream >= 1 && *stream <= OPENED) *stream = opened[*stream - 1];
}

static void grant(uint64_t bytes)
{
    granted = bytes < UINT64_MAX - granted ? granted + bytes : UINT64_MAX;
}

/* What it grants is counted, and its streams are named; true if a reply is due whatever comes of it. */
static bool prepare(Meniscus__StreamRequest *request)
{
    switch (request->command_case) {
    case MENISCUS__STREAM_REQUEST__COMMAND_SUBSCRIBE: grant(request->subscribe->credit); return true;
    case MENISCUS__STREAM_REQUEST__COMMAND_RESUME:
        grant(request->resume->credit);
        name_stream(&request->resume->stream);
        return true;
    case MENISCUS__STREAM_REQUEST__COMMAND_UNSUBSCRIBE: name_stream(&request->unsubscribe->stream); return true;
    case MENISCUS__STREAM_REQUEST__COMMAND_CREDIT:
        grant(request->credit->bytes);
        name_stream(&request->credit->stream);
        return false;
    case MENISCUS__STREAM_REQUEST__COMMAND_CANCEL: name_stream(&request->cancel->stream); return false;
    default: return true;
    }
}

static void assert_answered(bool due, bool refused)
{
    Meniscus__Code code = MENISCUS__CODE__OK;
    const size_t n = drain(&code);
    PROMISE(n == 1 || (n == 0 && !due));
    PROMISE(n == 0 || code || (due && !refused));
}

static void send_frame(const uint8_t *data, size_t size)
{
    Meniscus__StreamRequest *request = NULL;
    MnsError error = {0};
    const MnsStatus status = stream_request_read(data, size, &request, &error);
    uint8_t *named = NULL;
    bool due = true;
    if (status) PROMISE(error.status == status && *error.text);
    else {
        due = prepare(request);
        size = meniscus__stream_request__get_packed_size(request);
        named = malloc(size + 1);
        PROMISE(named);
        meniscus__stream_request__pack(request, named);
    }
    Sender from = {.size = sizeof identity, .who = {WHO_LOCAL, ROLE_ADMIN}};
    zmq_msg_t frame;
    memcpy(from.identity, identity, sizeof identity);
    PROMISE(!zmq_msg_init_size(&frame, size));
    memcpy(zmq_msg_data(&frame), named ? named : data, size);
    streams_take(&streams, &from, &frame, 1);
    zmq_msg_close(&frame);
    assert_answered(due, status);
    stream_request_free(request);
    free(named);
}

/* A shot for who wants one at once is made by another thread. */
static void pump(void)
{
    struct pollfd wake = {.fd = tap_wake(run_tap(streams.options.run)), .events = POLLIN};
    bool waits = false;
    Meniscus__Code code;
    for (const Stream *s = streams.first; s; s = s->next) waits = waits || (s->first && s->books.credit);
    for (int k = 0; k < ROUNDS; k++) {
        streams_refresh(&streams);
        const bool any = streams_pump(&streams);
        PROMISE(!drain(&code));
        if (!any && (!waits || poll(&wake, 1, WAIT_MS) < 1)) break;
        if (!any) waits = false;
    }
    tap_woken(run_tap(streams.options.run));
}

static void leave(void)
{
    Meniscus__Code code;
    while (streams.first) streams_drop(&streams, streams.first, NULL);
    drain(&code);
    stream_post_done(&streams.post);
    stream_item_leave(streams.news);
    streams.news = NULL;
    PROMISE(!streams.channels && !streams.post.bytes && !streams.memory);
    memset(opened, 0, sizeof opened);
    granted = 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    for (int n = 0; size >= 2 && n < FRAMES; n++) {
        const size_t length = data[0] + 256u * data[1], left = size - 2, frame = length < left ? length : left;
        if (frame) send_frame(data + 2, frame);
        else step();
        pump();
        data += 2 + frame;
        size -= 2 + frame;
    }
    leave();
    return 0;
}
