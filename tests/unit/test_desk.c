/* SPDX-License-Identifier: BSD-3-Clause */
/* Whoever asks is answered, once, under the id of the request: also when there is no memory for the answer. */
#include "net/desk.h"
#include "tests/support/check.h"
#include "tests/support/dialogue.h"
#include "tests/support/io_fixture.h"
#include "tests/support/memory.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

/* A desk and a client on this thread, and a run. */
typedef struct Bench {
    char *home;
    Run *run;
    Desk *desk;
    Dialogue client;
    Order leave;
} Bench;

static void serve(const Bench *bench);

/* Have the client let in, which takes memory of ZeroMQ: it ends the program where there is none. */
static int let_in(const Bench *bench)
{
    const int wake = run_outbox(bench->run)->wake, fds[2] = {wake, wake};
    Meniscus__Request request = dialogue_status();
    zmq_pollitem_t item = {.socket = bench->client.control, .events = ZMQ_POLLIN};
    uint8_t id[16];
    dialogue_say(bench->client.control, &request, id);
    for (int k = 0; k < 500 && zmq_poll(&item, 1, 10) < 1; k++) {
        desk_poll(bench->desk, fds, 10);
        serve(bench);
    }
    Meniscus__Reply *reply = item.revents ? dialogue_receive(bench->client.control, NULL) : NULL;
    if (!reply) return 1;
    meniscus__reply__free_unpacked(reply, NULL);
    return 0;
}

static int begin(void **state)
{
    Bench *bench = calloc(1, sizeof *bench);
    Endpoint at = {.tcp_control = ""};
    *state = bench;
    bench->home = scratch_new();
    const RunOptions options = {.parent = bench->home};
    snprintf(at.control, sizeof at.control, "ipc://%.64s/control", bench->home);
    snprintf(at.telemetry, sizeof at.telemetry, "ipc://%.64s/telemetry", bench->home);
    memcpy(bench->client.endpoint, at.control, sizeof bench->client.endpoint);
    if (run_new(&options, &bench->run, NULL) || desk_new(&at, bench->run, &bench->desk, NULL)) return 1;
    bench->client.context = zmq_ctx_new();
    bench->client.control = dialogue_connect(&bench->client);
    return let_in(bench);
}

static void serve_leave(Run *run, Order *order)
{
    run_leave(run, order, false);
}

static void answer_all(const Bench *bench)
{
    for (Note *note; (note = outbox_take(run_outbox(bench->run)));) {
        if (note->kind != NOTE_ANSWER) note_free(note);
        else if (note->order != &bench->leave) answers_reply(desk_answers(bench->desk), (Exchange *)note->order);
    }
}

/* What the daemon does when something has come. */
static void serve(const Bench *bench)
{
    desk_receive(bench->desk);
    answer_all(bench);
}

static int end(void **state)
{
    Bench *bench = *state;
    zmq_close(bench->client.control);
    zmq_ctx_term(bench->client.context);
    bench->leave = (Order){.serve = serve_leave, .deadline = INFINITY};
    run_post(bench->run, &bench->leave, NULL);
    run_join(bench->run);
    answer_all(bench); /* who waits, that it stops */
    desk_end_streams(bench->desk);
    run_free(bench->run);
    desk_free(bench->desk);
    scratch_free(bench->home);
    free(bench);
    return 0;
}

/* Ask, with memory that fails while the desk is at it: after n allocations, or at once and for good. NULL: no answer. */
static Meniscus__Reply *ask_hard(const Bench *bench, Meniscus__Request *request, long n)
{
    uint8_t id[16];
    const int wake = run_outbox(bench->run)->wake, fds[2] = {wake, wake};
    dialogue_seal(request, id);
    dialogue_send(bench->client.control, request);
    for (int k = 0; k < 100; k++) {
        zmq_pollitem_t item = {.socket = bench->client.control, .events = ZMQ_POLLIN};
        desk_poll(bench->desk, fds, 100);
        memory_fails_after(n);
        memory_is_gone(n < 0);
        serve(bench);
        memory_is_gone(false);
        memory_fails_after(-1);
        if (zmq_poll(&item, 1, 20) < 1) continue;
        Meniscus__Reply *reply = dialogue_receive(bench->client.control, NULL);
        assert_non_null(reply);
        assert_true(reply->has_id);
        assert_memory_equal(reply->id.data, id, sizeof id);
        return reply;
    }
    return NULL;
}

