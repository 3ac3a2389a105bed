/* SPDX-License-Identifier: BSD-3-Clause */
/* A daemon that is killed and started again: what it says and does on the way back to its run, and where that is. */
#include "batch/replay.h"
#include "run/writer.h"
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <meniscus/exit.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

static const double FAR = 1.5; /* [s] of steps since the only checkpoint */

static uint64_t hash_of(Dialogue *dialogue)
{
    Meniscus__Reply *reply = steer_status(dialogue);
    const uint64_t hash = reply->status->state_hash;
    meniscus__reply__free_unpacked(reply, NULL);
    assert_true(hash);
    return hash;
}

static Meniscus__State state_of(Dialogue *dialogue)
{
    Meniscus__Reply *reply = steer_status(dialogue);
    const Meniscus__State state = reply->status->state;
    meniscus__reply__free_unpacked(reply, NULL);
    return state;
}

static void what_was_paused_is_where_it_was(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 30);
    steer_accepted(steer_set(dialogue, "gravity", "[0.1, -1]"));
    steer_go(dialogue, 12);
    const uint64_t hash = hash_of(dialogue);
    for (int k = 0; k < 2; k++) {
        dialogue_crash(dialogue);
        steer_accepted(steer_wait(dialogue, MENISCUS__STATE__PAUSED, 20000));
        assert_int_equal(steer_step_now(dialogue), 42);
        assert_int_equal(hash_of(dialogue), hash);
    }
}

/* The journal has the load as it was sent: nothing in it says what the run is called. */
static void a_run_that_was_loaded_without_a_name_comes_back(void **state)
{
    Dialogue *dialogue = *state;
    LoadRequest load;
    dialogue_load_init(&load, "dam", dialogue_case, NULL);
    load.load.name = NULL;
    assert_int_equal(dialogue_code(dialogue, &load.request), MENISCUS__CODE__OK);
    dialogue_load_done(&load);
    steer_go(dialogue, 3);
    dialogue_crash(dialogue);
    steer_accepted(steer_wait(dialogue, MENISCUS__STATE__PAUSED, 20000));
    assert_int_equal(steer_step_now(dialogue), 3);
}

static void what_was_answered_is_answered_alike_and_done_once(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    dialogue_load(dialogue, NULL);
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Step step = MENISCUS__STEP__INIT;
    step.has_count = 1;
    step.count = 7;
    request.command_case = MENISCUS__REQUEST__COMMAND_STEP;
    request.step = &step;
    dialogue_say(dialogue->control, &request, id);
    Meniscus__Reply *first = dialogue_receive(dialogue->control, NULL);
    assert_non_null(first);
    dialogue_crash(dialogue);
    dialogue_send(dialogue->control, &request);
    Meniscus__Reply *again = dialogue_receive(dialogue->control, NULL);
    assert_non_null(again);
    assert_memory_equal(again->id.data, id, 16);
    assert_int_equal(again->code, MENISCUS__CODE__OK);
    assert_int_equal(again->daemon_epoch, first->daemon_epoch); /* of the daemon that did it */
    assert_int_equal(again->effect_step, 7);
    meniscus__reply__free_unpacked(first, NULL);
    meniscus__reply__free_unpacked(again, NULL);
    step.count = 8; /* another command, under the id of that one */
    dialogue_send(dialogue->control, &request);
    steer_refused(dialogue_receive(dialogue->control, NULL), MENISCUS__CODE__INVALID_ARGUMENT, "another request");
    steer_accepted(steer_wait(dialogue, MENISCUS__STATE__PAUSED, 20000));
    assert_int_equal(steer_step_now(dialogue), 7);
}

