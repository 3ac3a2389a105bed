/* SPDX-License-Identifier: BSD-3-Clause */
/* Ways back, and what becomes of the files: reset, restore, directories that others use. */
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <hdf5.h>
#include <meniscus/exit.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zmq.h>

/* --- reset ----------------------------------------------------------------------------------------------------------------- */

static void a_reset_run_is_a_fresh_run(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    const uint64_t first = steer_hash(dialogue);
    steer_go(dialogue, 12);
    const uint64_t fresh = steer_hash(dialogue);
    steer_go(dialogue, 5);
    assert_int_equal(steer_code(dialogue, dialogue_reset()), MENISCUS__CODE__OK);
    assert_true(steer_hash(dialogue) == first);
    steer_go(dialogue, 12);
    assert_true(steer_hash(dialogue) == fresh);
}

/* A restore goes back to the settings of its checkpoint, a reset to those of the load. */
static void a_reset_undoes_what_was_set(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    steer_accepted(steer_set(dialogue, "gravity", "[0, -2]"));
    steer_go(dialogue, 3);
    steer_accepted(steer_set(dialogue, "end_time", "7"));
    const uint64_t light = steer_hash(dialogue);
    assert_int_equal(steer_code(dialogue, dialogue_reset()), MENISCUS__CODE__OK);
    assert_true(steer_get(dialogue, "end_time") == 1000);
    steer_go(dialogue, 3);
    assert_true(steer_hash(dialogue) != light);
    steer_accepted(steer_set(dialogue, "end_time", "7"));
    char path[256];
    steer_write_checkpoint(dialogue, path);
    steer_accepted(steer_set(dialogue, "end_time", "8"));
    steer_accepted(steer_restore(dialogue, NULL));
    assert_true(steer_get(dialogue, "end_time") == 7);
    assert_int_equal(steer_code(dialogue, dialogue_reset()), MENISCUS__CODE__OK);
    assert_true(steer_get(dialogue, "end_time") == 1000);
}

static Meniscus__Reply *load_again(Dialogue *dialogue, const char *const *settings)
{
    LoadRequest load;
    dialogue_load_init(&load, "dam", dialogue_case, settings);
    load.load.has_resume = load.load.resume = 1;
    Meniscus__Reply *reply = dialogue_ask(dialogue, &load.request);
    dialogue_load_done(&load);
    return reply;
}

/* What was steered is not lost because the file does not say it; what is said by hand wins over both. */
static void a_resumed_run_is_as_it_was_steered_but_for_what_is_set_by_hand(void **state)
{
    static const char *const by_hand[] = {"gravity[1]=-3", "output.probe_interval=0.5", NULL};
    static const char *const other[] = {"scheme.cfl=0.1", "resolution=20", NULL};
    Dialogue *dialogue = *state;
    char path[256];
    dialogue_load(dialogue, NULL);
    steer_accepted(steer_set(dialogue, "end_time", "7"));
    steer_accepted(steer_set(dialogue, "gravity", "[0.5, -2]"));
    steer_go(dialogue, 3);
    steer_write_checkpoint(dialogue, path);
    const uint64_t hash = steer_hash(dialogue);
    void *log = steer_subscribe(dialogue, "log");
    steer_accepted(load_again(dialogue, NULL));
    assert_true(steer_hash(dialogue) == hash);
    steer_accepted(load_again(dialogue, by_hand));
    assert_true(steer_hash(dialogue) != hash); /* as rates are of the state, and those of another gravity now */
    assert_true(steer_get(dialogue, "end_time") == 7);
    assert_true(steer_get(dialogue, "gravity[0]") == 0.5);
    assert_true(steer_get(dialogue, "gravity[1]") == -3);
    assert_true(steer_get(dialogue, "output.probe_interval") == 0.5);
    steer_hear_of(log, "gravity = [0.5, -3], as set on resuming; the checkpoint has [0.5, -2]");
    steer_hear_of(log, "gravity = [0.5, -3], as the checkpoint has it, not [0, -3] as the case says");
    steer_hear_of(log, "end_time = 7, as the checkpoint has it, not 1000 as the case says");
    Meniscus__Reply *reply = load_again(dialogue, other);
    assert_string_equal(reply->path, "resolution");
    steer_refused(reply, MENISCUS__CODE__INVALID_ARGUMENT, "can go on with no other");
}

