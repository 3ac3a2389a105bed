/* SPDX-License-Identifier: BSD-3-Clause */
/* Loading what is too big or takes too long: neither ends the daemon or makes it deaf. */
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>
#include <zmq.h>

/* A drop in a wide field, a formula for each of 8e8 points: minutes to find it, and no memory. */
static const char wide_case[] = "dimensions: 2\n"
                                "resolution: 20000\n"
                                "domain: {min: [0, 0], max: [2, 1]}\n"
                                "fluids:\n"
                                "  - {name: drop, density: 1, sound_speed: 1, shape: [{formula: x*x + y*y < 1e-6}]}\n"
                                "end_time: 1\n"
                                "threads: 1\n";

static const double SOON = 15; /* [s] */

static void wait_for_loading(Dialogue *dialogue)
{
    bool loading = false;
    for (const double until = steer_now() + 60; !loading;) {
        Meniscus__Reply *reply = steer_status(dialogue);
        loading = reply->status->state == MENISCUS__STATE__LOADING;
        meniscus__reply__free_unpacked(reply, NULL);
        assert_less(steer_now(), until);
        steer_sleep(10);
    }
}

static void ask_to_load(void *socket, uint8_t *id, uint64_t deadline_ms)
{
    LoadRequest load;
    dialogue_load_init(&load, "wide", wide_case, NULL);
    load.request.has_deadline_ms = deadline_ms > 0;
    load.request.deadline_ms = deadline_ms;
    dialogue_seal(&load.request, id);
    dialogue_send(socket, &load.request);
    dialogue_load_done(&load);
}

/* Ask for the wide case, and see it being loaded. */
static void begin_loading(Dialogue *dialogue, void *socket, uint8_t *id)
{
    ask_to_load(socket, id, 0);
    wait_for_loading(dialogue);
}

static void assert_ended(void *socket, const uint8_t *id, Meniscus__Code code, const char *part)
{
    Meniscus__Reply *reply = dialogue_receive(socket, NULL);
    assert_non_null(reply);
    assert_memory_equal(reply->id.data, id, 16);
    steer_refused(reply, code, part);
}

static void assert_nothing_is_left(const Dialogue *dialogue)
{
    char state[256];
    steer_path(dialogue, "", state);
    assert_int_equal(steer_count(state, "wide"), 0);
}

static void a_stop_ends_a_load_that_takes_long(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    void *other = dialogue_connect(dialogue);
    begin_loading(dialogue, other, id);
    const double asked = steer_now();
    assert_int_equal(steer_code(dialogue, dialogue_stop()), MENISCUS__CODE__OK);
    assert_less(steer_now() - asked, SOON);
    assert_ended(other, id, MENISCUS__CODE__ABORTED, "called off");
    steer_stands_at(dialogue, MENISCUS__STATE__EMPTY, 0);
    assert_nothing_is_left(dialogue);
}

/* Who stops wants no run: not the next one, and not that before. */
static void a_stop_ends_the_run_before_the_load_too(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    void *other = dialogue_connect(dialogue);
    dialogue_load(dialogue, NULL);
    begin_loading(dialogue, other, id);
    assert_int_equal(steer_code(dialogue, dialogue_stop()), MENISCUS__CODE__OK);
    assert_ended(other, id, MENISCUS__CODE__ABORTED, "called off");
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_int_equal(reply->status->state, MENISCUS__STATE__EMPTY);
    meniscus__reply__free_unpacked(reply, NULL);
}

/* A request to cancel the command of this id, in room of the caller's. */
static void make_cancel(Meniscus__Request *request, Meniscus__Cancel *command, uint8_t *id)
{
    meniscus__request__init(request);
    meniscus__cancel__init(command);
    command->has_id = 1;
    command->id = (ProtobufCBinaryData){.len = 16, .data = id};
    request->command_case = MENISCUS__REQUEST__COMMAND_CANCEL;
    request->cancel = command;
}

static Meniscus__Code cancel(Dialogue *dialogue, uint8_t *id)
{
    Meniscus__Request request;
    Meniscus__Cancel command;
    make_cancel(&request, &command, id);
    return dialogue_code(dialogue, &request);
}

static void a_load_that_is_cancelled_leaves_the_run_before_it(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    void *other = dialogue_connect(dialogue);
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 2);
    begin_loading(dialogue, other, id);
    const double asked = steer_now();
    assert_int_equal(cancel(dialogue, id), MENISCUS__CODE__OK);
    assert_less(steer_now() - asked, SOON);
    assert_ended(other, id, MENISCUS__CODE__ABORTED, "called off");
    steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, 2);
}

