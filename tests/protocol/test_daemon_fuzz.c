/* SPDX-License-Identifier: BSD-3-Clause */
/* Frames of random bytes, cut requests and requests with changed bytes, against the reader of frames and the handlers: in this
 * process, so that many fit in little time. FRAMES=2000000 in the environment makes it more, SEED=n others. */
#include "base/clock.h"
#include "base/log.h"
#include "common/wire/frame.h"
#include "net/exchange.h"
#include "net/handlers.h"
#include "tests/support/check.h"
#include "tests/support/dialogue.h"
#include "tests/support/draw.h"
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zmq.h>

static uint64_t seed = 20240607;

static long from_environment(const char *name, long otherwise)
{
    const char *text = getenv(name);
    return text ? atol(text) : otherwise;
}

/* --- frames ------------------------------------------------------------------------------------------------------------ */

enum { TEMPLATES = 24, LONGEST = 1 << 20 };

typedef struct Frame {
    size_t size;
    uint8_t data[LONGEST + 64];
} Frame;

static uint8_t *template[TEMPLATES];
static size_t template_size[TEMPLATES];
static size_t n_templates;

static void add_template(Meniscus__Request *request)
{
    uint8_t id[16];
    dialogue_seal(request, id);
    const size_t size = meniscus__request__get_packed_size(request);
    template[n_templates] = malloc(size + 1);
    template_size[n_templates] = meniscus__request__pack(request, template[n_templates]);
    n_templates++;
}

static void add_load(void)
{
    LoadRequest load;
    dialogue_load_init(&load, "dam", dialogue_case, NULL);
    add_template(&load.request);
    dialogue_load_done(&load);
}

static void add_set(void)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Set set = MENISCUS__SET__INIT;
    Meniscus__Assignment one = MENISCUS__ASSIGNMENT__INIT, two = MENISCUS__ASSIGNMENT__INIT, *list[2] = {&one, &two};
    one.path = (char *)"gravity";
    one.value = (char *)"[0, -2]";
    two.path = (char *)"end_time";
    two.value = (char *)"12";
    set.n_assignments = 2;
    set.assignments = list;
    request.command_case = MENISCUS__REQUEST__COMMAND_SET;
    request.set = &set;
    add_template(&request);
}

static void add_queries(void)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Query query = MENISCUS__QUERY__INIT;
    Meniscus__PointQuery points = MENISCUS__POINT_QUERY__INIT;
    Meniscus__ParticleQuery particles = MENISCUS__PARTICLE_QUERY__INIT;
    double at[2] = {0.5, 0.2}, corner[2] = {1, 1};
    char *fields[2] = {(char *)"velocity", (char *)"pressure"};
    request.command_case = MENISCUS__REQUEST__COMMAND_QUERY;
    request.query = &query;
    points.field = fields[1];
    points.n_points = 2;
    points.points = at;
    query.what_case = MENISCUS__QUERY__WHAT_POINTS;
    query.points = &points;
    add_template(&request);
    particles.n_min = particles.n_max = particles.n_fields = 2;
    particles.min = at;
    particles.max = corner;
    particles.fields = fields;
    query.what_case = MENISCUS__QUERY__WHAT_PARTICLES;
    query.particles = &particles;
    add_template(&request);
}

static void add_breakpoint(void)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__SetBreakpoint point = MENISCUS__SET_BREAKPOINT__INIT;
    point.name = (char *)"b";
    point.condition = (char *)"front > 2.1 and t < 3";
    request.command_case = MENISCUS__REQUEST__COMMAND_BREAKPOINT;
    request.breakpoint = &point;
    add_template(&request);
}

/* Every command with nothing in it. */
static void add_bare(void)
{
    for (unsigned k = 0; k < meniscus__request__descriptor.n_fields; k++) {
        const ProtobufCFieldDescriptor *field = &meniscus__request__descriptor.fields[k];
        const uint32_t tag = field->id;
        if (!(field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF)) continue;
        assert_true(n_templates < TEMPLATES);
        if (tag == MENISCUS__REQUEST__COMMAND_LOAD || tag == MENISCUS__REQUEST__COMMAND_SET) continue;
        if (tag == MENISCUS__REQUEST__COMMAND_QUERY || tag == MENISCUS__REQUEST__COMMAND_BREAKPOINT) continue;
        Meniscus__Request request = MENISCUS__REQUEST__INIT;
        add_template(&request);
        uint8_t *end = template[n_templates - 1] = realloc(template[n_templates - 1], 64);
        end += template_size[n_templates - 1];
        const unsigned key = tag << 3 | 2;
        memcpy(end, (const uint8_t[3]){(uint8_t)(key | 0x80), (uint8_t)(key >> 7), 0}, 3);
        template_size[n_templates - 1] += 3;
    }
}

