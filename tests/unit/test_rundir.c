/* SPDX-License-Identifier: BSD-3-Clause */
/* Run directories: which one, whose, and what moves aside. */
#include "run/rundir.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char place[64];

static int begin(void **state)
{
    (void)state;
    snprintf(place, sizeof place, "/tmp/mns-rundir-XXXXXX");
    assert_non_null(mkdtemp(place));
    return 0;
}

static int end(void **state)
{
    (void)state;
    char command[80];
    snprintf(command, sizeof command, "rm -rf %s", place);
    return system(command);
}

static void path_of(const char *name, char ret[static 128])
{
    snprintf(ret, 128, "%s/%s", place, name);
}

static bool has(const char *name)
{
    char path[128];
    path_of(name, path);
    return exists(path);
}

static void put(const char *name)
{
    char path[128];
    path_of(name, path);
    put_bytes(path, "something", 9);
}

static void a_name_gets_the_first_free_directory_or_the_last_there_is(void **state)
{
    (void)state;
    char dir[RUNDIR_PATH], wanted[128];
    MnsError error;
    path_of("dam", wanted);
    assert_int_equal(rundir_choose(place, "dam", true, dir, &error), MNS_OK);
    assert_string_equal(dir, wanted);
    assert_int_equal(mkdir(wanted, 0777), 0);
    path_of("dam.2", wanted);
    assert_int_equal(rundir_choose(place, "dam", false, dir, &error), MNS_OK);
    assert_string_equal(dir, wanted);
    assert_int_equal(mkdir(wanted, 0777), 0);
    assert_int_equal(rundir_choose(place, "dam", true, dir, &error), MNS_OK);
    assert_string_equal(dir, wanted);
}

static void later_files_move_aside_with_a_link_to_the_series(void **state)
{
    (void)state;
    char aside[RUNDIR_PATH] = "";
    MnsError error;
    put("checkpoint-0000000005.hdf");
    put("snapshot-0000000007.hdf");
    put("probes.hdf");
    assert_int_equal(rundir_abandon(place, false, 5, aside, &error), MNS_OK);
    assert_true(has("checkpoint-0000000005.hdf"));
    assert_false(has("snapshot-0000000007.hdf"));
    assert_true(has("abandoned/snapshot-0000000007.hdf"));
    assert_true(has("abandoned/probes.hdf") && has("probes.hdf"));
    put("probes.hdf"); /* a new file of the name */
    struct stat old, new;
    char path[128];
    path_of("abandoned/probes.hdf", path);
    assert_int_equal(stat(path, &old), 0);
    path_of("probes.hdf", path);
    assert_int_equal(stat(path, &new), 0);
    assert_true(old.st_ino != new.st_ino);
}

/* A directory in place of the series can be neither linked nor copied. */
static void what_cannot_be_kept_whole_stays_where_it_was(void **state)
{
    (void)state;
    char aside[RUNDIR_PATH] = "", path[128];
    MnsError error;
    put("checkpoint-0000000005.hdf");
    put("snapshot-0000000007.hdf");
    path_of("probes.hdf", path);
    assert_int_equal(mkdir(path, 0777), 0);
    assert_int_equal(rundir_abandon(place, false, 5, aside, &error), MNS_E_IO);
    assert_non_null(strstr(error.text, "probes.hdf"));
    assert_true(has("snapshot-0000000007.hdf"));
    assert_false(has("abandoned"));
    assert_string_equal(aside, "");
}

static void what_was_moved_aside_comes_back(void **state)
{
    (void)state;
    char aside[RUNDIR_PATH] = "";
    MnsError error;
    for (int all = 0; all < 2; all++) {
        aside[0] = 0;
        put("checkpoint-0000000005.hdf");
        put("snapshot-0000000007.hdf");
        put("probes.hdf");
        assert_int_equal(rundir_abandon(place, all, 5, aside, &error), MNS_OK);
        rundir_return(place, aside);
        assert_true(has("checkpoint-0000000005.hdf") && has("snapshot-0000000007.hdf") && has("probes.hdf"));
        assert_false(has("abandoned"));
    }
}