/* Also when the case goes with it, of which the run makes its own. */
static void a_load_is_answered_alike_after_a_crash(void **state)
{
    Dialogue *dialogue = *state;
    LoadRequest load;
    uint8_t id[16];
    dialogue_load_init(&load, "dam", dialogue_case, (const char *const[]){"resolution=12", NULL});
    dialogue_say(dialogue->control, &load.request, id);
    steer_accepted(dialogue_receive(dialogue->control, NULL));
    steer_go(dialogue, 3);
    dialogue_crash(dialogue);
    dialogue_send(dialogue->control, &load.request);
    steer_accepted(dialogue_receive(dialogue->control, NULL));
    steer_accepted(steer_wait(dialogue, MENISCUS__STATE__PAUSED, 20000));
    assert_int_equal(steer_step_now(dialogue), 3);
    load.load.name = "mad";
    dialogue_send(dialogue->control, &load.request);
    steer_refused(dialogue_receive(dialogue->control, NULL), MENISCUS__CODE__INVALID_ARGUMENT, "another request");
    dialogue_load_done(&load);
}

/* A directory in the place of the file `current`, or of that which is to become it. */
static void block(const Dialogue *dialogue, const char *name, char path[static 256])
{
    steer_path(dialogue, name, path);
    assert_int_equal(mkdir(path, 0700), 0);
}

/* Nothing is given up for it. */
static void what_could_not_be_noted_is_not_loaded(void **state)
{
    Dialogue *dialogue = *state;
    LoadRequest load;
    char blocked[256];
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 3);
    block(dialogue, "current.tmp", blocked);
    dialogue_load_init(&load, "mad", dialogue_case, NULL);
    steer_refused(dialogue_ask(dialogue, &load.request), MENISCUS__CODE__INTERNAL, "current.tmp");
    steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, 3);
    assert_int_equal(rmdir(blocked), 0);
    assert_int_equal(dialogue_code(dialogue, &load.request), MENISCUS__CODE__OK);
    dialogue_load_done(&load);
    steer_go(dialogue, 5);
    dialogue_crash(dialogue);
    steer_accepted(steer_wait(dialogue, MENISCUS__STATE__PAUSED, 20000));
    assert_int_equal(steer_step_now(dialogue), 5);
}

static void a_way_back_needs_no_room_to_say_which_run_it_was(void **state)
{
    Dialogue *dialogue = *state;
    char blocked[256];
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 30);
    block(dialogue, "current.tmp", blocked);
    for (int k = 0; k < 2; k++) {
        dialogue_crash(dialogue);
        steer_accepted(steer_wait(dialogue, MENISCUS__STATE__PAUSED, 20000));
        assert_int_equal(steer_step_now(dialogue), 30 + k);
        steer_go(dialogue, 1);
    }
    assert_int_equal(rmdir(blocked), 0);
}

/* Nothing is told as done before a daemon that is started after a crash would find the run. */
static void a_run_that_cannot_be_noted_is_told_and_halted(void **state)
{
    Dialogue *dialogue = *state;
    LoadRequest load;
    char blocked[256];
    block(dialogue, "current", blocked);
    dialogue_load_init(&load, "dam", dialogue_case, NULL);
    steer_refused(dialogue_ask(dialogue, &load.request), MENISCUS__CODE__INTERNAL, "would not find the run");
    dialogue_load_done(&load);
    steer_wait_for(dialogue, MENISCUS__STATE__FAULT);
    steer_refused(steer_set(dialogue, "gravity", "[0, -3]"), MENISCUS__CODE__INTERNAL, "would not find the run");
    assert_int_equal(rmdir(blocked), 0);
    assert_int_equal(steer_code(dialogue, dialogue_resume()), MENISCUS__CODE__OK);
    assert_int_equal(steer_code(dialogue, dialogue_pause()), MENISCUS__CODE__OK);
    const uint64_t step = steer_step_now(dialogue);
    dialogue_crash(dialogue);
    steer_accepted(steer_wait(dialogue, MENISCUS__STATE__PAUSED, 20000));
    assert_int_equal(steer_step_now(dialogue), step);
}

