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
    zmq_close(other);
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
    zmq_close(other);
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
    assert_true(reply->status->wall_s > 0 && reply->status->wall_s < 0.5);
    assert_true(reply->status->age_s >= 0.6);
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
        cmocka_unit_test_setup_teardown(pauses_count_as_age_and_not_as_computing, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(rates_are_known_from_the_first_step, steer_begin, steer_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
