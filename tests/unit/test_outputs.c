/* SPDX-License-Identifier: BSD-3-Clause */
/* What a run leaves behind is all there, and once, also when there was no memory for it at first. */
#include "base/clock.h"
#include "common/case/file.h"
#include "io/checkpoint.h"
#include "io/h5.h"
#include "io/names.h"
#include "run/outputs.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include "tests/support/memory.h"
#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* --- the run ----------------------------------------------------------------------------------------------------------- */

typedef struct Place {
    char *home;
    CaseFile *file;
    Document *document;
    MnsSim *sim;
    Outbox outbox;
    Outputs outputs;
} Place;

static int begin(void **state)
{
    static const char *const settings[] = {"resolution=8",
                                           "threads=1",
                                           "output.probe_interval=0.0001",
                                           "output.snapshot_interval=0.0001",
                                           "output.checkpoint_interval=0.0001",
                                           "output.checkpoints_kept=100",
                                           "probes=[{name: mass, mass: {}}]"};
    Place *place = calloc(1, sizeof *place);
    if (!place) return 1;
    *state = place;
    place->home = scratch_new();
    place->outputs.outbox = &place->outbox;
    if (case_file_read("server/cases/dambreak2d.yaml", &place->file, NULL)) return 1;
    for (size_t k = 0; k < sizeof settings / sizeof *settings; k++)
        if (case_file_set(place->file, settings[k], NULL)) return 1;
    MnsStatus status = document_new(case_file_message(place->file), "small", &place->document, NULL);
    if (!status) status = mns_sim_new(place->document->c, &place->sim, NULL);
    if (!status) status = outbox_init(&place->outbox, NULL);
    if (!status) status = writer_new(NULL, NULL, &place->outputs.writer, NULL);
    if (!status)
        status = outputs_open(&place->outputs, &(OutputsPlace){.directory = place->home, .lock = -1}, place->document,
                              place->sim, &(MnsError){0}, NULL);
    return (int)status;
}

static int end(void **state)
{
    Place *place = *state;
    memory_fails_after(-1);
    limit_files(SIZE_MAX);
    outputs_close(&place->outputs, NULL);
    writer_free(place->outputs.writer);
    outbox_done(&place->outbox);
    mns_sim_free(place->sim);
    document_leave(place->document);
    case_file_free(place->file);
    scratch_free(place->home);
    free(place);
    return 0;
}

/* More steps than any of these has allocations, so that each of them fails once. */
enum { STEPS = 16 };

static void step(const Place *place)
{
    assert_int_equal(mns_sim_step(place->sim, INFINITY, NULL), MNS_OK);
}

/* Have allocation number n fail, and try again if that is told. */
static bool fails(MnsStatus (*act)(Outputs *, const MnsSim *, Document *, MnsError *), Place *place, long n)
{
    memory_fails_after(n);
    const MnsStatus status = act(&place->outputs, place->sim, place->document, NULL);
    memory_fails_after(-1);
    if (!status) return false;
    assert_int_equal(status, MNS_E_MEMORY);
    assert_int_equal(act(&place->outputs, place->sim, place->document, NULL), MNS_OK);
    return true;
}

static void assert_written(const Place *place, const char *kind, unsigned number)
{
    char name[64];
    snprintf(name, sizeof name, "%s-%010u.hdf", kind, number);
    if (!holds(place->home, name)) fail_msg("%s is missing", name);
}

typedef struct Rows {
    size_t n;
    uint64_t step[STEPS];
} Rows;

static void get_rows(H5 *h, void *into)
{
    Rows *rows = into;
    rows->n = h5_rows(h, "/step");
    if (rows->n <= STEPS) h5_get_rows(h, "/step", H5T_NATIVE_UINT64, 0, rows->n, rows->step);
}

static size_t live_samples(Outbox *box)
{
    size_t n = 0;
    for (Note *note; (note = outbox_take(box)); note_free(note)) n += note->kind == NOTE_PROBES;
    return n;
}