/* A crash far from the only checkpoint, and the daemon on its way back; the step it was at. */
static uint64_t crash_far_out(Dialogue *dialogue)
{
    uint64_t steps = 0;
    dialogue_load(dialogue, (const char *const[]){"output.checkpoint_interval=1000", NULL});
    for (const double until = steer_now() + FAR; steer_now() < until; steps += 20) steer_go(dialogue, 20);
    dialogue_crash(dialogue);
    Meniscus__State state = MENISCUS__STATE__EMPTY;
    for (const double until = steer_now() + 20; state == MENISCUS__STATE__EMPTY && steer_now() < until;)
        state = state_of(dialogue);
    assert_int_equal(state, MENISCUS__STATE__RECOVERING);
    return steps;
}

static void changes_wait_until_the_run_is_back_or_their_deadline_passes(void **state)
{
    static const char *const pairs[][2] = {{"gravity", "[0, -2]"}};
    Dialogue *dialogue = *state;
    uint8_t id[16], late_id[16];
    const uint64_t steps = crash_far_out(dialogue);
    void *patient = dialogue_connect(dialogue);
    steer_say_set(patient, 1, pairs, id);
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Set set = MENISCUS__SET__INIT;
    Meniscus__Assignment assignment = MENISCUS__ASSIGNMENT__INIT;
    assignment.path = "gravity";
    assignment.value = "[0, -3]";
    set.n_assignments = 1;
    set.assignments = (Meniscus__Assignment *[]){&assignment};
    request.command_case = MENISCUS__REQUEST__COMMAND_SET;
    request.set = &set;
    request.has_deadline_ms = 1;
    request.deadline_ms = 20;
    dialogue_say(dialogue->control, &request, late_id);
    steer_refused(dialogue_receive(dialogue->control, NULL), MENISCUS__CODE__DEADLINE_EXCEEDED,
                  "before the run was back");
    assert_int_equal(state_of(dialogue), MENISCUS__STATE__RECOVERING);
    Meniscus__Reply *reply = dialogue_receive(patient, NULL);
    assert_non_null(reply);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_int_equal(reply->effect_step, steps);
    assert_string_equal(reply->values->values[0]->text, "[0, -2]");
    meniscus__reply__free_unpacked(reply, NULL);
}

static void a_stop_on_the_way_back_is_for_good(void **state)
{
    Dialogue *dialogue = *state;
    const uint64_t steps = crash_far_out(dialogue);
    Meniscus__Request stop = dialogue_stop();
    Meniscus__Reply *reply = dialogue_ask(dialogue, &stop);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_int_equal(reply->state, MENISCUS__STATE__EMPTY);
    /* Before there are particles the run is where the journal has it, and then where it has come to, which is said. */
    if (reply->effect_step != steps) {
        assert_true(reply->effect_step < steps);
        assert_non_null(strstr(reply->message, "which it had not reached"));
    }
    meniscus__reply__free_unpacked(reply, NULL);
    dialogue_crash(dialogue);
    steer_sleep(200);
    assert_int_equal(state_of(dialogue), MENISCUS__STATE__EMPTY);
}

/* Which version that is, only the run knows when it is back. */
static void a_stop_for_a_version_waits_until_the_run_is_back(void **state)
{
    Dialogue *dialogue = *state;
    const uint64_t steps = crash_far_out(dialogue);
    for (uint64_t version = 2; version >= 1; version--) {
        Meniscus__Request stop = dialogue_stop();
        stop.has_if_version = true;
        stop.if_version = version;
        Meniscus__Reply *reply = dialogue_ask(dialogue, &stop);
        assert_int_equal(reply->code, version == 1 ? MENISCUS__CODE__OK : MENISCUS__CODE__FAILED_PRECONDITION);
        if (version == 1) assert_int_equal(reply->effect_step, steps);
        meniscus__reply__free_unpacked(reply, NULL);
    }
}