/* The same names twice: nothing that was left is written over. */
static void each_time_line_that_was_left_is_kept_by_itself(void **state)
{
    Dialogue *dialogue = *state;
    char path[256];
    dialogue_load(dialogue, NULL);
    for (int k = 0; k < 2; k++) {
        steer_go(dialogue, 4);
        steer_write_checkpoint(dialogue, path);
        assert_int_equal(steer_code(dialogue, dialogue_reset()), MENISCUS__CODE__OK);
        assert_int_equal(access(path, F_OK), -1);
    }
    for (int k = 0; k < 2; k++) {
        steer_path(dialogue, k ? "dam/abandoned.2" : "dam/abandoned", path);
        assert_int_equal(steer_count(path, "checkpoint-0000000004.hdf"), 1);
        assert_int_equal(steer_count(path, "probes.hdf"), 1);
    }
}

/* --- restore --------------------------------------------------------------------------------------------------------------- */

static void a_damaged_checkpoint_is_passed_over_with_a_note(void **state)
{
    Dialogue *dialogue = *state;
    char older[256], newer[256];
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 4);
    steer_write_checkpoint(dialogue, older);
    const uint64_t before = steer_hash(dialogue);
    steer_go(dialogue, 3);
    steer_write_checkpoint(dialogue, newer);
    FILE *file = fopen(newer, "r+b");
    assert_non_null(file);
    fseek(file, 3000, SEEK_SET);
    fputs("damaged", file);
    fclose(file);
    void *log = steer_subscribe(dialogue, "log");
    Meniscus__Reply *reply = steer_restore(dialogue, strrchr(newer, '/') + 1); /* by name it is wanted and no other */
    assert_int_equal(reply->code, MENISCUS__CODE__DATA_LOSS);
    meniscus__reply__free_unpacked(reply, NULL);
    steer_accepted(steer_restore(dialogue, NULL));
    assert_true(steer_hash(dialogue) == before);
    steer_hear_of(log, strrchr(newer, '/') + 1);
}

enum { ROWS = 64 };

/* Times of the samples in a series: [*ret_n]. */
static void read_times(const char *path, double ret[static ROWS], hsize_t *ret_n)
{
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), set = H5Dopen(file, "/time", H5P_DEFAULT);
    assert_true(file >= 0 && set >= 0);
    const hid_t space = H5Dget_space(set);
    *ret_n = (hsize_t)H5Sget_simple_extent_npoints(space);
    assert_true(*ret_n <= ROWS);
    assert_true(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, ret) >= 0);
    H5Sclose(space);
    H5Dclose(set);
    H5Fclose(file);
}

static void a_moment_come_by_again_is_sampled_once(void **state)
{
    Dialogue *dialogue = *state;
    static const char *const settings[] = {"output.probe_interval=0.002", NULL};
    char path[256], series[256];
    double times[ROWS];
    hsize_t n;
    dialogue_load(dialogue, settings);
    steer_write_checkpoint(dialogue, path);
    steer_go(dialogue, 5);
    steer_accepted(steer_restore(dialogue, NULL));
    steer_stands_at(dialogue, MENISCUS__STATE__READY, 0);
    steer_go(dialogue, 3);
    steer_write_checkpoint(dialogue, path);
    steer_path(dialogue, "dam/probes.hdf", series);
    read_times(series, times, &n);
    assert_true(n > 1 && times[0] == 0);
    for (hsize_t k = 1; k < n; k++) assert_true(times[k] > times[k - 1]);
}

static void a_series_that_was_taken_away_is_missed_aloud(void **state)
{
    Dialogue *dialogue = *state;
    static const char *const settings[] = {"output.probe_interval=0.002", NULL};
    char path[256], series[256];
    dialogue_load(dialogue, settings);
    steer_go(dialogue, 5);
    steer_write_checkpoint(dialogue, path);
    steer_path(dialogue, "dam/probes.hdf", series);
    assert_int_equal(unlink(series), 0);
    void *log = steer_subscribe(dialogue, "log");
    steer_accepted(steer_restore(dialogue, NULL));
    steer_hear_of(log, "probes.hdf");
}

/* --- directories --------------------------------------------------------------------------------------------------------- */