static void what_finds_no_memory_is_taken_later_and_once(void **state)
{
    Place *place = *state;
    Rows rows = {.n = 0};
    if (!memory_can_fail) skip();
    int failures = 0;
    for (long n = 0; n < STEPS; n++) {
        failures += fails(outputs_take, place, n);
        step(place);
    }
    assert_in_range(failures, 3, STEPS - 1);
    assert_int_equal(outputs_flush(&place->outputs, NULL), MNS_OK);
    assert_int_equal(writer_drain(place->outputs.writer, NULL), MNS_OK);
    char *path = path_in(place->home, "probes.hdf");
    assert_int_equal(h5_load(path, false, get_rows, &rows, NULL), MNS_OK);
    free(path);
    assert_int_equal(rows.n, STEPS);
    assert_int_equal(live_samples(&place->outbox), STEPS);
    for (unsigned k = 0; k < STEPS; k++) {
        assert_int_equal(rows.step[k], k);
        assert_written(place, "snapshot", k);
        assert_written(place, "checkpoint", k);
    }
}

static void a_last_checkpoint_that_found_no_memory_is_not_left_out(void **state)
{
    Place *place = *state;
    if (!memory_can_fail) skip();
    int failures = 0;
    for (unsigned n = 0; n < STEPS; n++) {
        const double t = mns_sim_progress(place->sim).t;
        place->outputs.before = (OutputTimes){t, t, t}; /* nothing else is due */
        failures += fails(outputs_finish, place, n % 2);
        assert_written(place, "checkpoint", n);
        step(place);
    }
    assert_int_equal(failures,
                     STEPS / 2); /* there is room for the copy from the first one on: one allocation is left */
}

static size_t rows_in(const Place *place)
{
    Rows rows = {.n = 0};
    char *path = path_in(place->home, "probes.hdf");
    assert_int_equal(h5_load(path, false, get_rows, &rows, NULL), MNS_OK);
    free(path);
    return rows.n;
}

/* A restart goes on from the checkpoint, and looks at its boundary no more. */
static void a_last_checkpoint_has_all_before_it_that_found_no_memory(void **state)
{
    Place *place = *state;
    char path[4096];
    if (!memory_can_fail) skip();
    assert_int_equal(outputs_take(&place->outputs, place->sim, place->document, NULL), MNS_OK);
    for (unsigned n = 1; n < 3; n++) {
        step(place);
        memory_fails_after(0);
        assert_int_equal(outputs_take(&place->outputs, place->sim, place->document, NULL), MNS_E_MEMORY);
        memory_fails_after(-1);
        assert_int_equal(n == 1 ? outputs_finish(&place->outputs, place->sim, place->document, NULL)
                                : outputs_rescue(&place->outputs, place->sim, place->document, path, NULL),
                         MNS_OK);
        assert_written(place, "snapshot", n);
        assert_written(place, "checkpoint", n);
        assert_int_equal(rows_in(place), n + 1);
    }
}

/* It has all that the disk refused, or it is not there. */
static void there_is_no_checkpoint_behind_what_is_not_on_the_disk(void **state)
{
    Place *place = *state;
    Outputs *outputs = &place->outputs;
    char path[4096], *in_the_way = path_in(place->home, "probes.hdf.tmp");
    assert_int_equal(mkdir(in_the_way, 0777), 0);
    outputs_take(outputs, place->sim, place->document, NULL);
    step(place);
    outputs_take(outputs, place->sim, place->document, NULL);
    assert_int_equal(outputs_rescue(outputs, place->sim, place->document, path, NULL), MNS_E_IO);
    assert_false(holds(place->home, "checkpoint-0000000000.hdf"));
    assert_false(holds(place->home, "checkpoint-0000000001.hdf"));
    assert_written(place, "snapshot", 1); /* which stands for itself */
    assert_int_equal(rmdir(in_the_way), 0);
    assert_int_equal(outputs_rescue(outputs, place->sim, place->document, path, NULL), MNS_OK);
    assert_written(place, "checkpoint", 1);
    assert_int_equal(rows_in(place), 2);
    free(in_the_way);
}