static void files_follow_a_journal_aside_which_comes_back_by_itself(void **state)
{
    (void)state;
    char aside[RUNDIR_PATH] = "", journal[RUNDIR_PATH];
    MnsError error;
    put("checkpoint-0000000005.hdf");
    put("journal");
    assert_int_equal(rundir_retire_journal(place, aside, &error), MNS_OK);
    memcpy(journal, aside, sizeof journal);
    assert_true(has("abandoned/journal") && !has("journal"));
    assert_int_equal(rundir_abandon(place, true, 0, aside, &error), MNS_OK);
    assert_string_equal(aside, journal);
    assert_true(has("abandoned/checkpoint-0000000005.hdf"));
    rundir_return(place, aside);
    assert_true(has("checkpoint-0000000005.hdf") && has("abandoned/journal"));
    rundir_return_journal(place, aside);
    assert_true(has("journal") && !has("abandoned"));
}

static void all_move_aside_and_never_over_those_before(void **state)
{
    (void)state;
    char aside[RUNDIR_PATH], wanted[128];
    MnsError error;
    for (int k = 1; k <= 3; k++) {
        put("checkpoint-0000000005.hdf");
        put("probes.hdf");
        put("snapshots.hdf.series");
        put("log");
        aside[0] = 0;
        assert_int_equal(rundir_abandon(place, true, 0, aside, &error), MNS_OK);
        char name[32] = "abandoned";
        if (k > 1) snprintf(name, sizeof name, "abandoned.%d", k);
        path_of(name, wanted);
        assert_string_equal(aside, wanted);
    }
    assert_true(has("log"));
    assert_false(has("probes.hdf") || has("snapshots.hdf.series"));
    assert_true(has("abandoned.2/checkpoint-0000000005.hdf") && has("abandoned.3/probes.hdf"));
}

static void nothing_to_move_makes_no_directory(void **state)
{
    (void)state;
    char aside[RUNDIR_PATH] = "";
    MnsError error;
    put("checkpoint-0000000005.hdf");
    assert_int_equal(rundir_abandon(place, false, 5, aside, &error), MNS_OK);
    assert_string_equal(aside, "");
    assert_false(has("abandoned"));
}

static void a_directory_is_had_by_one(void **state)
{
    (void)state;
    char dir[128];
    MnsError error;
    int fd, other;
    size_t made;
    path_of("a/b", dir);
    assert_int_equal(rundir_make(dir, &made, &error), MNS_OK);
    assert_int_equal(made, strlen(dir) - strlen("/b"));
    assert_int_equal(rundir_lock(dir, &fd, &error), MNS_OK);
    assert_int_equal(rundir_lock(dir, &other, &error), MNS_E_STATE);
    assert_non_null(strstr(error.text, dir));
    assert_non_null(strstr(error.text, "process "));
    rundir_unmake(dir, made);
    assert_false(has("a"));
    close(fd);
}

static void directories_that_were_there_are_not_unmade(void **state)
{
    (void)state;
    char dir[128];
    size_t made;
    path_of("a", dir);
    assert_int_equal(rundir_make(dir, &made, NULL), MNS_OK);
    path_of("a//b/c", dir);
    assert_int_equal(rundir_make(dir, &made, NULL), MNS_OK);
    assert_true(has("a/b/c"));
    rundir_unmake(dir, made);
    assert_false(has("a/b"));
    assert_true(has("a"));
    assert_int_equal(rundir_make(place, &made, NULL), MNS_OK);
    assert_int_equal(made, 0);
}

/* A file stands in the way of the third. */
static void directories_that_cannot_be_made_leave_none(void **state)
{
    (void)state;
    char dir[128];
    size_t made = 7;
    MnsError error;
    put("file");
    path_of("new/../file/x", dir);
    assert_int_equal(rundir_make(dir, &made, &error), MNS_E_IO);
    assert_int_equal(made, 7);
    assert_false(has("new"));
}