/* Whether it comes before the load of the way back has begun, or after, is chance: so some more of them. */
static void a_pause_on_the_way_back_keeps_it_from_going_on(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    Meniscus__Request start = dialogue_start(), pause = dialogue_pause();
    assert_int_equal(dialogue_code(dialogue, &start), MENISCUS__CODE__OK);
    steer_accepted(steer_wait_step(dialogue, 20));
    for (int k = 0; k < 8; k++) {
        dialogue_crash(dialogue);
        steer_accepted(dialogue_ask(dialogue, &pause));
        if (k < 7) assert_int_equal(steer_code(dialogue, dialogue_resume()), MENISCUS__CODE__OK);
    }
    const uint64_t step = steer_step_now(dialogue);
    steer_sleep(100);
    assert_int_equal(steer_step_now(dialogue), step);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, steer_begin, steer_end)

/* As if a byte of it had been changed: what comes after the load, near the end. */
static void damage(const char *path)
{
    FILE *file = fopen(path, "r+");
    assert_non_null(file);
    assert_int_equal(fseek(file, -100, SEEK_END), 0);
    const int c = getc(file);
    assert_int_equal(fseek(file, -100, SEEK_END), 0);
    putc(c ^ 1, file);
    fclose(file);
}

/* It is there, and says what is wrong with which file. */
static void check_unread(Dialogue *dialogue, const char *journal)
{
    Meniscus__Reply *reply = steer_status(dialogue);
    for (int k = 0; !reply->status->fault && k < 500; k++) { /* it answers before it has looked */
        meniscus__reply__free_unpacked(reply, NULL);
        steer_sleep(10);
        reply = steer_status(dialogue);
    }
    assert_int_equal(reply->state, MENISCUS__STATE__EMPTY);
    assert_non_null(reply->status->fault);
    assert_non_null(strstr(reply->status->fault, "cannot be gone on with"));
    assert_non_null(strstr(reply->status->fault, journal));
    meniscus__reply__free_unpacked(reply, NULL);
}

/* Whoever began anew would have forgotten the run by the next crash. */
static void a_run_whose_journal_cannot_be_read_is_not_forgotten(void **state)
{
    Dialogue *dialogue = *state;
    char here[256], journal[300], current[300];
    steer_load_here(dialogue, NULL, here);
    steer_go(dialogue, 5);
    snprintf(journal, sizeof journal, "%s/journal", here);
    snprintf(current, sizeof current, "%s/../current", here);
    kill(dialogue->daemon, SIGKILL);
    assert_int_equal(dialogue_join(dialogue), -1);
    damage(journal);
    for (int k = 0; k < 2; k++) {
        dialogue_again(dialogue, NULL);
        check_unread(dialogue, journal);
        assert_int_equal(access(current, F_OK), 0);
        kill(dialogue->daemon, SIGKILL);
        assert_int_equal(dialogue_join(dialogue), -1);
    }
    damage(journal); /* as it was */
    dialogue_again(dialogue, NULL);
    steer_accepted(steer_wait(dialogue, MENISCUS__STATE__PAUSED, 20000));
    assert_int_equal(steer_step_now(dialogue), 5);
}

/* Set the end time at a later step; nobody waits for that. */
static void schedule_end(Dialogue *dialogue, const char *value, uint64_t step)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    request.has_at_step = request.has_no_wait = request.no_wait = true;
    request.at_step = step;
    steer_accepted(steer_set_under(dialogue, &request, "end_time", value));
}

