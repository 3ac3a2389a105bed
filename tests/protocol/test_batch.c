/* SPDX-License-Identifier: BSD-3-Clause */
/* The contract of `meniscusd --batch` with scripts: exit codes, one JSON object, restarts that change no bit. */
#include "tests/support/check.h"
#include "tests/support/dialogue.h"
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* A directory with the case in it. */
typedef struct Place {
    char home[64];
    int code;        /* exit code of the last run        */
    char first[512]; /* first line it wrote to standard error */
} Place;

static int begin(void **state)
{
    static Place place;
    char path[128];
    place = (Place){.home = "/tmp/mns-batch-XXXXXX"};
    assert_non_null(mkdtemp(place.home));
    snprintf(path, sizeof path, "%s/dam.yaml", place.home);
    FILE *file = fopen(path, "w");
    fputs(dialogue_case, file);
    fclose(file);
    *state = &place;
    return 0;
}

static int end(void **state)
{
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", ((Place *)*state)->home);
    return system(command);
}

/* Run with these options in the place; the JSON object it printed, or NULL. prefix: of the shell's command; output: how it is to print. */
static json_t *run_as(Place *place, const char *prefix, const char *output, const char *options)
{
    char command[4600], cwd[2048], path[128];
    const char *build = getenv("BUILD");
    const bool absolute = build && *build == '/';
    assert_non_null(getcwd(cwd, sizeof cwd));
    snprintf(command, sizeof command, "cd %s && %s %s/%s/meniscusd --batch dam.yaml %s %s 2>err", place->home, prefix,
             absolute ? "" : cwd, build ? build : "build", output, options);
    FILE *pipe = popen(command, "r");
    json_t *object = json_loadf(pipe, 0, NULL);
    place->code = WEXITSTATUS(pclose(pipe));
    snprintf(path, sizeof path, "%s/err", place->home);
    FILE *errors = fopen(path, "r");
    if (!errors || !fgets(place->first, sizeof place->first, errors)) place->first[0] = 0;
    if (errors) fclose(errors);
    return object;
}

static json_t *run(Place *place, const char *prefix, const char *options)
{
    return run_as(place, prefix, "-o json", options);
}

static void assert_says(const json_t *object, const char *key, const char *text)
{
    assert_non_null(object);
    assert_non_null(json_string_value(json_object_get(object, key)));
    assert_string_equal(json_string_value(json_object_get(object, key)), text);
}

static void the_object_says_what_came_of_the_run(void **state)
{
    json_t *object = run(*state, "", "--set end_time=0.05");
    assert_int_equal(((Place *)*state)->code, 0);
    assert_says(object, "state", "DONE");
    assert_says(object, "case", "dam");
    assert_true(json_real_value(json_object_get(object, "t")) == 0.05);
    assert_true(json_integer_value(json_object_get(object, "steps")) > 10);
    assert_int_equal(strlen(json_string_value(json_object_get(object, "state_hash"))), 16);
    assert_says(json_object_get(json_object_get(object, "probes"), "energy"), "unit", "J");
    assert_true(json_array_size(json_object_get(object, "outputs")) >= 3);
    json_decref(object);
}

static void a_run_in_two_halves_is_the_same_to_the_last_bit(void **state)
{
    json_t *whole = run(*state, "", "--set end_time=0.1 --out whole");
    json_t *half = run(*state, "", "--set end_time=0.1 --out halves --until 0.04");
    assert_says(half, "state", "PAUSED");
    assert_true(json_real_value(json_object_get(half, "t")) >= 0.04);
    json_t *rest = run(*state, "", "--set end_time=0.1 --out halves --resume auto --threads 2");
    assert_says(rest, "state", "DONE");
    assert_says(rest, "state_hash", json_string_value(json_object_get(whole, "state_hash")));
    json_decref(whole);
    json_decref(half);
    json_decref(rest);
}