/* The solver stands still for a copy, and not for the system to find pages. */
static void room_of_what_was_written_is_used_again_until_the_run_is_left(void **state)
{
    Place *place = *state;
    Outputs *outputs = &place->outputs;
    const MnsCapture *first = NULL;
    for (unsigned k = 0; k < 3; k++, step(place)) {
        assert_int_equal(outputs_snapshot(outputs, place->sim, place->document,
                                          UINT64_C(1) << mns_field_find("pressure"), NULL, NULL),
                         MNS_OK);
        assert_int_equal(writer_drain(outputs->writer, NULL), MNS_OK);
        assert_written(place, "snapshot", k);
        if (!first) first = outputs->spare;
        assert_non_null(first);
        assert_ptr_equal(outputs->spare, first);
        assert_int_equal(outputs_checkpoint(outputs, place->sim, place->document, NULL, NULL), MNS_OK);
        assert_int_equal(writer_drain(outputs->writer, NULL), MNS_OK);
        assert_written(place, "checkpoint", k);
        assert_ptr_equal(outputs->spare, first);
        assert_int_equal(first->progress.step, k);
    }
    assert_int_equal(outputs_close(outputs, NULL), MNS_OK);
    assert_null(outputs->spare);
}

/* --- the list of snapshots ------------------------------------------------------------------------------------------------ */

static size_t listed_in(const char *directory, ino_t *ret_file)
{
    struct stat about = {.st_ino = 0};
    char *path = path_in(directory, INDEX_NAME);
    json_t *index = json_load_file(path, 0, NULL), *files = json_object_get(index, "files"), *file;
    size_t k;
    stat(path, &about);
    *ret_file = about.st_ino;
    json_array_foreach(files, k, file) if (!holds(directory, json_string_value(json_object_get(file, "name"))))
        fail_msg("it lists what is not there");
    const size_t n = json_array_size(files);
    json_decref(index);
    free(path);
    return n;
}

/* Where each file that is moved is looked for in the list, before and after; NULL: nowhere. And how often one in the list was not there. */
static const char *watched;
static int lies;

static void look_for_lies(void)
{
    char *path = watched ? path_in(watched, INDEX_NAME) : NULL;
    json_t *index = path ? json_load_file(path, 0, NULL) : NULL, *file;
    size_t k;
    json_array_foreach(json_object_get(index, "files"), k, file) lies +=
        !holds(watched, json_string_value(json_object_get(file, "name")));
    json_decref(index);
    free(path);
}

/* In front of that of the C library. */
int rename(const char *from, const char *to)
{
    look_for_lies();
    const int result = renameat(AT_FDCWD, from, AT_FDCWD, to), why = errno;
    look_for_lies();
    errno = why;
    return result;
}

static size_t listed(const Place *place, ino_t *ret_file)
{
    return listed_in(place->home, ret_file);
}

static void snap(Place *place)
{
    Outputs *outputs = &place->outputs;
    step(place);
    assert_int_equal(outputs_snapshot(outputs, place->sim, place->document, 0, NULL, NULL), MNS_OK);
    assert_int_equal(writer_drain(outputs->writer, NULL), MNS_OK);
}

/* As if there were many: other names of one that there is. */
static void add_names(const Place *place, const char *of, unsigned n)
{
    char name[64], *from = path_in(place->home, of);
    for (unsigned k = 0; k < n; k++) {
        snprintf(name, sizeof name, "snapshot-9%09u.hdf", k);
        char *to = path_in(place->home, name);
        assert_int_equal(link(from, to), 0);
        free(to);
    }
    free(from);
}

enum { MANY = 250, MORE = 31 }; /* not a multiple of the three after which it is written */