static void a_directory_with_files_is_not_unmade(void **state)
{
    (void)state;
    put("log");
    rundir_unmake(place, strlen(place));
    assert_true(has("log"));
}

static void what_a_killed_writer_left_is_cleared_and_nothing_else(void **state)
{
    (void)state;
    static const char *const gone[] = {"checkpoint-0000000005.hdf.tmp", "snapshot-0000000007.hdf.tmp", "probes.hdf.tmp",
                                       "snapshots.hdf.series.tmp", "case.yaml.tmp"};
    static const char *const kept[] = {"checkpoint-0000000005.hdf", "probes.hdf", "mine.tmp", "mine.hdf.tmp", "log"};
    for (size_t k = 0; k < sizeof gone / sizeof *gone; k++) put(gone[k]);
    for (size_t k = 0; k < sizeof kept / sizeof *kept; k++) put(kept[k]);
    rundir_clear(place);
    for (size_t k = 0; k < sizeof gone / sizeof *gone; k++) assert_false(has(gone[k]));
    for (size_t k = 0; k < sizeof kept / sizeof *kept; k++) assert_true(has(kept[k]));
}

static bool is_current(const char *asked, const char *wanted)
{
    char dir[RUNDIR_PATH], expected[128];
    bool same;
    path_of(wanted, expected);
    assert_int_equal(rundir_current(place, asked, dir, &same, NULL), MNS_OK);
    assert_string_equal(dir, expected);
    return same;
}

static void the_current_run_is_known_with_what_was_asked_for(void **state)
{
    (void)state;
    char dir[RUNDIR_PATH], run[128];
    bool same;
    assert_int_equal(rundir_current(place, NULL, dir, &same, NULL), MNS_E_NOT_FOUND);
    path_of("dam.2", run);
    assert_int_equal(rundir_note_current(place, run, "/cases/dam.yaml\nresolution=8\n", NULL), MNS_OK);
    assert_true(is_current("/cases/dam.yaml\nresolution=8\n", "dam.2"));
    assert_false(is_current("/cases/dam.yaml\nresolution=9\n", "dam.2"));
    assert_false(is_current("/cases/dam.yaml\n", "dam.2"));
    assert_false(is_current("/cases/dam.yaml\nresolution=8\nthreads=1\n", "dam.2"));
    assert_false(is_current(NULL, "dam.2"));
    assert_int_equal(rundir_note_current(place, run, NULL, NULL), MNS_OK);
    assert_true(is_current(NULL, "dam.2"));
    assert_false(is_current("/cases/dam.yaml\n", "dam.2"));
    rundir_forget_current(place);
    assert_int_equal(rundir_current(place, NULL, dir, &same, NULL), MNS_E_NOT_FOUND);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_name_gets_the_first_free_directory_or_the_last_there_is, begin, end),
        cmocka_unit_test_setup_teardown(later_files_move_aside_with_a_link_to_the_series, begin, end),
        cmocka_unit_test_setup_teardown(what_cannot_be_kept_whole_stays_where_it_was, begin, end),
        cmocka_unit_test_setup_teardown(files_follow_a_journal_aside_which_comes_back_by_itself, begin, end),
        cmocka_unit_test_setup_teardown(what_was_moved_aside_comes_back, begin, end),
        cmocka_unit_test_setup_teardown(all_move_aside_and_never_over_those_before, begin, end),
        cmocka_unit_test_setup_teardown(nothing_to_move_makes_no_directory, begin, end),
        cmocka_unit_test_setup_teardown(a_directory_is_had_by_one, begin, end),
        cmocka_unit_test_setup_teardown(directories_that_were_there_are_not_unmade, begin, end),
        cmocka_unit_test_setup_teardown(directories_that_cannot_be_made_leave_none, begin, end),
        cmocka_unit_test_setup_teardown(a_directory_with_files_is_not_unmade, begin, end),
        cmocka_unit_test_setup_teardown(what_a_killed_writer_left_is_cleared_and_nothing_else, begin, end),
        cmocka_unit_test_setup_teardown(the_current_run_is_known_with_what_was_asked_for, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