static void make_templates(void)
{
    add_load();
    add_set();
    add_queries();
    add_breakpoint();
    add_bare();
}

/* Mostly small; one in five thousand large. */
static size_t draw_size(void)
{
    const uint64_t kind = draw(&seed) % 5000;
    return draw(&seed) % (kind == 0 ? LONGEST + 32 : kind < 50 ? 4096 : 64);
}

static void draw_noise(Frame *frame)
{
    frame->size = draw_size();
    for (size_t k = 0; k < frame->size; k += 8) {
        const uint64_t word = draw(&seed);
        memcpy(frame->data + k, &word, 8);
    }
}

static void draw_mutant(Frame *frame)
{
    const size_t k = draw(&seed) % n_templates;
    frame->size = template_size[k];
    memcpy(frame->data, template[k], frame -> size);
    for (uint64_t n = draw(&seed) % 4; n > 0; n--) frame->data[draw(&seed) % frame->size] = (uint8_t)draw(&seed);
    if (draw(&seed) % 4 == 0) frame->size = draw(&seed) % (frame->size + 1);
}

static void draw_frame(Frame *frame)
{
    if (draw(&seed) % 3 == 0) draw_noise(frame);
    else draw_mutant(frame);
}

/* --- the handlers ------------------------------------------------------------------------------------------------------ */

typedef struct Bench {
    Run *run;
    char home[64];
    long under_way, answered;
} Bench;

/* What comes back is completed as for a client, and dropped. */
static void take_answers(Bench *bench)
{
    for (Note *note; (note = outbox_take(run_outbox(bench->run)));) {
        if (note->kind != NOTE_ANSWER) {
            note_free(note);
            continue;
        }
        Exchange *exchange = (Exchange *)note->order;
        if (!exchange->sealed) exchange_seal(exchange);
        exchange_free(exchange);
        bench->under_way--;
        bench->answered++;
    }
}

/* Those that would end the test, or fill the disk; they have tests of their own. */
static bool left_out(const Meniscus__Request *request)
{
    const Meniscus__Request__CommandCase command = request->command_case;
    if (command == MENISCUS__REQUEST__COMMAND_SHUTDOWN) return true;
    const bool writes = command == MENISCUS__REQUEST__COMMAND_LOAD || command == MENISCUS__REQUEST__COMMAND_RESET ||
                        command == MENISCUS__REQUEST__COMMAND_CHECKPOINT ||
                        command == MENISCUS__REQUEST__COMMAND_SNAPSHOT || command == MENISCUS__REQUEST__COMMAND_RESTORE;
    return writes && draw(&seed) % 500 != 0;
}

/* Takes over the request. */
static void post(Bench *bench, Meniscus__Request *request)
{
    MnsError error;
    Exchange *exchange = exchange_new(request, &(Who){WHO_LOCAL, ROLE_ADMIN});
    exchange->order.deadline = clock_now() + 0.02; /* or waits would pile up */
    if (handle(bench->run, exchange, &error)) exchange_free(exchange);
    else bench->under_way++;
    struct pollfd wake = {.fd = run_outbox(bench->run)->wake, .events = POLLIN};
    while (bench->under_way > 200 && poll(&wake, 1, 20) > 0) take_answers(bench);
    take_answers(bench);
}

static void feed(Bench *bench, const Frame *frame)
{
    Meniscus__Request *request;
    MnsError error;
    const MnsStatus status = request_read(frame->data, frame->size, &request, &error);
    if (status || left_out(request)) {
        assert_true(!status || strlen(error.text) > 10);
        request_free(request);
        return;
    }
    post(bench, request);
}

/* A stop that got through leaves no case, and no frame after it would meet one. */
static void load_again(Bench *bench, Frame *frame)
{
    Meniscus__Request *request;
    frame->size = template_size[0];
    memcpy(frame->data, template[0], frame -> size);
    assert_int_equal(request_read(frame->data, frame->size, &request, NULL), MNS_OK);
    post(bench, request);
}

static void leave(Run *run, Order *order)
{
    run_leave(run, order, false);
}