/* What was commanded behind that place would be lost if it just went on; so would what is commanded meanwhile. */
static void a_way_back_that_a_file_holds_up_goes_on_by_resume(void **state)
{
    Dialogue *dialogue = *state;
    /* More behind the snapshot that fails than may wait to be written, so that the run cannot get there before it is told. */
    const uint64_t there = 5 + WRITER_HEAVY_MAX;
    char here[256], in_the_way[300];
    steer_load_here(dialogue, (const char *const[]){"output.snapshot_interval=1e-9", NULL}, here);
    steer_go(dialogue, there);
    steer_accepted(steer_set(dialogue, "gravity", "[0, -2]"));
    schedule_end(dialogue, "77", there + 2);
    snprintf(in_the_way, sizeof in_the_way, "%s/snapshot-0000000003.hdf.tmp", here);
    assert_int_equal(mkdir(in_the_way, 0700), 0);
    for (int k = 0; k < 2; k++) { /* another crash there changes nothing */
        dialogue_crash(dialogue);
        steer_wait_for(dialogue, MENISCUS__STATE__FAULT);
        assert_true(steer_step_now(dialogue) < there);
        Meniscus__Request resume = dialogue_resume();
        steer_refused(dialogue_ask(dialogue, &resume), MENISCUS__CODE__INTERNAL, "cannot create");
        steer_refused(steer_set(dialogue, "gravity", "[0, -3]"), MENISCUS__CODE__FAILED_PRECONDITION,
                      "not back where it was before the crash");
    }
    assert_int_equal(rmdir(in_the_way), 0);
    assert_int_equal(steer_code(dialogue, dialogue_resume()), MENISCUS__CODE__OK);
    steer_accepted(steer_wait_step(dialogue, there + 3));
    assert_int_equal(steer_code(dialogue, dialogue_pause()), MENISCUS__CODE__OK);
    assert_true(steer_get(dialogue, "end_time") == 77);
    assert_int_equal(replay_run(here, -1, false), MNS_EXIT_DONE);
    dialogue_crash(dialogue);
    steer_accepted(steer_wait(dialogue, MENISCUS__STATE__PAUSED, 20000));
    assert_true(steer_step_now(dialogue) > there);
}

/* The journal knows of the start alone, the checkpoint is later. */
static void a_checkpoint_that_is_newer_than_the_journal_is_no_goal_behind(void **state)
{
    Dialogue *dialogue = *state;
    char here[256], log[300], line[512];
    bool said = false;
    steer_load_here(dialogue, (const char *const[]){"output.checkpoint_interval=0.02", NULL}, here);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    for (int k = 0; steer_count(here, "checkpoint-") < 2 && k < 60000; k++) steer_sleep(1); /* the first is of step 0 */
    assert_true(steer_step_now(dialogue) < 100); /* before the journal has a hash */
    dialogue_crash(dialogue);
    steer_accepted(steer_wait(dialogue, MENISCUS__STATE__RUNNING, 20000));
    assert_true(steer_step_now(dialogue) > 0);
    snprintf(log, sizeof log, "%s/log", here);
    FILE *file = fopen(log, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file)) {
        assert_null(strstr(line, "to step 0"));
        said = said || strstr(line, "nothing is known that came after the checkpoint of step ");
    }
    fclose(file);
    assert_true(said);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(what_was_paused_is_where_it_was),
        TEST(a_run_that_was_loaded_without_a_name_comes_back),
        TEST(what_was_answered_is_answered_alike_and_done_once),
        TEST(a_load_is_answered_alike_after_a_crash),
        TEST(what_could_not_be_noted_is_not_loaded),
        TEST(a_way_back_needs_no_room_to_say_which_run_it_was),
        TEST(a_run_that_cannot_be_noted_is_told_and_halted),
        TEST(changes_wait_until_the_run_is_back_or_their_deadline_passes),
        TEST(a_stop_on_the_way_back_is_for_good),
        TEST(a_stop_for_a_version_waits_until_the_run_is_back),
        TEST(a_pause_on_the_way_back_keeps_it_from_going_on),
        TEST(a_checkpoint_that_is_newer_than_the_journal_is_no_goal_behind),
        TEST(a_way_back_that_a_file_holds_up_goes_on_by_resume),
        cmocka_unit_test_setup_teardown(a_run_whose_journal_cannot_be_read_is_not_forgotten, steer_begin, steer_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
