/* SPDX-License-Identifier: BSD-3-Clause */
/* What the daemon writes, seen from outside: an output that fails stops the run and is not lost; a signal leaves a checkpoint. */
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <zmq.h>

static void a_failed_output_stops_the_run_and_is_written_after_resume(void **state)
{
    Dialogue *dialogue = *state;
    static const char *const settings[] = {"output.snapshot_interval=0.05", "end_time=0.5", NULL};
    char here[256];
    steer_load_here(dialogue, settings, here);
    steer_take_away(dialogue);
    steer_code(dialogue, dialogue_start()); /* refused, if the first snapshot has failed by then */
    steer_wait_for(dialogue, MENISCUS__STATE__FAULT);
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_non_null(strstr(reply->status->fault, "dam"));
    meniscus__reply__free_unpacked(reply, NULL);
    assert_int_not_equal(steer_code(dialogue, dialogue_resume()), MENISCUS__CODE__OK);
    steer_bring_back(dialogue);
    assert_int_equal(steer_code(dialogue, dialogue_resume()), MENISCUS__CODE__OK);
    steer_wait_for(dialogue, MENISCUS__STATE__DONE);
    assert_int_equal(steer_count(here, "snapshot-"), 11);
    assert_int_equal(steer_count(here, "probes.hdf"), 1);
}

enum { BLOCKED = 3000 };

/* A fault: directories stand wherever the next snapshot may go. */
static void block_a_snapshot(Dialogue *dialogue, char here[static 256])
{
    static const char *const settings[] = {"output.snapshot_interval=0.05", "end_time=0.5", NULL};
    char inside[512];
    steer_load_here(dialogue, settings, here);
    steer_go(dialogue, 5);
    for (int step = 6; step < BLOCKED; step++) {
        snprintf(inside, sizeof inside, "%s/snapshot-%010d.hdf", here, step);
        assert_int_equal(mkdir(inside, 0777), 0);
        snprintf(inside, sizeof inside, "%s/snapshot-%010d.hdf/x", here, step);
        assert_int_equal(mkdir(inside, 0777), 0);
    }
    assert_int_equal(steer_code(dialogue, dialogue_resume()), MENISCUS__CODE__OK);
    steer_wait_for(dialogue, MENISCUS__STATE__FAULT);
}

static void unblock(const char *here)
{
    char inside[512];
    for (int step = 6; step < BLOCKED; step++) {
        snprintf(inside, sizeof inside, "%s/snapshot-%010d.hdf/x", here, step);
        assert_int_equal(rmdir(inside), 0);
        *strrchr(inside, '/') = 0;
        assert_int_equal(rmdir(inside), 0);
    }
}

/* It would be the newest, and every way on would lead back into the divergence. By request or by signal. */
static void a_diverged_state_becomes_no_checkpoint(void **state)
{
    static const char *const settings[] = {"limits.density_max=1.0001", "gravity=[0, -100]", NULL};
    Dialogue *dialogue = *state;
    char here[256];
    Meniscus__Request checkpoint = dialogue_checkpoint();
    steer_load_here(dialogue, settings, here);
    Meniscus__Request first = dialogue_checkpoint();
    assert_int_equal(dialogue_code(dialogue, &first), MENISCUS__CODE__OK);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    steer_wait_for(dialogue, MENISCUS__STATE__FAULT);
    Meniscus__Reply *reply = dialogue_ask(dialogue, &checkpoint);
    steer_refused(reply, MENISCUS__CODE__FAILED_PRECONDITION, "a snapshot shows the state");
    Meniscus__Request resume = dialogue_resume();
    steer_refused(dialogue_ask(dialogue, &resume), MENISCUS__CODE__FAILED_PRECONDITION,
                  "the simulation has diverged; restore a checkpoint, the last is checkpoint-");
    assert_int_equal(kill(dialogue->daemon, SIGUSR1), 0);
    for (int k = 0; steer_count(here, "snapshot-") < 1 && k < 600; k++) steer_sleep(100);
    assert_int_equal(steer_count(here, "checkpoint-"), 1);
    assert_int_equal(steer_count(here, "snapshot-"), 1); /* what there is to be seen */
    steer_accepted(steer_restore(dialogue, NULL));
    steer_stands_at(dialogue, MENISCUS__STATE__READY, 0);
}