/* An id that nobody has, and one that is none. */
static void cancelling_something_else_does_not_end_a_load(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16], unknown[16] = "somebody else's", zeros[16] = {0}, zeros_id[16];
    void *other = dialogue_connect(dialogue), *third = dialogue_connect(dialogue);
    Meniscus__Request request;
    Meniscus__Cancel command;
    uint8_t cancel_id[16];
    begin_loading(dialogue, other, id);
    make_cancel(&request, &command, unknown);
    dialogue_seal(&request, cancel_id);
    dialogue_send(third, &request);
    make_cancel(&request, &command, zeros);
    dialogue_seal(&request, zeros_id);
    dialogue_send(third, &request);
    steer_sleep(300);
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_int_equal(reply->status->state, MENISCUS__STATE__LOADING);
    meniscus__reply__free_unpacked(reply, NULL);
    assert_int_equal(steer_code(dialogue, dialogue_stop()), MENISCUS__CODE__OK);
    assert_ended(third, cancel_id, MENISCUS__CODE__NOT_FOUND, "");
    assert_ended(third, zeros_id, MENISCUS__CODE__INVALID_ARGUMENT, "not all zero");
}

static void a_load_ends_at_its_deadline(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    void *other = dialogue_connect(dialogue);
    const double asked = steer_now();
    ask_to_load(other, id, 1000);
    assert_ended(other, id, MENISCUS__CODE__DEADLINE_EXCEEDED, "deadline");
    assert_less(steer_now() - asked, 1 + SOON);
    steer_stands_at(dialogue, MENISCUS__STATE__EMPTY, 0);
}

static void shutdown_does_not_wait_for_a_load(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    void *other = dialogue_connect(dialogue);
    begin_loading(dialogue, other, id);
    const double asked = steer_now();
    assert_int_equal(steer_code(dialogue, dialogue_shutdown()), MENISCUS__CODE__OK);
    assert_less(steer_now() - asked, SOON);
    assert_ended(other, id, MENISCUS__CODE__ABORTED, "called off");
    dialogue_hang_up(dialogue);
    assert_int_equal(dialogue_join(dialogue), 0);
}

static void a_signal_does_not_wait_for_a_load(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    void *other = dialogue_connect(dialogue);
    begin_loading(dialogue, other, id);
    const double asked = steer_now();
    assert_int_equal(kill(dialogue->daemon, SIGTERM), 0);
    assert_ended(other, id, MENISCUS__CODE__ABORTED, "called off");
    dialogue_hang_up(dialogue);
    assert_int_equal(dialogue_join(dialogue), 0);
    assert_less(steer_now() - asked, 1 + SOON); /* with the time that clients get to read */
}

/* Linux promises more memory than it has, so that nothing is noticed before a process is killed. The test has 2 GB of addresses
 * left to it instead. */
static void a_case_too_big_for_memory_is_refused_with_both_figures(void **state)
{
    enum { ADDRESSES = 2000000000 };
    static const char *const settings[] = {"resolution=12000", NULL};
    Dialogue *dialogue = *state;
    LoadRequest load;
    if (getenv("MENISCUS_SANITIZED")) skip(); /* its shadow memory takes more addresses than that */
    dialogue_load(dialogue, NULL);
    assert_int_equal(prlimit(dialogue->daemon, RLIMIT_AS, &(struct rlimit){ADDRESSES, ADDRESSES}, NULL), 0);
    dialogue_load_init(&load, "dam", dialogue_case, settings);
    Meniscus__Reply *reply = dialogue_ask(dialogue, &load.request);
    assert_string_equal(reply->path, "resolution");
    assert_string_equal(reply->reason, "out of memory");
    assert_non_null(strstr(reply->message, "GB are left of its limit of addresses"));
    steer_refused(reply, MENISCUS__CODE__RESOURCE_EXHAUSTED, "GB of memory");
    dialogue_load_done(&load);
    steer_go(dialogue, 3); /* what was there before goes on */
}

#define OF_ITS_OWN(test) cmocka_unit_test_setup_teardown(test, steer_begin, steer_end)
#define TO_THE_END(test) cmocka_unit_test_setup_teardown(test, steer_begin, steer_end_somehow)

int main(void)
{
    const struct CMUnitTest tests[] = {
        OF_ITS_OWN(a_stop_ends_a_load_that_takes_long),
        OF_ITS_OWN(a_stop_ends_the_run_before_the_load_too),
        OF_ITS_OWN(a_load_that_is_cancelled_leaves_the_run_before_it),
        OF_ITS_OWN(cancelling_something_else_does_not_end_a_load),
        OF_ITS_OWN(a_load_ends_at_its_deadline),
        TO_THE_END(shutdown_does_not_wait_for_a_load),
        TO_THE_END(a_signal_does_not_wait_for_a_load),
        OF_ITS_OWN(a_case_too_big_for_memory_is_refused_with_both_figures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