static void a_signal_leaves_a_checkpoint_and_asks_to_be_run_again(void **state)
{
    json_t *object = run(*state, "timeout --preserve-status -s TERM 1", "--out stopped");
    assert_int_equal(((Place *)*state)->code, 75);
    assert_says(object, "state", "PAUSED");
    json_decref(object);
    char command[128];
    snprintf(command, sizeof command, "ls %s/stopped/checkpoint-*.hdf >/dev/null", ((Place *)*state)->home);
    assert_int_equal(system(command), 0);
}

/* A formula for each of 8e8 points keeps it busy for minutes. */
static void a_signal_while_the_case_is_loaded_leaves_nothing(void **state)
{
    Place *place = *state;
    char path[128];
    json_t *object =
        run(place, "timeout --preserve-status -s TERM 1 timeout 20",
            "--out below/stopped --set resolution=20000 --set walls=[] --set 'fluids=[{name: drop, density: 1, "
            "sound_speed: 1, shape: [{formula: \"x*x + y*y < 1e-6\"}]}]' --set probes=[]");
    assert_int_equal(place->code, 75);
    assert_says(json_object_get(object, "error"), "status", "interrupted");
    assert_non_null(strstr(place->first, "called off"));
    json_decref(object);
    snprintf(path, sizeof path, "%s/below", place->home);
    assert_int_equal(access(path, F_OK), -1);
}

/* One for a checkpoint, more while it is under way, and one to leave: each is heard. */
static void signals_are_heard_however_many(void **state)
{
    Place *place = *state;
    char command[128];
    json_t *object = run(place, "exec",
                         "--out many --set output.checkpoints_kept=9 & it=$!; sleep 0.7; for k in 1 2 3 4 5; do "
                         "kill -USR1 $it; done; sleep 0.3; kill -TERM $it; wait $it #");
    assert_int_equal(place->code, 75);
    json_decref(object);
    snprintf(command, sizeof command, "test $(ls %s/many/checkpoint-*.hdf | wc -l) -ge 2", place->home);
    assert_int_equal(system(command), 0);
}

static void an_end_before_the_time_to_stop_is_the_end(void **state)
{
    json_t *object = run(*state, "", "--set end_time=0.02 --until 5");
    assert_int_equal(((Place *)*state)->code, 0);
    assert_says(object, "state", "DONE");
    json_decref(object);
}

static void a_bad_case_names_its_place_and_leaves_nothing(void **state)
{
    Place *place = *state;
    char command[256];
    snprintf(command, sizeof command, "sed -i s/1000,/-1000,/ %s/dam.yaml", place->home);
    assert_int_equal(system(command), 0);
    json_decref(run(place, "", ""));
    assert_int_equal(place->code, 65);
    assert_memory_equal(place->first, "dam.yaml:6:28: ", 15);
    snprintf(command, sizeof command, "%s/dam.run", place->home);
    assert_int_equal(access(command, F_OK), -1);
    json_decref(run(place, "", "--set fluids[0].density=1000 --set end_time=1e99 --out new/a/b"));
    assert_int_equal(place->code, 65); /* known only when there is a directory */
    snprintf(command, sizeof command, "%s/new", place->home);
    assert_int_equal(access(command, F_OK), -1);
}

/* HDF5 would take it for the group, when the first samples are written. */
static void a_probe_that_is_a_dot_is_refused_before_anything_is_run(void **state)
{
    Place *place = *state;
    char command[256];
    snprintf(command, sizeof command, "sed -i 's/name: energy/name: ./' %s/dam.yaml", place->home);
    assert_int_equal(system(command), 0);
    json_decref(run(place, "", "--set end_time=0.05 --set output.probe_interval=0.01"));
    assert_int_equal(place->code, 65);
    assert_memory_equal(place->first, "dam.yaml:15:12: probes[1].name: ", 32);
}

static void a_bad_override_is_its_own_place(void **state)
{
    Place *place = *state;
    json_decref(run(place, "", "--set fluids[0].density=-1"));
    assert_int_equal(place->code, 65);
    assert_memory_equal(place->first, "--set fluids[0].density=-1: ", 28);
}