static void assert_kept(const char *here, uint64_t step)
{
    char name[512];
    snprintf(name, sizeof name, "%s/checkpoint-%010llu.hdf", here, (unsigned long long)step);
    assert_int_equal(access(name, F_OK), 0);
    snprintf(name, sizeof name, "%s/probes.hdf", here);
    assert_int_equal(access(name, F_OK), 0);
}

/* A run that goes on from a checkpoint writes nothing again that came before it. */
static void a_checkpoint_comes_only_behind_an_output_that_failed(void **state)
{
    Dialogue *dialogue = *state;
    char here[256];
    block_a_snapshot(dialogue, here);
    Meniscus__Request request = dialogue_checkpoint();
    steer_refused(dialogue_ask(dialogue, &request), MENISCUS__CODE__INTERNAL, "a checkpoint is written only behind");
    assert_int_equal(steer_count(here, "checkpoint-"), 0);
    unblock(here);
    const int written = steer_count(here, "snapshot-");
    Meniscus__Request again = dialogue_checkpoint();
    Meniscus__Reply *reply = dialogue_ask(dialogue, &again);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_int_equal(reply->state, MENISCUS__STATE__FAULT);
    assert_kept(here, reply->step);
    assert_non_null(strstr(reply->output->path, "checkpoint-"));
    meniscus__reply__free_unpacked(reply, NULL);
    assert_true(steer_count(here, "snapshot-") > written);
}

static void a_daemon_that_leaves_after_a_failed_output_keeps_no_state_behind_it(void **state)
{
    Dialogue *dialogue = *state;
    char here[256];
    block_a_snapshot(dialogue, here);
    assert_int_equal(kill(dialogue->daemon, SIGTERM), 0);
    assert_int_equal(dialogue_join(dialogue), 74);
    assert_int_equal(steer_count(here, "checkpoint-"), 0);
    assert_int_equal(steer_count(here, "probes.hdf"), 1);
}

static void a_daemon_that_cannot_keep_the_state_says_so_by_its_exit_code(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 5);
    steer_take_away(dialogue);
    assert_int_equal(kill(dialogue->daemon, SIGTERM), 0);
    assert_int_equal(dialogue_join(dialogue), 74);
}

static void a_reset_without_the_directory_is_refused_and_the_run_stays(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 5);
    steer_take_away(dialogue);
    assert_int_equal(steer_code(dialogue, dialogue_reset()), MENISCUS__CODE__INTERNAL);
    steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, 5);
    steer_bring_back(dialogue);
    assert_int_equal(steer_code(dialogue, dialogue_reset()), MENISCUS__CODE__OK);
    steer_stands_at(dialogue, MENISCUS__STATE__READY, 0);
}

static void a_finished_run_leaves_checkpoint_series_case_and_log(void **state)
{
    Dialogue *dialogue = *state;
    static const char *const settings[] = {"end_time=0.05", NULL};
    char here[256];
    steer_load_here(dialogue, settings, here);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    steer_wait_for(dialogue, MENISCUS__STATE__DONE);
    assert_int_equal(steer_count(here, "checkpoint-"), 1);
    assert_int_equal(steer_count(here, "probes.hdf"), 1);
    assert_int_equal(steer_count(here, "case.yaml"), 1);
    assert_int_equal(steer_count(here, "log"), 1);
}

static void another_run_of_the_name_gets_a_directory_of_its_own(void **state)
{
    Dialogue *dialogue = *state;
    char first[256], second[256];
    steer_path(dialogue, "dam.2", second);
    steer_load_here(dialogue, NULL, first);
    assert_int_equal(access(second, F_OK), -1);
    dialogue_load(dialogue, NULL);
    assert_int_equal(steer_count(first, "case.yaml"), 1);
    assert_int_equal(steer_count(second, "case.yaml"), 1);
}

static void a_case_that_cannot_be_leaves_nothing_behind(void **state)
{
    Dialogue *dialogue = *state;
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Load load = MENISCUS__LOAD__INIT;
    Meniscus__Case empty = MENISCUS__CASE__INIT;
    char here[256];
    steer_path(dialogue, "dam", here);
    load.case_ = &empty;
    load.name = (char *)"dam";
    request.command_case = MENISCUS__REQUEST__COMMAND_LOAD;
    request.load = &load;
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    assert_int_equal(reply->code, MENISCUS__CODE__INVALID_ARGUMENT);
    assert_int_equal(reply->state, MENISCUS__STATE__EMPTY);
    meniscus__reply__free_unpacked(reply, NULL);
    assert_int_equal(access(here, F_OK), -1);
    dialogue_load(dialogue, NULL);
    load.name = (char *)"../up";
    reply = dialogue_ask(dialogue, &request);
    assert_int_equal(reply->code, MENISCUS__CODE__INVALID_ARGUMENT);
    assert_string_equal(reply->path, "name");
    assert_int_equal(reply->state, MENISCUS__STATE__READY);
    meniscus__reply__free_unpacked(reply, NULL);
}

