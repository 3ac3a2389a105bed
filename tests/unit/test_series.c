/* SPDX-License-Identifier: BSD-3-Clause */
/* Probe series hold every row once, in order, also over a restart and a full disk. */
#include "io/h5.h"
#include "io/series.h"
#include "tests/support/io_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

enum { MOST = 5000 };

/* What a program that knows only HDF5 finds in probes.hdf. */
typedef struct Found {
    size_t n;
    uint64_t step[MOST];
    double time[MOST], p1[MOST];
} Found;

static Series *new_series(const char *dir, const FileMeta *meta, bool resume, uint64_t last_step)
{
    Series *series = NULL;
    assert_int_equal(series_new(dir, meta, resume, last_step, &series, NULL), MNS_OK);
    return series;
}

/* Rows of steps first ... last at t = step / 8, with P1 = 3 step and nothing for the front. */
static void append(Series *series, uint64_t first, uint64_t last)
{
    for (uint64_t step = first; step <= last; step++)
        assert_int_equal(series_append(series, step, (double)step / 8, (double[]){3.0 * (double)step, NAN}, NULL),
                         MNS_OK);
}

static void get(hid_t file, const char *name, hid_t type, void *values, size_t *ret_n)
{
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(set);
    *ret_n = (size_t)H5Sget_simple_extent_npoints(space);
    assert_true(*ret_n <= MOST);
    assert_true(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    H5Sclose(space);
    H5Dclose(set);
}

static Found *find(const char *dir)
{
    char *path = path_in(dir, "probes.hdf");
    Found *found = calloc(1, sizeof *found);
    size_t n = 0;
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    assert_true(file >= 0);
    get(file, "/step", H5T_NATIVE_UINT64, found->step, &found->n);
    get(file, "/time", H5T_NATIVE_DOUBLE, found->time, &n);
    assert_int_equal(n, found->n);
    get(file, "/probes/P1", H5T_NATIVE_DOUBLE, found->p1, &n);
    assert_int_equal(n, found->n);
    H5Fclose(file);
    free(path);
    return found;
}

/* The file holds the rows of steps 1 ... last, each once. */
static void assert_rows(const char *dir, size_t last)
{
    Found *found = find(dir);
    assert_int_equal(found->n, last);
    for (size_t k = 0; k < last; k++) {
        assert_int_equal(found->step[k], k + 1);
        assert_true(found->time[k] == (double)(k + 1) / 8);
        assert_true(found->p1[k] == 3.0 * (double)(k + 1));
    }
    free(found);
}

static void every_row_is_in_the_file_after_a_flush(void **state)
{
    const FileMeta meta = noise_meta();
    Series *series = new_series(*state, &meta, false, 0);
    append(series, 1, 100);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    assert_rows(*state, 100);
    append(series, 101, MOST);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    assert_rows(*state, MOST);
    series_free(series);
}

static void nothing_is_written_before_a_row_is_added(void **state)
{
    const FileMeta meta = noise_meta();
    Series *series = new_series(*state, &meta, false, 0);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    assert_false(holds(*state, "probes.hdf"));
    series_free(series);
}

static void units_are_attributes(void **state)
{
    char *path = path_in(*state, "probes.hdf"), unit[16] = "";
    const FileMeta meta = noise_meta();
    Series *series = new_series(*state, &meta, false, 0);
    append(series, 1, 1);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    const hid_t mark = H5Aopen_by_name(file, "/probes/P1", "unit", H5P_DEFAULT, H5P_DEFAULT), type = H5Aget_type(mark);
    assert_true(H5Tget_size(type) <= sizeof unit && H5Aread(mark, type, unit) >= 0);
    assert_string_equal(unit, mns_probe_unit(&meta.c->probes[0]));
    H5Tclose(type);
    H5Aclose(mark);
    H5Fclose(file);
    series_free(series);
    free(path);
}

static void write_rows(const char *dir, size_t last)
{
    const FileMeta meta = noise_meta();
    Series *series = new_series(dir, &meta, false, 0);
    append(series, 1, last);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    series_free(series);
}

/* A run that is resumed from a checkpoint at step 60 computes the rows after it again. */
static void a_resumed_run_keeps_the_rows_up_to_its_checkpoint(void **state)
{
    const FileMeta meta = noise_meta();
    write_rows(*state, 100);
    Series *series = new_series(*state, &meta, true, 60);
    append(series, 61, 70);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    assert_rows(*state, 70);
    series_free(series);
}

static void rows_cut_off_by_a_resume_leave_the_file_with_the_next_flush(void **state)
{
    const FileMeta meta = noise_meta();
    write_rows(*state, 100);
    Series *series = new_series(*state, &meta, true, 60);
    assert_rows(*state, 100);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    assert_rows(*state, 60);
    series_free(series);
}

static void a_resume_without_a_file_begins_anew(void **state)
{
    const FileMeta meta = noise_meta();
    Series *series = new_series(*state, &meta, true, 60);
    append(series, 1, 2);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    assert_rows(*state, 2);
    series_free(series);
}

static void a_new_run_forgets_the_rows_of_the_one_before(void **state)
{
    const FileMeta meta = noise_meta();
    write_rows(*state, 100);
    Series *series = new_series(*state, &meta, false, 60);
    append(series, 1, 2);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    assert_rows(*state, 2);
    series_free(series);
}

/* Run a resume with probes that differ in one way from those of the file. */
static void assert_begins_anew(const char *dir, MnsProbe *probes, size_t n)
{
    FileMeta meta = noise_meta();
    MnsCase run = *meta.c;
    write_rows(dir, 100);
    run.probes = probes;
    run.n_probes = n;
    meta.c = &run;
    Series *series = new_series(dir, &meta, true, 60);
    append(series, 1, 2);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    assert_rows(dir, 2);
    series_free(series);
}

static void other_probes_begin_anew(void **state)
{
    MnsProbe renamed[] = {{.name = "P1", .kind = MNS_PROBE_PRESSURE}, {.name = "tip", .kind = MNS_PROBE_FRONT}};
    MnsProbe fewer[] = {{.name = "P1", .kind = MNS_PROBE_PRESSURE}};
    MnsProbe another[] = {{.name = "P1", .kind = MNS_PROBE_HEIGHT}, {.name = "front", .kind = MNS_PROBE_FRONT}};
    assert_begins_anew(*state, renamed, 2);
    assert_begins_anew(*state, fewer, 1);
    assert_begins_anew(*state, another, 2);
}

static void a_damaged_file_is_reported_and_left_as_it_is(void **state)
{
    char *path = path_in(*state, "probes.hdf");
    const FileMeta meta = noise_meta();
    Series *series = NULL;
    MnsError error;
    size_t size = 0, after = 0;
    write_rows(*state, 100);
    unsigned char *bytes = bytes_of(path, &size);
    bytes[size / 2] ^= 1;
    put_bytes(path, bytes, size);
    assert_int_equal(series_new(*state, &meta, true, 60, &series, &error), MNS_E_CORRUPT);
    assert_null(series);
    assert_non_null(strstr(error.text, "move it away"));
    unsigned char *left = bytes_of(path, &after);
    assert_int_equal(after, size);
    assert_memory_equal(left, bytes, size);
    free(left);
    free(bytes);
    free(path);
}

/* Three rows, of a time that has a thousand numbers in each. */
static void fill_wide(H5 *h, const void *what)
{
    const MnsCase *c = what;
    const uint64_t step[3] = {1, 2, 3};
    const double values[3] = {1, 2, 3};
    char name[64];
    h5_put(h, "/step", H5T_NATIVE_UINT64, 3, step);
    h5_make(h, "/time", H5T_NATIVE_DOUBLE, 2, (hsize_t[]){3, 1000});
    h5_make_group(h, "/probes");
    for (size_t k = 0; k < c->n_probes; k++) {
        snprintf(name, sizeof name, "/probes/%s", c->probes[k].name);
        h5_put(h, name, H5T_NATIVE_DOUBLE, 3, values);
        h5_mark_text(h, name, "unit", mns_probe_unit(&c->probes[k]));
    }
}

/* They would be written past the end of the memory for them. */
static void columns_of_another_shape_are_refused(void **state)
{
    char *path = path_in(*state, "probes.hdf");
    const FileMeta meta = noise_meta();
    Series *series = NULL;
    MnsError error;
    assert_int_equal(h5_save(path, true, fill_wide, meta.c, &error), MNS_OK);
    assert_int_equal(series_new(*state, &meta, true, 3, &series, &error), MNS_E_CORRUPT);
    assert_non_null(strstr(error.text, "shape"));
    free(path);
}

static void a_full_disk_loses_no_row(void **state)
{
    const FileMeta meta = noise_meta();
    Series *series = new_series(*state, &meta, false, 0);
    append(series, 1, 10);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    append(series, 11, 1000);
    limit_files(16384);
    assert_int_equal(series_flush(series, NULL), MNS_E_NO_SPACE);
    assert_rows(*state, 10);
    limit_files(SIZE_MAX);
    assert_int_equal(series_flush(series, NULL), MNS_OK);
    assert_rows(*state, 1000);
    series_free(series);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_row_is_in_the_file_after_a_flush, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(nothing_is_written_before_a_row_is_added, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(units_are_attributes, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_resumed_run_keeps_the_rows_up_to_its_checkpoint, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(rows_cut_off_by_a_resume_leave_the_file_with_the_next_flush, scratch_begin,
                                        scratch_end),
        cmocka_unit_test_setup_teardown(a_resume_without_a_file_begins_anew, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_new_run_forgets_the_rows_of_the_one_before, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(other_probes_begin_anew, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_damaged_file_is_reported_and_left_as_it_is, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(columns_of_another_shape_are_refused, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_full_disk_loses_no_row, scratch_begin, scratch_end),
    };
    return cmocka_run_group_tests_name("series", tests, NULL, NULL);
}