static void assert_answered_whatever_fails(const Bench *bench, Meniscus__Request ask, long allocations)
{
    int refused = 0;
    for (long n = 0; n < allocations; n++) {
        Meniscus__Request request = ask;
        Meniscus__Reply *reply = ask_hard(bench, &request, n);
        if (!reply) fail_msg("no answer when allocation %ld fails", n);
        refused += reply->code != MENISCUS__CODE__OK;
        if (reply->code != MENISCUS__CODE__OK) {
            assert_int_equal(reply->code, MENISCUS__CODE__RESOURCE_EXHAUSTED);
            assert_non_null(strstr(reply->message, "memory"));
        }
        meniscus__reply__free_unpacked(reply, NULL);
    }
    assert_in_range(refused, 4, allocations - 1);
}

static Meniscus__Request capabilities_request(void)
{
    static Meniscus__GetCapabilities all = MENISCUS__GET_CAPABILITIES__INIT;
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    request.command_case = MENISCUS__REQUEST__COMMAND_CAPABILITIES;
    request.capabilities = &all;
    return request;
}

/* More allocations than an answer takes. */
static void whatever_allocation_fails_there_is_an_answer_under_the_id(void **state)
{
    if (!memory_can_fail) skip();
    assert_answered_whatever_fails(*state, dialogue_status(), 40);
    assert_answered_whatever_fails(*state, capabilities_request(), 700);
}

/* Words take memory, but not a code. */
static void where_there_is_no_memory_at_all_there_is_a_code_under_the_id(void **state)
{
    const Bench *bench = *state;
    if (!memory_can_fail) skip();
    for (int k = 0; k < 3; k++) {
        Meniscus__Request request = dialogue_status();
        Meniscus__Reply *reply = ask_hard(bench, &request, -1);
        assert_non_null(reply);
        assert_int_equal(reply->code, MENISCUS__CODE__RESOURCE_EXHAUSTED);
        meniscus__reply__free_unpacked(reply, NULL);
    }
}

/* Ask n times the same, each under an id of its own, and take so many answers; how many have this code. */
static size_t ask_often(const Bench *bench, Meniscus__Request ask, size_t n, size_t answers, Meniscus__Code code)
{
    const int wake = run_outbox(bench->run)->wake, fds[2] = {wake, wake};
    size_t found = 0, answered = 0;
    for (size_t sent = 0, k = 0; answered < answers && k < 100000; k++) {
        zmq_pollitem_t item = {.socket = bench->client.control, .events = ZMQ_POLLIN};
        const bool few = answers < n || sent < answered + 800; /* as more would be refused */
        for (size_t end = sent + 200; few && sent < n && sent < end; sent++) {
            Meniscus__Request request = ask;
            uint8_t id[16];
            dialogue_say(bench->client.control, &request, id);
        }
        desk_poll(bench->desk, fds, 1);
        serve(bench);
        while (zmq_poll(&item, 1, 0) > 0) {
            Meniscus__Reply *reply = dialogue_receive(bench->client.control, NULL);
            found += reply->code == code;
            answered++;
            meniscus__reply__free_unpacked(reply, NULL);
        }
    }
    return found;
}