static void a_signal_to_stop_leaves_a_checkpoint_and_no_socket(void **state)
{
    Dialogue *dialogue = *state;
    char here[256];
    steer_load_here(dialogue, NULL, here);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    assert_int_equal(kill(dialogue->daemon, SIGTERM), 0);
    assert_int_equal(dialogue_join(dialogue), 0);
    assert_int_equal(steer_count(here, "checkpoint-"), 1);
    assert_int_equal(access(dialogue->endpoint + strlen("ipc://"), F_OK), -1);
}

static void a_signal_for_a_checkpoint_does_not_stop_the_run(void **state)
{
    Dialogue *dialogue = *state;
    char here[256];
    steer_load_here(dialogue, NULL, here);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    assert_int_equal(kill(dialogue->daemon, SIGUSR1), 0);
    for (int k = 0; k < 500 && !steer_count(here, "checkpoint-"); k++)
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
    assert_true(steer_count(here, "checkpoint-") >= 1);
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_int_equal(reply->state, MENISCUS__STATE__RUNNING);
    meniscus__reply__free_unpacked(reply, NULL);
}

/* How many replies are there, of these codes: OK, RESOURCE_EXHAUSTED; others fail. */
static size_t count_replies(void *socket, long patience, size_t most, size_t *ret_refused)
{
    zmq_pollitem_t item = {.socket = socket, .events = ZMQ_POLLIN};
    size_t n = 0;
    while (n < most && zmq_poll(&item, 1, patience) > 0) {
        Meniscus__Reply *reply = dialogue_receive(socket, NULL);
        n++;
        *ret_refused += reply->code == MENISCUS__CODE__RESOURCE_EXHAUSTED;
        if (reply->code == MENISCUS__CODE__RESOURCE_EXHAUSTED) assert_non_null(strstr(reply->message, "write a file"));
        else assert_int_equal(reply->code, MENISCUS__CODE__OK);
        meniscus__reply__free_unpacked(reply, NULL);
    }
    return n;
}

static void ask_for_files(void *socket, int n)
{
    uint8_t id[16];
    for (int k = 0; k < n; k++) {
        Meniscus__Request checkpoint = dialogue_checkpoint();
        dialogue_say(socket, &checkpoint, id);
    }
}

/* Whether the run stands or is in motion. */
static void who_wants_many_files_keeps_nobody_else_waiting(void **state)
{
    enum { FILES = 60 };
    Dialogue *dialogue = *state;
    void *greedy = dialogue_connect(dialogue);
    dialogue_load(dialogue, NULL);
    for (int moving = 0; moving < 2; moving++) {
        size_t refused = 0;
        if (moving) assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
        ask_for_files(greedy, FILES);
        assert_int_equal(count_replies(greedy, 20000, 1, &refused), 1);
        steer_accepted(steer_set(dialogue, "end_time", moving ? "900" : "800"));
        const size_t before = count_replies(greedy, 0, FILES, &refused);
        print_message("%zu of %d files were written first\n", before, FILES);
        assert_true(before < FILES / 2);
        assert_int_equal(count_replies(greedy, 20000, FILES - 1 - before, &refused), FILES - 1 - before);
        assert_int_equal(refused, 0);
    }
}

static void one_connection_wants_so_many_files_at_a_time(void **state)
{
    enum { FILES = 400 };
    Dialogue *dialogue = *state;
    size_t refused = 0, none = 0;
    void *greedy = dialogue_connect(dialogue), *modest = dialogue_connect(dialogue);
    dialogue_load(dialogue, NULL);
    ask_for_files(greedy, FILES);
    ask_for_files(modest, 1);
    assert_int_equal(count_replies(greedy, 20000, FILES, &refused), FILES);
    assert_int_equal(count_replies(modest, 20000, 1, &none), 1);
    print_message("%zu were refused\n", refused);
    assert_true(refused > 0);
    assert_int_equal(none, 0);
}

