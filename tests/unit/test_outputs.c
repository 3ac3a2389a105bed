/* SPDX-License-Identifier: BSD-3-Clause */
/* What a run leaves behind is all there, and once, also when there was no memory for it at first. */
#include "io/h5.h"
#include "proto/case_file.h"
#include "run/outputs.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include "tests/support/memory.h"
#include <stdio.h>
#include <stdlib.h>

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
        status =
            outputs_open(&place->outputs, place->home, place->document, place->sim, false, false, &(MnsError){0}, NULL);
    return (int)status;
}

static int end(void **state)
{
    Place *place = *state;
    memory_fails_after(-1);
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
        failures += fails(outputs_finish, place, n % 2);
        assert_written(place, "checkpoint", n);
        step(place);
    }
    assert_int_equal(failures,
                     STEPS / 2); /* there is room for the copy from the first one on: one allocation is left */
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_finds_no_memory_is_taken_later_and_once, begin, end),
        cmocka_unit_test_setup_teardown(a_last_checkpoint_that_found_no_memory_is_not_left_out, begin, end),
        cmocka_unit_test_setup_teardown(room_of_what_was_written_is_used_again_until_the_run_is_left, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