static void too_little_memory_is_the_fault_of_the_resolution(void **state)
{
    Place *place = *state;
    if (getenv("MENISCUS_SANITIZED")) skip(); /* shadow memory takes more addresses than these */
    json_decref(run(place, "ulimit -v 1000000;", "--set resolution=6000"));
    assert_int_equal(place->code, 1);
    assert_memory_equal(place->first, "--set resolution=6000: ", 23);
    assert_non_null(strstr(place->first, "GB of memory"));
}

/* Before the first step the case is to blame; later the run has its results, and cannot go on. */
static void a_formula_that_fails_on_the_way_is_a_fault_of_the_run(void **state)
{
    Place *place = *state;
    json_decref(run(place, "", "--set 'gravity[1]=\"1/t\"'"));
    assert_int_equal(place->code, 65);
    json_t *object = run(place, "", "--set 'gravity[1]=\"t > 0.02 and (t < 0.3) or -1\"'");
    assert_int_equal(place->code, 70);
    assert_says(object, "state", "FAULT");
    assert_non_null(strstr(json_string_value(json_object_get(object, "fault")), "gravity[1]"));
    assert_int_equal(json_integer_value(json_object_get(object, "exit_code")), 70);
    assert_less(json_real_value(json_object_get(object, "t")), 0.02 + 1e-12); /* before the step that needs it */
    json_decref(object);
}

static void another_case_cannot_go_on_from_a_checkpoint(void **state)
{
    Place *place = *state;
    json_decref(run(place, "", "--out a --until 0.02"));
    assert_int_equal(place->code, 0);
    json_decref(run(place, "", "--out a --until 0.02 --resume auto --set resolution=20"));
    assert_int_equal(place->code, 65);
    assert_memory_equal(place->first, "--set resolution=20: ", 21);
}

static bool said(const Place *place, const char *file, const char *part)
{
    char command[512];
    snprintf(command, sizeof command, "grep -qF -e '%s' %s/%s", part, place->home, file);
    return system(command) == 0;
}

/* What was set the first time, or steered since, is the checkpoint's, and the case file is not asked again. */
static void a_resumed_run_keeps_what_was_set_unless_it_is_set_again(void **state)
{
    Place *place = *state;
    json_decref(run(place, "", "--out a --set end_time=0.08 --set scheme.cfl=0.2 --until 0.02"));
    json_decref(run(place, "", "--out a --until 0.04 --resume auto"));
    assert_true(said(place, "err", "end_time = 0.08, as the checkpoint has it, not 1000 as the case says"));
    assert_true(said(place, "err", "scheme.cfl = 0.2, as the checkpoint has it, not 0.25 as the case says"));
    json_decref(run(place, "", "--out a --until 0.05 --resume auto --set scheme.cfl=0.25"));
    assert_true(said(place, "a/log", "scheme.cfl = 0.25, as set on resuming; the checkpoint has 0.2"));
    json_t *object = run(place, "", "--out a --resume auto");
    assert_says(object, "state", "DONE");
    assert_true(json_real_value(json_object_get(object, "t")) == 0.08);
    assert_true(said(place, "err", "end_time = 0.08, as the checkpoint has it"));
    assert_false(said(place, "err", "cfl")); /* it is again as the case says */
    json_decref(object);
}

/* As text for people, which is left in `out`. */
static void run_for_people(Place *place, const char *options, int code)
{
    assert_null(run_as(place, "", ">out", options));
    assert_int_equal(place->code, code);
}

static void a_run_that_is_begun_anew_says_so_and_where_its_files_are(void **state)
{
    Place *place = *state;
    json_decref(run(place, "", "--out a --until 0.02"));
    assert_false(said(place, "err", "begun anew"));
    json_decref(run(place, "", "--out a --until 0.02 --resume auto"));
    assert_false(said(place, "err", "begun anew"));
    json_decref(run(place, "", "--out a --until 0.02"));
    assert_true(said(place, "err", "the run in a is begun anew, and its files are in a/abandoned: with --resume auto"));
}

