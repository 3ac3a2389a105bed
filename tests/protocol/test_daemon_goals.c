/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a run is to go and how long it takes: goals, those who wait, and the clocks. */
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <stdio.h>
#include <zmq.h>

static void a_time_beyond_the_end_is_refused_with_the_bounds(void **state)
{
    Dialogue *dialogue = *state;
    static const char *const settings[] = {"end_time=0.05", NULL};
    dialogue_load(dialogue, settings);
    steer_refused(steer_until(dialogue, 0.06), MENISCUS__CODE__INVALID_ARGUMENT, "0.05");
    steer_stands_at(dialogue, MENISCUS__STATE__READY, 0);
    Meniscus__Reply *reply = steer_until(dialogue, 0.05);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_int_equal(reply->state, MENISCUS__STATE__DONE);
    assert_true(reply->time == 0.05);
    meniscus__reply__free_unpacked(reply, NULL);
}

/* Send run_until, move the end before its goal, and see what is said. */
static void an_end_that_comes_before_the_goal_is_no_success(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    void *other = dialogue_connect(dialogue);
    uint8_t id[16];
    steer_say_until(other, 900, id);
    steer_accepted(steer_wait_step(dialogue, 1));
    assert_int_equal(steer_code(dialogue, dialogue_pause()), MENISCUS__CODE__OK);
    meniscus__reply__free_unpacked(dialogue_receive(other, NULL), NULL);
    steer_say_until(other, 900, id);
    steer_accepted(steer_wait_step(dialogue, 3));
    Meniscus__Reply *reply = steer_status(dialogue);
    char end[64];
    snprintf(end, sizeof end, "%.17g", reply->time + 0.5);
    meniscus__reply__free_unpacked(reply, NULL);
    steer_accepted(steer_set(dialogue, "end_time", end));
    reply = dialogue_receive(other, NULL);
    assert_non_null(reply);
    assert_int_equal(reply->state, MENISCUS__STATE__DONE);
    steer_refused(reply, MENISCUS__CODE__ABORTED, "end time");
}

/* A command that is meant for one step only. */
static Meniscus__Reply *only_at(Dialogue *dialogue, Meniscus__Request request, uint64_t step)
{
    request.has_if_step = true;
    request.if_step = step;
    return dialogue_ask(dialogue, &request);
}

static void a_command_for_another_step_does_nothing(void **state)
{
    Dialogue *dialogue = *state;
    steer_refused(only_at(dialogue, dialogue_stop(), 0), MENISCUS__CODE__FAILED_PRECONDITION, "there is no run");
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 3);
    const Meniscus__Request commands[] = {dialogue_resume(), dialogue_pause(),    dialogue_stop(),
                                          dialogue_reset(),  dialogue_shutdown(), dialogue_checkpoint()};
    for (size_t k = 0; k < sizeof commands / sizeof *commands; k++) {
        Meniscus__Reply *reply = only_at(dialogue, commands[k], 2);
        assert_string_equal(reply->path, "if_step");
        assert_int_equal(reply->step, 3);
        assert_false(reply->has_effect_step);
        steer_refused(reply, MENISCUS__CODE__FAILED_PRECONDITION, "the run is at step 3, not 2; nothing was done");
        steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, 3);
    }
    steer_refused(only_at(dialogue, dialogue_status(), 3), MENISCUS__CODE__INVALID_ARGUMENT, "status takes no if_step");
    steer_accepted(only_at(dialogue, dialogue_reset(), 3));
    steer_stands_at(dialogue, MENISCUS__STATE__READY, 0);
}

static void a_shutdown_that_comes_too_late_does_nothing(void **state)
{
    Dialogue *dialogue = *state;
    Meniscus__Request request = dialogue_shutdown();
    request.has_deadline_ms = true;
    request.deadline_ms = 0;
    steer_refused(dialogue_ask(dialogue, &request), MENISCUS__CODE__DEADLINE_EXCEEDED, "nothing was done");
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 1);
}

/* A pause for a step that has passed neither pauses nor calls off what is queued; the one for the right step may. */
static void a_pause_for_another_step_calls_nothing_off(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    void *other = dialogue_connect(dialogue);
    uint8_t id[16];
    steer_say_until(other, 0.02, id);
    steer_accepted(steer_wait_step(dialogue, 1));
    steer_refused(only_at(dialogue, dialogue_pause(), 0), MENISCUS__CODE__FAILED_PRECONDITION,
                  "not 0; nothing was done");
    Meniscus__Reply *reply = dialogue_receive(other, NULL);
    assert_non_null(reply);
    assert_true(reply->time == 0.02);
    const uint64_t step = reply->step;
    steer_accepted(reply);
    steer_accepted(only_at(dialogue, dialogue_pause(), step));
}

static void a_wait_takes_effect_when_what_it_waits_for_came_about(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    void *other = dialogue_connect(dialogue); /* one connection for both: the wait begins before the first step */
    uint8_t id[16], start_id[16];
    Meniscus__Request start = dialogue_start();
    steer_say_wait(other, 40, id);
    dialogue_say(other, &start, start_id);
    steer_accepted(dialogue_receive(other, NULL));
    Meniscus__Reply *reply = dialogue_receive(other, NULL);
    assert_non_null(reply);
    assert_memory_equal(reply->id.data, id, sizeof id);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_int_equal(reply->effect_step, 40);
    meniscus__reply__free_unpacked(reply, NULL);
    reply = steer_status(dialogue);
    assert_false(reply->has_effect_step); /* looking has no effect */
    meniscus__reply__free_unpacked(reply, NULL);
}

static void pauses_count_as_age_and_not_as_computing(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 2);
    steer_sleep(600);
    steer_go(dialogue, 2);
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_true(reply->status->wall_s > 0);
    assert_true(reply->status->age_s >= reply->status->wall_s + 0.6);
    assert_false(reply->status->has_steps_per_second);
    meniscus__reply__free_unpacked(reply, NULL);
}

static void rates_are_known_from_the_first_step(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    steer_accepted(steer_wait_step(dialogue, 1));
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_true(reply->status->has_steps_per_second && reply->status->steps_per_second > 0);
    assert_true(reply->status->has_eta_s && reply->status->eta_s > 0);
    meniscus__reply__free_unpacked(reply, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_time_beyond_the_end_is_refused_with_the_bounds, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(an_end_that_comes_before_the_goal_is_no_success, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_wait_takes_effect_when_what_it_waits_for_came_about, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_command_for_another_step_does_nothing, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_shutdown_that_comes_too_late_does_nothing, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_pause_for_another_step_calls_nothing_off, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(pauses_count_as_age_and_not_as_computing, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(rates_are_known_from_the_first_step, steer_begin, steer_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
