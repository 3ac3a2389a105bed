/* SPDX-License-Identifier: BSD-3-Clause */
/* What the writer of snapshots has written, the reader of pictures finds again; what is no snapshot is refused. */
#include "client/cli/render_frame.h"
#include "io/snapshot.h"
#include "tests/support/dialogue.h"
#include "tests/support/draw.h"
#include "tests/support/io_fixture.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

enum { N = 60, N_FLUID = 45 };

static double *column(MnsCapture *c, const char *field, int d)
{
    const int k = mns_field_find(field);
    assert_true(k >= 0);
    return c->data[k][d];
}

/* A capture whose places, velocities and phases are known, and a snapshot of it with walls. */
static MnsCapture *write_known(const char *path)
{
    MnsCapture *c = noise_capture(2, N, N_FLUID, 5);
    MnsCase with_walls = *noise_meta().c;
    FileMeta meta = noise_meta();
    MnsError error = {0};
    uint8_t *phase = c->data[mns_field_find("phase")][0];
    for (int i = 0; i < N; i++) {
        column(c, "position", 0)[i] = 0.5 * i;
        column(c, "position", 1)[i] = -2.0 * i;
        column(c, "velocity", 0)[i] = 3.0 * i;
        column(c, "velocity", 1)[i] = 4.0 * i;
        column(c, "density", 0)[i] = i % 2 ? 1000 : 1;
        phase[i] = (uint8_t)(i < N_FLUID ? i % 2 : 2);
    }
    with_walls.output.walls = true;
    meta.c = &with_walls;
    meta.case_text = dialogue_case;
    assert_int_equal(snapshot_write(path, c, &meta, &error), MNS_OK);
    return c;
}

static void a_snapshot_is_read_as_it_was_written(void **state)
{
    char *path = path_in(*state, "a.hdf");
    MnsCapture *c = write_known(path);
    const FileMeta meta = noise_meta();
    Frame frame;
    MnsError error = {0};
    assert_int_equal(frame_read_file(path, "velocity", &frame, &error), MNS_OK);
    assert_int_equal(frame.n, N);
    assert_int_equal(frame.n_fluid, N_FLUID);
    assert_int_equal(frame.dim, 2);
    assert_true(frame.time == c->progress.t && frame.spacing == c->spacing);
    assert_string_equal(frame.title, meta.c->title);
    assert_int_equal(frame.n_fluids, meta.c->n_fluids);
    for (size_t k = 0; k < frame.n_fluids; k++) assert_string_equal(frame.fluids[k], meta.c->fluids[k].name);
    for (int i = 0; i < N; i++) {
        assert_true(frame.x[i][0] == 0.5 * i && frame.x[i][1] == -2.0 * i && frame.x[i][2] == 0);
        assert_int_equal(frame.phase[i], i < N_FLUID ? i % 2 : 2);
        assert_true(fabs(frame.value[i] - 5.0 * i) < 1e-12 * N);
    }
    assert_true(frame.is_magnitude);
    assert_string_equal(frame.unit, "m/s");
    assert_true(frame.has_domain && frame.domain[1][0] == 2 && frame.domain[1][1] == 1);
    assert_true(frame.gravity[0] == 0 && frame.gravity[1] == -1);
    assert_int_equal(frame_heaviest(&frame), 1);
    frame_done(&frame);
    mns_capture_free(c);
    free(path);
}

static void a_picture_of_phases_needs_no_other_field(void **state)
{
    char *path = path_in(*state, "a.hdf");
    MnsCapture *c = write_known(path);
    Frame frame;
    assert_int_equal(frame_read_file(path, "phase", &frame, NULL), MNS_OK);
    assert_null(frame.value);
    frame_done(&frame);
    mns_capture_free(c);
    free(path);
}

static void refuses(const char *path, const char *field, MnsStatus status, const char *says)
{
    Frame frame;
    MnsError error = {0};
    assert_int_equal(frame_read_file(path, field, &frame, &error), status);
    if (!strstr(error.text, says)) fail_msg("no %s in: %s", says, error.text);
}

static void a_missing_field_is_answered_with_those_there_are(void **state)
{
    char *path = path_in(*state, "a.hdf");
    mns_capture_free(write_known(path));
    refuses(path, "presure", MNS_E_NOT_FOUND, "\"presure\"");
    refuses(path, "presure", MNS_E_NOT_FOUND, "pressure");
    refuses(path, "", MNS_E_NOT_FOUND, "acceleration");
    refuses(path, "../Points", MNS_E_NOT_FOUND, "density");
    free(path);
}

static void what_is_no_snapshot_is_refused(void **state)
{
    char *missing = path_in(*state, "no.hdf"), *text = path_in(*state, "text.hdf");
    put_bytes(text, "hello", 5);
    refuses(missing, "phase", MNS_E_IO, "No such file");
    refuses(text, "phase", MNS_E_CORRUPT, "text.hdf");
    refuses(*state, "phase", MNS_E_IO, "is a directory");
    free(missing);
    free(text);
}

static void a_cut_snapshot_is_refused_wherever_it_was_cut(void **state)
{
    char *path = path_in(*state, "a.hdf");
    size_t size;
    mns_capture_free(write_known(path));
    unsigned char *bytes = bytes_of(path, &size);
    for (size_t cut = 0; cut < size; cut += 509) {
        put_bytes(path, bytes, cut);
        refuses(path, "phase", MNS_E_CORRUPT, "a.hdf is damaged");
    }
    free(bytes);
    free(path);
}

/* Every way of being cut short, and noise anywhere, ends in a frame or a sentence, never in a crash. */
static void a_damaged_snapshot_is_read_or_refused_but_never_trusted(void **state)
{
    char *path = path_in(*state, "a.hdf");
    mns_capture_free(write_known(path));
    size_t size;
    unsigned char *bytes = bytes_of(path, &size);
    uint64_t seed = 11;
    int refused = 0;
    for (int k = 0; k < 200; k++) {
        Frame frame;
        unsigned char *copy = malloc(size);
        memcpy(copy, bytes, size);
        for (int b = 0; b < 4; b++) copy[draw(&seed) % size] = (unsigned char)draw(&seed);
        put_bytes(path, copy, k % 4 ? size : draw(&seed) % size);
        MnsError error = {0};
        if (frame_read_file(path, "pressure", &frame, &error)) {
            assert_true(error.text[0] != '\0');
            refused++;
        } else {
            frame_done(&frame);
        }
        free(copy);
    }
    assert_true(refused >= 50);
    free(bytes);
    free(path);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, scratch_begin, scratch_end)
    const struct CMUnitTest tests[] = {
        TEST(a_snapshot_is_read_as_it_was_written),
        TEST(a_picture_of_phases_needs_no_other_field),
        TEST(a_missing_field_is_answered_with_those_there_are),
        TEST(what_is_no_snapshot_is_refused),
        TEST(a_cut_snapshot_is_refused_wherever_it_was_cut),
        TEST(a_damaged_snapshot_is_read_or_refused_but_never_trusted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