static void people_are_told_how_a_run_goes_on(void **state)
{
    Place *place = *state;
    run_for_people(place, "--out a --until 0.02", 0);
    assert_true(said(place, "out", "same command again, with --resume auto and without --until"));
    run_for_people(place, "--out b --set end_time=0.02", 0);
    assert_false(said(place, "out", "--resume auto"));
    run_for_people(place, "--out b --set end_time=0.02 --resume auto", 0);
    assert_true(said(place, "out", "s of wall-clock time, "));
    assert_false(said(place, "out", "nan"));
}

static void a_damaged_checkpoint_is_passed_over(void **state)
{
    Place *place = *state;
    char command[256];
    json_decref(run(place, "", "--out a --until 0.02"));
    json_decref(run(place, "", "--out a --until 0.04 --resume auto"));
    snprintf(command, sizeof command, "cd %s/a && truncate -s 2000 $(ls checkpoint-*.hdf | tail -1)", place->home);
    assert_int_equal(system(command), 0);
    json_t *object = run(place, "", "--out a --until 0.01 --resume auto");
    assert_int_equal(place->code, 0);
    assert_non_null(strstr(place->first, "checkpoint"));
    const double t = json_real_value(json_object_get(object, "t"));
    assert_true(t >= 0.02 && t < 0.04);
    json_decref(object);
}

static void a_wrong_command_line_and_an_unwritable_place_have_codes_of_their_own(void **state)
{
    Place *place = *state;
    json_decref(run(place, "", "--until never"));
    assert_int_equal(place->code, 2);
    assert_non_null(strstr(place->first, "meniscusd: "));
    json_decref(run(place, "", "stray"));
    assert_int_equal(place->code, 2);
    assert_non_null(strstr(place->first, "\"stray\""));
    json_decref(run(place, "", "--threads many"));
    assert_int_equal(place->code, 2);
    assert_non_null(strstr(place->first, "0 to 1024"));
    json_decref(run(place, "", "--until 0.01 --out /dev/null/x"));
    assert_int_equal(place->code, 74);
    assert_memory_equal(place->first, "meniscusd: ", 11);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_object_says_what_came_of_the_run, begin, end),
        cmocka_unit_test_setup_teardown(a_run_in_two_halves_is_the_same_to_the_last_bit, begin, end),
        cmocka_unit_test_setup_teardown(a_signal_leaves_a_checkpoint_and_asks_to_be_run_again, begin, end),
        cmocka_unit_test_setup_teardown(a_signal_while_the_case_is_loaded_leaves_nothing, begin, end),
        cmocka_unit_test_setup_teardown(signals_are_heard_however_many, begin, end),
        cmocka_unit_test_setup_teardown(an_end_before_the_time_to_stop_is_the_end, begin, end),
        cmocka_unit_test_setup_teardown(a_bad_case_names_its_place_and_leaves_nothing, begin, end),
        cmocka_unit_test_setup_teardown(a_probe_that_is_a_dot_is_refused_before_anything_is_run, begin, end),
        cmocka_unit_test_setup_teardown(a_bad_override_is_its_own_place, begin, end),
        cmocka_unit_test_setup_teardown(too_little_memory_is_the_fault_of_the_resolution, begin, end),
        cmocka_unit_test_setup_teardown(a_formula_that_fails_on_the_way_is_a_fault_of_the_run, begin, end),
        cmocka_unit_test_setup_teardown(another_case_cannot_go_on_from_a_checkpoint, begin, end),
        cmocka_unit_test_setup_teardown(a_resumed_run_keeps_what_was_set_unless_it_is_set_again, begin, end),
        cmocka_unit_test_setup_teardown(a_run_that_is_begun_anew_says_so_and_where_its_files_are, begin, end),
        cmocka_unit_test_setup_teardown(people_are_told_how_a_run_goes_on, begin, end),
        cmocka_unit_test_setup_teardown(a_damaged_checkpoint_is_passed_over, begin, end),
        cmocka_unit_test_setup_teardown(a_wrong_command_line_and_an_unwritable_place_have_codes_of_their_own, begin,
                                        end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