static Meniscus__Reply *ask(const Bench *bench, Meniscus__Request *request, const uint8_t *again)
{
    const int wake = run_outbox(bench->run)->wake, fds[2] = {wake, wake};
    uint8_t id[16];
    dialogue_seal(request, id);
    if (again) memcpy(id, again, sizeof id);
    dialogue_send(bench->client.control, request);
    for (int k = 0; k < 1000; k++) {
        zmq_pollitem_t item = {.socket = bench->client.control, .events = ZMQ_POLLIN};
        desk_poll(bench->desk, fds, 10);
        serve(bench);
        while (zmq_poll(&item, 1, 0) > 0) {
            Meniscus__Reply *reply = dialogue_receive(bench->client.control, NULL);
            if (!memcmp(reply->id.data, id, sizeof id)) return reply;
            meniscus__reply__free_unpacked(reply, NULL);
        }
    }
    fail_msg("no answer");
    return NULL;
}

/* Neither by having waits under way without end, nor by having more replies remembered than are. */
static void who_only_asks_keeps_nobody_from_doing_something_once(void **state)
{
    enum { MANY = 4200 };
    const Bench *bench = *state;
    Meniscus__Wait wait = MENISCUS__WAIT__INIT, none = MENISCUS__WAIT__INIT;
    Meniscus__Lease lease = MENISCUS__LEASE__INIT;
    Meniscus__State done = MENISCUS__STATE__DONE;
    Meniscus__Request request = MENISCUS__REQUEST__INIT, waits = request, bad = request;
    wait.n_states = 1;
    wait.states = &done;
    waits.command_case = bad.command_case = MENISCUS__REQUEST__COMMAND_WAIT;
    waits.wait = &wait;
    bad.wait = &none;
    lease.has_ttl_ms = 1;
    lease.ttl_ms = 60000;
    lease.holder = (char *)"anna";
    request.command_case = MENISCUS__REQUEST__COMMAND_LEASE;
    request.lease = &lease;
    assert_in_range(ask_often(bench, waits, MANY, MANY - 1024, MENISCUS__CODE__RESOURCE_EXHAUSTED), MANY - 1024, MANY);
    Meniscus__Reply *first = ask(bench, &request, NULL);
    assert_int_equal(first->code, MENISCUS__CODE__OK);
    assert_int_equal(ask_often(bench, bad, MANY, MANY, MENISCUS__CODE__INVALID_ARGUMENT), MANY);
    Meniscus__Reply *again = ask(bench, &request, first->id.data);
    assert_int_equal(again->code, MENISCUS__CODE__OK);
    assert_int_equal(again->lease->epoch, first->lease->epoch);
    meniscus__reply__free_unpacked(first, NULL);
    meniscus__reply__free_unpacked(again, NULL);
}

/* Each empty one would be the whole case. */
static void entries_that_are_asked_for_are_counted_before_they_are_printed(void **state)
{
    static char *paths[129];
    Meniscus__Get get = MENISCUS__GET__INIT;
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    for (size_t k = 0; k < 129; k++) paths[k] = (char *)"";
    get.paths = paths;
    request.command_case = MENISCUS__REQUEST__COMMAND_GET;
    request.get = &get;
    for (get.n_paths = 128; get.n_paths <= 129; get.n_paths++) {
        Meniscus__Reply *reply = ask(*state, &request, NULL);
        assert_int_equal(reply->code, get.n_paths == 129 ? MENISCUS__CODE__RESOURCE_EXHAUSTED
                                                         : MENISCUS__CODE__FAILED_PRECONDITION); /* there is no case */
        meniscus__reply__free_unpacked(reply, NULL);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(whatever_allocation_fails_there_is_an_answer_under_the_id, begin, end),
        cmocka_unit_test_setup_teardown(where_there_is_no_memory_at_all_there_is_a_code_under_the_id, begin, end),
        cmocka_unit_test_setup_teardown(who_only_asks_keeps_nobody_from_doing_something_once, begin, end),
        cmocka_unit_test_setup_teardown(entries_that_are_asked_for_are_counted_before_they_are_printed, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
