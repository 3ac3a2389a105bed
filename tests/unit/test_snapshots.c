/* SPDX-License-Identifier: BSD-3-Clause */
/* Who takes the snapshots of a run one after the other gets them in the order of their steps, those that come later and in the place of others too, and
 * each costs as much as the one before. */
#include "run/snapshots.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct Place {
    char *directory;
    int watch; /* inotify: of what is opened there */
    SnapshotIndex index;
    SnapshotPlace at;
} Place;

static int enter(void **state)
{
    Place *place = *state = calloc(1, sizeof *place);
    if (!place) return -1;
    place->directory = scratch_new();
    place->watch = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    return place->watch < 0;
}

static int leave(void **state)
{
    Place *place = *state;
    snapshots_done(&place->index);
    close(place->watch);
    scratch_free(place->directory);
    free(place);
    return 0;
}

static void path_of(const Place *place, unsigned step, char ret[static 256])
{
    char name[NUMBERED_NAME];
    name_numbered(SNAPSHOT_BEGIN, step, name);
    snprintf(ret, 256, "%s/%s", place->directory, name);
}

/* written: [s since 1970] */
static void write_file(const Place *place, unsigned step, time_t written)
{
    char path[256];
    path_of(place, step, path);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "%u", step);
    fclose(file);
    assert_int_equal(utimensat(AT_FDCWD, path, (struct timespec[]){{.tv_sec = written}, {.tv_sec = written}}, 0), 0);
}

/* The step of the next file; -1: none; -2: the one before was undone. */
static int take(Place *place)
{
    SnapshotNext next;
    char text[16] = "";
    assert_int_equal(snapshots_next(&place->index, place->directory, &place->at, &next, NULL), MNS_OK);
    place->at = next.place;
    if (next.left) return -2;
    if (!next.there) return -1;
    assert_int_equal(read(next.fd, text, sizeof text - 1), next.size);
    close(next.fd);
    place->at.offset = next.size;
    return (int)strtol(text, NULL, 10);
}

static int count_opened(const Place *place)
{
    _Alignas(struct inotify_event) char buffer[4096];
    int n = 0;
    for (ssize_t size; (size = read(place->watch, buffer, sizeof buffer)) > 0;)
        for (char *at = buffer; at < buffer + size;
             at += sizeof(struct inotify_event) + ((struct inotify_event *)at)->len)
            n += ((struct inotify_event *)at)->len > 0; /* else it is the directory itself */
    return n;
}

static void each_file_is_opened_a_few_times_however_many_there_are(void **state)
{
    enum { N = 60 };
    Place *place = *state;
    for (unsigned k = 0; k < N; k++) write_file(place, 10 * k, 1000 + k);
    inotify_add_watch(place->watch, place->directory, IN_OPEN);
    for (int k = 0; k < N; k++) assert_int_equal(take(place), 10 * k);
    assert_int_equal(take(place), -1);
    assert_in_range(count_opened(place), N, 3 * N);
}

static void files_come_as_they_are_written_also_right_after_each_other(void **state)
{
    Place *place = *state;
    for (unsigned k = 1; k < 30; k++) {
        assert_int_equal(take(place), -1);
        write_file(place, k, 1000 + k);
        if (k == 15) usleep(300000); /* long enough for the directory to be known as it is */
        assert_int_equal(take(place), (int)k);
    }
}

static void what_was_undone_is_told_and_what_took_its_place_comes(void **state)
{
    Place *place = *state;
    for (unsigned k = 1; k < 5; k++) write_file(place, k, 1000 + k);
    for (int k = 1; k < 5; k++) assert_int_equal(take(place), k);
    write_file(place, 3, 2000);
    write_file(place, 4, 2001);
    assert_int_equal(take(place), -2);
    assert_int_equal(take(place), 3);
    assert_int_equal(take(place), 4);
    assert_int_equal(take(place), -1);
}

static void without_anything_new_it_goes_on_behind_the_last_one_that_is_left(void **state)
{
    char path[256];
    Place *place = *state;
    for (unsigned k = 1; k < 5; k++) write_file(place, k, 1000 + k);
    for (int k = 1; k < 5; k++) assert_int_equal(take(place), k);
    for (unsigned k = 3; k < 5; k++) {
        path_of(place, k, path);
        assert_int_equal(unlink(path), 0);
    }
    assert_int_equal(take(place), -2);
    assert_non_null(strstr(place->at.name, "2.hdf"));
    assert_int_equal(take(place), -1);
    write_file(place, 3, 3000);
    assert_int_equal(take(place), 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(each_file_is_opened_a_few_times_however_many_there_are, enter, leave),
        cmocka_unit_test_setup_teardown(files_come_as_they_are_written_also_right_after_each_other, enter, leave),
        cmocka_unit_test_setup_teardown(what_was_undone_is_told_and_what_took_its_place_comes, enter, leave),
        cmocka_unit_test_setup_teardown(without_anything_new_it_goes_on_behind_the_last_one_that_is_left, enter, leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