/* Whenever they come: a replay, and the way back after a crash, have them at other steps. */
static void checkpoints_by_the_clock_come_and_change_no_bit(void **state)
{
    Dialogue *dialogue = *state;
    static const char *const never[] = {"output.checkpoint_wall_interval=0", NULL},
                             *const often[] = {"output.checkpoint_wall_interval=0.001", "output.checkpoints_kept=1000",
                                               NULL};
    char here[256];
    steer_load_here(dialogue, never, here);
    steer_accepted(steer_until(dialogue, 0.3));
    const uint64_t hash = steer_hash(dialogue), step = steer_step_now(dialogue);
    const int before = steer_count(here, "checkpoint-");
    assert_int_equal(steer_code(dialogue, dialogue_stop()), MENISCUS__CODE__OK);
    snprintf(here, sizeof here, "%s/state/dam.2", dialogue->home);
    dialogue_load(dialogue, often);
    steer_accepted(steer_until(dialogue, 0.3));
    assert_true(steer_count(here, "checkpoint-") > before + 1);
    steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, step);
    assert_true(steer_hash(dialogue) == hash);
}

/* Nothing of the step that would need the formula is done: the state is whole, and has not diverged. */
static void a_run_whose_formula_failed_goes_on_with_another(void **state)
{
    static const char *const settings[] = {"gravity=[\"sqrt(0.1-t)\", -1]", "end_time=0.2", NULL};
    Dialogue *dialogue = *state;
    char here[256];
    Meniscus__Request checkpoint = dialogue_checkpoint();
    steer_load_here(dialogue, settings, here);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    steer_wait_for(dialogue, MENISCUS__STATE__FAULT);
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_non_null(strstr(reply->status->fault, "Set another, and the run can go on"));
    meniscus__reply__free_unpacked(reply, NULL);
    assert_int_equal(dialogue_code(dialogue, &checkpoint), MENISCUS__CODE__OK);
    steer_accepted(steer_set(dialogue, "end_time", "0.15")); /* changes nothing about it */
    assert_int_equal(steer_code(dialogue, dialogue_resume()), MENISCUS__CODE__OK);
    steer_wait_for(dialogue, MENISCUS__STATE__FAULT);
    const uint64_t step = steer_step_now(dialogue);
    steer_accepted(steer_set(dialogue, "gravity", "[0.1, -1]"));
    steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, step);
    assert_int_equal(steer_code(dialogue, dialogue_resume()), MENISCUS__CODE__OK);
    steer_wait_for(dialogue, MENISCUS__STATE__DONE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(checkpoints_by_the_clock_come_and_change_no_bit, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(who_wants_many_files_keeps_nobody_else_waiting, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(one_connection_wants_so_many_files_at_a_time, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_diverged_state_becomes_no_checkpoint, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_run_whose_formula_failed_goes_on_with_another, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_failed_output_stops_the_run_and_is_written_after_resume, steer_begin,
                                        steer_end_somehow),
        cmocka_unit_test_setup_teardown(a_checkpoint_comes_only_behind_an_output_that_failed, steer_begin,
                                        steer_end_somehow),
        cmocka_unit_test_setup_teardown(a_daemon_that_leaves_after_a_failed_output_keeps_no_state_behind_it,
                                        steer_begin, steer_end_somehow),
        cmocka_unit_test_setup_teardown(a_daemon_that_cannot_keep_the_state_says_so_by_its_exit_code, steer_begin,
                                        steer_end_somehow),
        cmocka_unit_test_setup_teardown(a_reset_without_the_directory_is_refused_and_the_run_stays, steer_begin,
                                        steer_end_somehow),
        cmocka_unit_test_setup_teardown(a_finished_run_leaves_checkpoint_series_case_and_log, steer_begin,
                                        steer_end_somehow),
        cmocka_unit_test_setup_teardown(another_run_of_the_name_gets_a_directory_of_its_own, steer_begin,
                                        steer_end_somehow),
        cmocka_unit_test_setup_teardown(a_case_that_cannot_be_leaves_nothing_behind, steer_begin, steer_end_somehow),
        cmocka_unit_test_setup_teardown(a_signal_to_stop_leaves_a_checkpoint_and_no_socket, steer_begin,
                                        steer_end_somehow),
        cmocka_unit_test_setup_teardown(a_signal_for_a_checkpoint_does_not_stop_the_run, steer_begin,
                                        steer_end_somehow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