static Exchange *last_order(void)
{
    Meniscus__Request *request = malloc(sizeof *request);
    meniscus__request__init(request);
    Exchange *exchange = exchange_new(request, &(Who){WHO_LOCAL, ROLE_ADMIN});
    exchange->order.serve = leave;
    return exchange;
}

static void frames_of_all_kinds_do_no_harm_in_process(void **state)
{
    (void)state;
    static Frame frame;
    Bench bench = {.home = "/tmp/mns-fuzz-XXXXXX"};
    char command[128];
    MnsError error;
    assert_non_null(mkdtemp(bench.home));
    log_set_level(LOG_ERROR);
    const RunOptions options = {.directory = bench.home};
    assert_int_equal(run_new(&options, &bench.run, &error), MNS_OK);
    for (long k = from_environment("FRAMES", getenv("MENISCUS_SANITIZED") ? 30000 : 100000); k > 0; k--) {
        if (k % 2000 == 0) load_again(&bench, &frame);
        draw_frame(&frame);
        feed(&bench, &frame);
    }
    Exchange *last = last_order();
    while (run_post(bench.run, &last->order, &error)) take_answers(&bench);
    bench.under_way++;
    run_join(bench.run);
    take_answers(&bench);
    assert_int_equal(bench.under_way, 0);
    print_message("%ld commands answered\n", bench.answered);
    run_free(bench.run);
    snprintf(command, sizeof command, "rm -rf %s", bench.home);
    assert_int_equal(system(command), 0);
}

/* --- the sockets ------------------------------------------------------------------------------------------------------- */

/* Send frames to one socket of a running daemon; nobody waits for answers. It lingers, as libzmq aborts in this process when
 * the daemon hangs up on a message of several parts that a close has cut off (session_base.cpp, clean_pipes). */
static void pelt(void *context, const char *endpoint, int type, long n)
{
    static Frame frame;
    static const int soon = 200, last_words = 5000;
    void *socket = zmq_socket(context, type);
    zmq_setsockopt(socket, ZMQ_LINGER, &last_words, sizeof last_words);
    zmq_setsockopt(socket, ZMQ_SNDTIMEO, &soon, sizeof soon);
    assert_int_equal(zmq_connect(socket, endpoint), 0);
    for (; n > 0; n--) {
        draw_frame(&frame);
        Meniscus__Request *request;
        MnsError error;
        const bool ends = !request_read(frame.data, frame.size, &request, &error) && left_out(request);
        request_free(request);
        if (!ends) zmq_send(socket, frame.data, frame.size, draw(&seed) % 8 == 0 ? ZMQ_SNDMORE : 0);
        zmq_msg_t answer;
        zmq_msg_init(&answer);
        while (zmq_msg_recv(&answer, socket, ZMQ_DONTWAIT) >= 0) continue;
        zmq_msg_close(&answer);
    }
    zmq_close(socket);
}

static void every_socket_stands_frames_of_all_kinds(void **state)
{
    (void)state;
    Dialogue dialogue;
    char endpoint[4][160], port[16];
    const int base = 20000 + 2 * (int)(getpid() % 6000); /* below those that the kernel gives to connections */
    snprintf(port, sizeof port, "%d", base);
    dialogue_begin(&dialogue, (const char *const[]){"--tcp", port, NULL});
    dialogue_load(&dialogue, NULL);
    snprintf(endpoint[0], sizeof *endpoint, "%s", dialogue.endpoint);
    snprintf(endpoint[1], sizeof *endpoint, "tcp://127.0.0.1:%d", base);
    snprintf(endpoint[2], sizeof *endpoint, "ipc://%s/meniscus/t/telemetry.ipc", dialogue.home);
    snprintf(endpoint[3], sizeof *endpoint, "tcp://127.0.0.1:%d", base + 1);
    for (size_t k = 0; k < 4; k++)
        for (int again = 0; again < 5; again++) {
            pelt(dialogue.context, endpoint[k], k < 2 ? ZMQ_DEALER : ZMQ_XSUB, 400);
            Meniscus__Request request = dialogue_status();
            assert_int_equal(dialogue_code(&dialogue, &request), MENISCUS__CODE__OK);
        }
    assert_int_equal(dialogue_end(&dialogue), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_of_all_kinds_do_no_harm_in_process),
        cmocka_unit_test(every_socket_stands_frames_of_all_kinds),
    };
    seed = (uint64_t)from_environment("SEED", (long)seed);
    make_templates();
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    for (size_t k = 0; k < n_templates; k++) free(template[k]);
    return failed;
}
