/* SPDX-License-Identifier: BSD-3-Clause */
/* What the daemon writes, seen from outside: an output that fails stops the run and is not lost; a signal leaves a checkpoint. */
#include "tests/support/check.h"
#include "tests/support/dialogue.h"
#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static int begin(void **state)
{
    Dialogue *dialogue = calloc(1, sizeof *dialogue);
    dialogue_begin(dialogue, NULL);
    *state = dialogue;
    return 0;
}

static int end(void **state)
{
    dialogue_end(*state);
    free(*state);
    return 0;
}

static void path_of(const Dialogue *dialogue, const char *name, char ret[static 256])
{
    snprintf(ret, 256, "%s/state/%s", dialogue->home, name);
}

/* How many files in a directory begin like this. */
static int count(const char *directory, const char *like)
{
    DIR *stream = opendir(directory);
    int n = 0;
    assert_non_null(stream);
    for (const struct dirent *entry; (entry = readdir(stream));) n += !strncmp(entry->d_name, like, strlen(like));
    closedir(stream);
    return n;
}

static void wait_for(Dialogue *dialogue, Meniscus__State which)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Wait wait = MENISCUS__WAIT__INIT;
    wait.n_states = 1;
    wait.states = &which;
    request.command_case = MENISCUS__REQUEST__COMMAND_WAIT;
    request.wait = &wait;
    request.has_deadline_ms = 1;
    request.deadline_ms = 15000;
    assert_int_equal(dialogue_code(dialogue, &request), MENISCUS__CODE__OK);
}

static Meniscus__Code send(Dialogue *dialogue, Meniscus__Request request)
{
    return dialogue_code(dialogue, &request);
}

static void a_failed_output_stops_the_run_and_is_written_after_resume(void **state)
{
    Dialogue *dialogue = *state;
    static const char *const settings[] = {"output.snapshot_interval=0.05", "end_time=0.5", NULL};
    char here[256], away[256];
    path_of(dialogue, "dam", here);
    path_of(dialogue, "away", away);
    dialogue_load(dialogue, settings);
    assert_int_equal(rename(here, away), 0);
    send(dialogue, dialogue_start()); /* refused, if the first snapshot has failed by then */
    wait_for(dialogue, MENISCUS__STATE__FAULT);
    Meniscus__Request request = dialogue_status();
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    assert_non_null(strstr(reply->status->fault, "dam"));
    meniscus__reply__free_unpacked(reply, NULL);
    assert_int_not_equal(send(dialogue, dialogue_resume()), MENISCUS__CODE__OK);
    assert_int_equal(rename(away, here), 0);
    assert_int_equal(send(dialogue, dialogue_resume()), MENISCUS__CODE__OK);
    wait_for(dialogue, MENISCUS__STATE__DONE);
    assert_int_equal(count(here, "snapshot-"), 11);
    assert_int_equal(count(here, "probes.hdf"), 1);
}

static void a_finished_run_leaves_checkpoint_series_case_and_log(void **state)
{
    Dialogue *dialogue = *state;
    static const char *const settings[] = {"end_time=0.05", NULL};
    char here[256];
    path_of(dialogue, "dam", here);
    dialogue_load(dialogue, settings);
    assert_int_equal(send(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    wait_for(dialogue, MENISCUS__STATE__DONE);
    assert_int_equal(count(here, "checkpoint-"), 1);
    assert_int_equal(count(here, "probes.hdf"), 1);
    assert_int_equal(count(here, "case.yaml"), 1);
    assert_int_equal(count(here, "log"), 1);
}

static void another_run_of_the_name_gets_a_directory_of_its_own(void **state)
{
    Dialogue *dialogue = *state;
    char first[256], second[256];
    path_of(dialogue, "dam", first);
    path_of(dialogue, "dam.2", second);
    dialogue_load(dialogue, NULL);
    assert_int_equal(access(second, F_OK), -1);
    dialogue_load(dialogue, NULL);
    assert_int_equal(count(first, "case.yaml"), 1);
    assert_int_equal(count(second, "case.yaml"), 1);
}

static void a_case_that_cannot_be_leaves_nothing_behind(void **state)
{
    Dialogue *dialogue = *state;
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Load load = MENISCUS__LOAD__INIT;
    Meniscus__Case empty = MENISCUS__CASE__INIT;
    char here[256];
    path_of(dialogue, "", here);
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
    path_of(dialogue, "dam", here);
    dialogue_load(dialogue, NULL);
    assert_int_equal(send(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    assert_int_equal(kill(dialogue->daemon, SIGTERM), 0);
    assert_int_equal(dialogue_join(dialogue), 0);
    assert_int_equal(count(here, "checkpoint-"), 1);
    assert_int_equal(access(dialogue->endpoint + strlen("ipc://"), F_OK), -1);
}

static void a_signal_for_a_checkpoint_does_not_stop_the_run(void **state)
{
    Dialogue *dialogue = *state;
    char here[256];
    path_of(dialogue, "dam", here);
    dialogue_load(dialogue, NULL);
    assert_int_equal(send(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    assert_int_equal(kill(dialogue->daemon, SIGUSR1), 0);
    for (int k = 0; k < 500 && !count(here, "checkpoint-"); k++)
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
    assert_true(count(here, "checkpoint-") >= 1);
    Meniscus__Request request = dialogue_status();
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    assert_int_equal(reply->state, MENISCUS__STATE__RUNNING);
    meniscus__reply__free_unpacked(reply, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_failed_output_stops_the_run_and_is_written_after_resume, begin, end),
        cmocka_unit_test_setup_teardown(a_finished_run_leaves_checkpoint_series_case_and_log, begin, end),
        cmocka_unit_test_setup_teardown(another_run_of_the_name_gets_a_directory_of_its_own, begin, end),
        cmocka_unit_test_setup_teardown(a_case_that_cannot_be_leaves_nothing_behind, begin, end),
        cmocka_unit_test_setup_teardown(a_signal_to_stop_leaves_a_checkpoint_and_no_socket, begin, end),
        cmocka_unit_test_setup_teardown(a_signal_for_a_checkpoint_does_not_stop_the_run, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