/* Run meniscusd with these words; its exit code, and the first line it wrote. */
static int run_daemon(const Dialogue *dialogue, const char *words, char ret_line[static 512])
{
    char command[4800];
    const char *build = getenv("BUILD");
    snprintf(command, sizeof command, "XDG_RUNTIME_DIR=%s timeout 20 %s/meniscusd %s 2>&1 >/dev/null", dialogue->home,
             build ? build : "build", words);
    FILE *pipe = popen(command, "r");
    if (!fgets(ret_line, 512, pipe)) ret_line[0] = 0;
    return WEXITSTATUS(pclose(pipe));
}

static void a_directory_in_use_is_refused_and_free_again_after_a_kill(void **state)
{
    Dialogue *dialogue = *state;
    char words[512], line[512], who[32];
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 2);
    snprintf(words, sizeof words, "--batch %s/state/dam/case.yaml --until 0.001 --set end_time=0.01 --out %s/state/dam",
             dialogue->home, dialogue->home);
    snprintf(who, sizeof who, "process %d on ", (int)dialogue->daemon);
    assert_int_equal(run_daemon(dialogue, words, line), MNS_EXIT_AGAIN);
    assert_non_null(strstr(line, who));
    assert_non_null(strstr(line, "state/dam"));
    assert_int_equal(kill(dialogue->daemon, SIGKILL), 0);
    assert_int_equal(dialogue_join(dialogue), -1);
    assert_int_equal(run_daemon(dialogue, words, line), 0);
}

static void a_directory_is_free_after_stop_and_held_after_reset(void **state)
{
    Dialogue *dialogue = *state;
    char words[512], line[512];
    dialogue_load(dialogue, NULL);
    snprintf(words, sizeof words, "--batch %s/state/dam/case.yaml --until 0.001 --set end_time=0.01 --out %s/state/dam",
             dialogue->home, dialogue->home);
    assert_int_equal(steer_code(dialogue, dialogue_reset()), MENISCUS__CODE__OK);
    assert_int_equal(run_daemon(dialogue, words, line), MNS_EXIT_AGAIN);
    assert_int_equal(steer_code(dialogue, dialogue_stop()), MENISCUS__CODE__OK);
    assert_int_equal(run_daemon(dialogue, words, line), 0);
}

static void a_place_that_cannot_be_used_is_noticed_at_the_start(void **state)
{
    Dialogue *dialogue = *state;
    char line[512];
    assert_int_equal(run_daemon(dialogue, "--name other --state-dir /dev/null/x", line), 74);
    assert_non_null(strstr(line, "/dev/null"));
}

static void replies_name_files_from_the_root(void **state)
{
    (void)state;
    Dialogue dialogue;
    char place[64] = "/tmp/mns-place-XXXXXX", here[2048], relative[4096] = "", path[256], command[128];
    assert_non_null(mkdtemp(place));
    assert_non_null(getcwd(here, sizeof here));
    for (const char *slash = here; (slash = strchr(slash, '/')); slash++) strcat(relative, "../");
    strcat(relative, place + 1);
    const char *const options[] = {"--state-dir", relative, NULL};
    dialogue_begin(&dialogue, options);
    dialogue_load(&dialogue, NULL);
    steer_write_checkpoint(&dialogue, path);
    assert_memory_equal(path, place, strlen(place));
    Meniscus__Reply *reply = steer_status(&dialogue);
    assert_memory_equal(reply->status->run_directory, place, strlen(place));
    meniscus__reply__free_unpacked(reply, NULL);
    assert_int_equal(dialogue_end(&dialogue), 0);
    snprintf(command, sizeof command, "rm -rf %s", place);
    assert_int_equal(system(command), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_reset_run_is_a_fresh_run, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_reset_undoes_what_was_set, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_resumed_run_is_as_it_was_steered_but_for_what_is_set_by_hand, steer_begin,
                                        steer_end),
        cmocka_unit_test_setup_teardown(each_time_line_that_was_left_is_kept_by_itself, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_damaged_checkpoint_is_passed_over_with_a_note, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_moment_come_by_again_is_sampled_once, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_series_that_was_taken_away_is_missed_aloud, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_directory_in_use_is_refused_and_free_again_after_a_kill, steer_begin,
                                        steer_end_somehow),
        cmocka_unit_test_setup_teardown(a_directory_is_free_after_stop_and_held_after_reset, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_place_that_cannot_be_used_is_noticed_at_the_start, steer_begin, steer_end),
        cmocka_unit_test(replies_name_files_from_the_root),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