static void the_list_of_many_snapshots_is_not_written_again_for_each(void **state)
{
    Place *place = *state;
    ino_t before, now;
    int writings = 0;
    snap(place);
    assert_int_equal(listed(place, &before), 1);
    add_names(place, "snapshot-0000000001.hdf", MANY);
    snap(place);
    assert_int_equal(listed(place, &before), MANY + 2);
    for (int k = 0; k < MORE; k++, before = now) {
        place->outputs.listing.next = INFINITY; /* however slow the disk is */
        snap(place);
        listed(place, &now);
        writings += now != before;
    }
    assert_in_range(writings, MORE / 4, MORE / 3);
    assert_int_equal(outputs_close(&place->outputs, NULL), MNS_OK);
    assert_int_equal(listed(place, &now), MANY + 2 + MORE);
}

/* Nobody has to wait for more of them. */
static void the_list_of_many_snapshots_is_soon_whole(void **state)
{
    Place *place = *state;
    ino_t file;
    snap(place);
    add_names(place, "snapshot-0000000001.hdf", MANY);
    snap(place);
    place->outputs.listing.next = clock_now() + 5;
    snap(place);
    assert_int_equal(listed(place, &file), MANY + 2);
    for (int k = 0; k < 600 && listed(place, &file) < MANY + 3; k++)
        nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
    assert_int_equal(listed(place, &file), MANY + 3);
}

/* The list has these many, and there is one more. */
enum { LISTED = MANY + 2 };

static void have_many(Place *place)
{
    ino_t file;
    snap(place);
    add_names(place, "snapshot-0000000001.hdf", MANY);
    snap(place);
    assert_int_equal(listed(place, &file), LISTED);
    place->outputs.listing.next = INFINITY;
}

static void fall_behind(Place *place)
{
    ino_t file;
    have_many(place);
    snap(place);
    assert_int_equal(listed(place, &file), LISTED);
}

static void the_list_is_whole_when_a_run_is_done(void **state)
{
    Place *place = *state;
    ino_t file;
    fall_behind(place);
    assert_int_equal(outputs_finish(&place->outputs, place->sim, place->document, NULL), MNS_OK);
    assert_int_equal(listed(place, &file), LISTED + 1);
}

static void the_list_is_whole_where_a_reset_moves_it(void **state)
{
    Place *place = *state;
    MnsError lost;
    ino_t file;
    fall_behind(place);
    assert_int_equal(outputs_open(&place->outputs, &(OutputsPlace){.directory = place->home, .lock = -1},
                                  place->document, place->sim, &lost, NULL),
                     MNS_OK);
    assert_int_equal(lost.status, MNS_OK);
    assert_int_equal(listed_in(place->outputs.aside, &file), LISTED + 1);
    assert_int_equal(listed(place, &file), 0);
    assert_int_equal(file, 0);
}

/* The next snapshot finds no room, so nothing behind it is written. */
static void fail_to_snap(Place *place)
{
    Outputs *outputs = &place->outputs;
    limit_files(0);
    step(place);
    assert_int_equal(outputs_snapshot(outputs, place->sim, place->document, 0, NULL, NULL), MNS_OK);
    assert_int_not_equal(writer_drain(outputs->writer, NULL), MNS_OK);
}

static void the_list_is_whole_when_what_failed_is_written(void **state)
{
    Place *place = *state;
    ino_t file;
    fall_behind(place);
    fail_to_snap(place);
    assert_int_not_equal(outputs_finish(&place->outputs, place->sim, place->document, NULL), MNS_OK);
    limit_files(SIZE_MAX);
    assert_int_equal(writer_retry(place->outputs.writer, NULL), MNS_OK);
    assert_int_equal(listed(place, &file), LISTED + 2);
}

/* What waited to be listed before, and what only the salvage has written. */
static void the_list_is_whole_behind_a_salvage(void **state)
{
    Place *place = *state;
    ino_t file;
    have_many(place);
    fail_to_snap(place);
    limit_files(SIZE_MAX);
    assert_int_equal(writer_salvage(place->outputs.writer, NULL), MNS_OK);
    assert_int_equal(listed(place, &file), LISTED + 1);
    place->outputs.listing.next = INFINITY;
    snap(place);
    fail_to_snap(place);
    assert_int_equal(listed(place, &file), LISTED + 1);
    limit_files(SIZE_MAX);
    assert_int_equal(writer_salvage(place->outputs.writer, NULL), MNS_OK);
    assert_int_equal(listed(place, &file), LISTED + 3);
}

/* A reader may look at any moment, and files are moved one after the other. */
static void nothing_is_listed_that_has_gone(void **state)
{
    enum { SNAPSHOTS = 8, KEPT = 3 };
    Place *place = *state;
    Outputs *outputs = &place->outputs;
    MnsError lost;
    ino_t file;
    char *in_the_way = path_in(place->home, "case.yaml");
    for (int k = 0; k < SNAPSHOTS; k++) {
        snap(place);
        if (k + 1 != KEPT) continue;
        assert_int_equal(outputs_checkpoint(outputs, place->sim, place->document, NULL, NULL), MNS_OK);
        assert_int_equal(writer_drain(outputs->writer, NULL), MNS_OK);
    }
    Checkpoint checkpoint;
    MnsSim *back;
    char *path = path_in(place->home, "checkpoint-0000000003.hdf");
    assert_int_equal(checkpoint_read(path, &checkpoint, NULL), MNS_OK);
    assert_int_equal(mns_sim_resume(place->document->c, checkpoint.state, &back, NULL), MNS_OK);
    watched = place->home;
    lies = 0;
    for (int goes_on = 1; goes_on >= 0; goes_on--) { /* a restore, a reset; each refused at first */
        unlink(in_the_way);
        assert_int_equal(mkdir(in_the_way, 0777), 0);
        assert_int_not_equal(outputs_open(outputs,
                                          &(OutputsPlace){.directory = place->home, .lock = -1, .goes_on = goes_on},
                                          place->document, back, &lost, NULL),
                             MNS_OK);
        assert_int_equal(lies, 0);
        assert_int_equal(listed(place, &file), goes_on ? SNAPSHOTS : KEPT);
        assert_int_equal(rmdir(in_the_way), 0);
        assert_int_equal(outputs_open(outputs,
                                      &(OutputsPlace){.directory = place->home, .lock = -1, .goes_on = goes_on},
                                      place->document, back, &lost, NULL),
                         MNS_OK);
        assert_int_equal(lies, 0);
        assert_int_equal(listed(place, &file), goes_on ? KEPT : 0);
    }
    watched = NULL;
    mns_sim_free(back);
    checkpoint_done(&checkpoint);
    free(path);
    free(in_the_way);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_finds_no_memory_is_taken_later_and_once, begin, end),
        cmocka_unit_test_setup_teardown(a_last_checkpoint_that_found_no_memory_is_not_left_out, begin, end),
        cmocka_unit_test_setup_teardown(a_last_checkpoint_has_all_before_it_that_found_no_memory, begin, end),
        cmocka_unit_test_setup_teardown(there_is_no_checkpoint_behind_what_is_not_on_the_disk, begin, end),
        cmocka_unit_test_setup_teardown(room_of_what_was_written_is_used_again_until_the_run_is_left, begin, end),
        cmocka_unit_test_setup_teardown(the_list_of_many_snapshots_is_not_written_again_for_each, begin, end),
        cmocka_unit_test_setup_teardown(the_list_of_many_snapshots_is_soon_whole, begin, end),
        cmocka_unit_test_setup_teardown(the_list_is_whole_when_a_run_is_done, begin, end),
        cmocka_unit_test_setup_teardown(the_list_is_whole_where_a_reset_moves_it, begin, end),
        cmocka_unit_test_setup_teardown(the_list_is_whole_when_what_failed_is_written, begin, end),
        cmocka_unit_test_setup_teardown(the_list_is_whole_behind_a_salvage, begin, end),
        cmocka_unit_test_setup_teardown(nothing_is_listed_that_has_gone, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
