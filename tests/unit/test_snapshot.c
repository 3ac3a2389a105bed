/* SPDX-License-Identifier: BSD-3-Clause */
/* A snapshot holds what was captured, in the layout ParaView knows; a full or broken disk costs that snapshot only. */
#include "io/h5.h"
#include "io/names.h"
#include "io/snapshot.h"
#include "tests/support/io_fixture.h"

#include <errno.h>
#include <jansson.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

/* --- the file, seen with HDF5 alone ------------------------------------------------------------------------------ */

static void get(hid_t file, const char *name, hid_t type, void *values)
{
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
    assert_true(set >= 0 && H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    H5Dclose(set);
}

static void get_about(hid_t file, const char *name, hid_t type, void *value)
{
    const hid_t mark = H5Aopen_by_name(file, "/meniscus", name, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(mark >= 0 && H5Aread(mark, type, value) >= 0);
    H5Aclose(mark);
}

static void name_of(int k, size_t size, char name[])
{
    if (k == mns_field_find("position")) snprintf(name, size, "/VTKHDF/Points");
    else snprintf(name, size, "/VTKHDF/PointData/%s", mns_fields()[k].name);
}

/* The values of field k of the first n particles, bit for bit, row by row; of a vector three, the last zero in 2D. */
static void assert_holds(hid_t file, int k, const MnsCapture *c, size_t n)
{
    const MnsFieldInfo *field = &mns_fields()[k];
    const size_t size = h5_size(field->type), width = (size_t)field->components;
    char name[128], *rows = calloc(n * width, size);
    static const char zero[8];
    name_of(k, sizeof name, name);
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(set);
    assert_int_equal(H5Sget_simple_extent_npoints(space), n * width);
    H5Sclose(space);
    H5Dclose(set);
    get(file, name, h5_type(field->type), rows);
    for (size_t i = 0; i < n; i++)
        for (size_t d = 0; d < width; d++) {
            const char *column = width == 1 || d < (size_t)c->dim ? c->data[k][d] : NULL;
            assert_memory_equal(rows + (i * width + d) * size, column ? column + i * size : zero, size);
        }
    free(rows);
}

/* The file holds the fields of the capture for the first n particles, no others, and its moment. */
static void assert_is(const char *path, const MnsCapture *c, size_t n)
{
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    assert_true(file >= 0);
    double t, dt, spacing;
    uint64_t step, fluid;
    get_about(file, "time", H5T_NATIVE_DOUBLE, &t);
    get_about(file, "dt", H5T_NATIVE_DOUBLE, &dt);
    get_about(file, "spacing", H5T_NATIVE_DOUBLE, &spacing);
    get_about(file, "step", H5T_NATIVE_UINT64, &step);
    get_about(file, "fluid_particles", H5T_NATIVE_UINT64, &fluid);
    assert_true(t == c->progress.t && dt == c->progress.dt && spacing == c->spacing);
    assert_int_equal(step, c->progress.step);
    assert_int_equal(fluid, c->n_fluid);
    for (int k = 0; mns_fields()[k].name; k++) {
        char name[128];
        name_of(k, sizeof name, name);
        if (c->fields >> k & 1) assert_holds(file, k, c, n);
        else assert_true(H5Lexists(file, name, H5P_DEFAULT) == 0);
    }
    H5Fclose(file);
}

static void assert_comes_back(const char *dir, int dim, size_t n)
{
    char *path = path_in(dir, "snapshot.hdf");
    const FileMeta meta = noise_meta();
    MnsCapture *written = noise_capture(dim, n, n / 2, 1);
    MnsCase run = *meta.c;
    run.dim = dim;
    assert_int_equal(snapshot_write(path, written,
                                    &(FileMeta){.c = &run, .case_name = "noise", .case_text = "title: Noise\n"}, NULL),
                     MNS_OK);
    assert_is(path, written, n);
    mns_capture_free(written);
    free(path);
}

/* 70 000 rows are more than the buffer between columns and rows holds. */
static void every_field_comes_back_bit_for_bit(void **state)
{
    assert_comes_back(*state, 2, 101);
    assert_comes_back(*state, 3, 101);
    assert_comes_back(*state, 3, 70000);
}

static void fields_that_were_not_captured_are_not_there(void **state)
{
    char *path = path_in(*state, "snapshot.hdf");
    const FileMeta meta = noise_meta();
    const uint64_t few = UINT64_C(1) << mns_field_find("position") | UINT64_C(1) << mns_field_find("pressure");
    MnsCapture *written = noise_capture(2, 50, 50, 1);
    written->fields = few;
    assert_int_equal(snapshot_write(path, written, &meta, NULL), MNS_OK);
    assert_is(path, written, 50);
    mns_capture_free(written);
    free(path);
}

static void a_capture_without_positions_is_refused(void **state)
{
    char *path = path_in(*state, "snapshot.hdf");
    const FileMeta meta = noise_meta();
    MnsCapture *capture = noise_capture(2, 50, 50, 1);
    capture->fields = UINT64_C(1) << mns_field_find("pressure");
    assert_int_equal(snapshot_write(path, capture, &meta, NULL), MNS_E_INVALID);
    assert_int_equal(access(path, F_OK), -1);
    mns_capture_free(capture);
    free(path);
}

static void walls_stay_out_if_the_case_says_so(void **state)
{
    char *path = path_in(*state, "snapshot.hdf");
    FileMeta meta = noise_meta();
    MnsCase run = *meta.c;
    MnsCapture *written = noise_capture(2, 100, 60, 1);
    run.output.walls = false;
    meta.c = &run;
    assert_int_equal(snapshot_write(path, written, &meta, NULL), MNS_OK);
    assert_is(path, written, 60);
    mns_capture_free(written);
    free(path);
}

static void assert_texts(hid_t file, const char *name)
{
    static const char *const wanted[] = {"unit", "meaning"};
    for (int k = 0; k < 2; k++) assert_true(H5Aexists_by_name(file, name, wanted[k], H5P_DEFAULT) > 0);
}

static herr_t look_at(hid_t group, const char *name, const H5L_info_t *info, void *count)
{
    (void)info;
    assert_texts(group, name);
    ++*(int *)count;
    return 0;
}

static void every_field_says_its_unit_and_meaning(void **state)
{
    char *path = path_in(*state, "snapshot.hdf");
    const FileMeta meta = noise_meta();
    MnsCapture *capture = noise_capture(2, 10, 5, 1);
    int count = 0, fields = 0;
    while (mns_fields()[fields].name) fields++;
    assert_int_equal(snapshot_write(path, capture, &meta, NULL), MNS_OK);
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    assert_true(file >= 0);
    assert_texts(file, "/VTKHDF/Points");
    assert_true(H5Literate_by_name(file, "/VTKHDF/PointData", H5_INDEX_NAME, H5_ITER_INC, NULL, look_at, &count,
                                   H5P_DEFAULT) >= 0);
    assert_int_equal(count, fields - 1);
    H5Fclose(file);
    mns_capture_free(capture);
    free(path);
}

static void every_particle_is_a_vertex_cell(void **state)
{
    enum { N = 7 };
    char *path = path_in(*state, "snapshot.hdf");
    const FileMeta meta = noise_meta();
    MnsCapture *capture = noise_capture(2, N, 5, 1);
    int64_t count = 0, connectivity[N], offsets[N + 1];
    uint8_t types[N];
    double points[N][3];
    assert_int_equal(snapshot_write(path, capture, &meta, NULL), MNS_OK);
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    get(file, "/VTKHDF/NumberOfCells", H5T_NATIVE_INT64, &count);
    get(file, "/VTKHDF/Connectivity", H5T_NATIVE_INT64, connectivity);
    get(file, "/VTKHDF/Offsets", H5T_NATIVE_INT64, offsets);
    get(file, "/VTKHDF/Types", H5T_NATIVE_UINT8, types);
    get(file, "/VTKHDF/Points", H5T_NATIVE_DOUBLE, points);
    assert_int_equal(count, N);
    for (int k = 0; k < N; k++) {
        assert_int_equal(connectivity[k], k);
        assert_int_equal(offsets[k], k);
        assert_int_equal(types[k], 1);
        assert_true(points[k][2] == 0);
    }
    assert_int_equal(offsets[N], N);
    H5Fclose(file);
    mns_capture_free(capture);
    free(path);
}

/* --- disks that are full, files that are broken ------------------------------------------------------------------ */

/* Wherever the disk fills up, in a dataset, in the metadata written at closing or in between. */
static void a_disk_full_at_any_byte_costs_only_the_new_file(void **state)
{
    char *path = path_in(*state, "snapshot.hdf");
    const FileMeta meta = noise_meta();
    MnsCapture *old = noise_capture(2, 10, 5, 1), *new = noise_capture(3, 100, 50, 2);
    MnsError error;
    size_t whole = 0, failures = 0;
    assert_int_equal(snapshot_write(path, new, &meta, NULL), MNS_OK);
    free(bytes_of(path, &whole));
    assert_int_equal(snapshot_write(path, old, &meta, NULL), MNS_OK);
    for (size_t limit = 0; limit < whole; limit += 509) {
        limit_files(limit);
        assert_int_equal(snapshot_write(path, new, &meta, &error), MNS_E_NO_SPACE);
        assert_non_null(strstr(error.text, path));
        assert_false(holds(*state, ".tmp"));
        assert_int_equal(H5Fget_obj_count((hid_t)H5F_OBJ_ALL, H5F_OBJ_ALL), 0);
        failures++;
    }
    assert_true(failures > 20);
    assert_is(path, old, 10);
    limit_files(SIZE_MAX);
    assert_int_equal(snapshot_write(path, new, &meta, NULL), MNS_OK);
    mns_capture_free(new);
    mns_capture_free(old);
    free(path);
}

static bool put_line(const char *path, const char *line)
{
    FILE *file = fopen(path, "w");
    if (!file) return false;
    const bool put = fputs(line, file) >= 0;
    return fclose(file) == 0 && put;
}

/* Mounts of this process alone, so that nothing stays mounted whatever happens. Whoever may not have them gets them as the
 * root of a name space of users. */
static bool enter_namespace(void)
{
    char user[64], group[64];
    snprintf(user, sizeof user, "0 %u 1", (unsigned)geteuid());
    snprintf(group, sizeof group, "0 %u 1", (unsigned)getegid());
    if (unshare(CLONE_NEWNS) == 0) return true;
    return unshare(CLONE_NEWUSER | CLONE_NEWNS) == 0 && put_line("/proc/self/uid_map", user) &&
           put_line("/proc/self/setgroups", "deny") && put_line("/proc/self/gid_map", group);
}

static bool mount_small_disk(const char *dir)
{
    return enter_namespace() && mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) == 0 &&
           mount("tmpfs", dir, "tmpfs", 0, "size=64k") == 0;
}

static void a_full_file_system_is_no_space(void **state)
{
    char *path = path_in(*state, "snapshot.hdf");
    const FileMeta meta = noise_meta();
    if (!mount_small_disk(*state))
        fail_msg("cannot mount a small file system: %s; this test needs root or name spaces of users", strerror(errno));
    MnsCapture *big = noise_capture(3, 1000, 500, 1), *small = noise_capture(3, 10, 5, 2);
    const MnsStatus full = snapshot_write(path, big, &meta, NULL);
    const bool left = holds(*state, ".tmp");
    const MnsStatus after = snapshot_write(path, small, &meta, NULL);
    umount(*state);
    assert_int_equal(full, MNS_E_NO_SPACE);
    assert_false(left);
    assert_int_equal(after, MNS_OK);
    mns_capture_free(small);
    mns_capture_free(big);
    free(path);
}

static herr_t count_print(hid_t stack, void *count)
{
    (void)stack;
    ++*(int *)count;
    return 0;
}

static void hdf5_prints_nothing_of_ours_and_all_of_its_callers(void **state)
{
    char *path = path_in(*state, "snapshot-1.hdf");
    int count = 0;
    H5E_auto2_t print;
    void *arg;
    H5Eget_auto2(H5E_DEFAULT, &print, &arg);
    H5Eset_auto2(H5E_DEFAULT, count_print, &count);
    put_bytes(path, "garbage", 7);
    assert_int_equal(snapshot_index(*state, UINT64_MAX, NULL, NULL, NULL, NULL), MNS_OK);
    assert_int_equal(count, 0);
    assert_true(H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT) < 0);
    assert_int_equal(count, 1);
    H5Eset_auto2(H5E_DEFAULT, print, arg);
    free(path);
}

/* --- the index --------------------------------------------------------------------------------------------------- */

static void write_at(const char *dir, const char *name, double t)
{
    char *path = path_in(dir, name);
    const FileMeta meta = noise_meta();
    MnsCapture *capture = noise_capture(2, 10, 5, 1);
    capture->progress.t = t;
    assert_int_equal(snapshot_write(path, capture, &meta, NULL), MNS_OK);
    mns_capture_free(capture);
    free(path);
}

static void the_index_lists_whole_snapshots_by_time(void **state)
{
    char *index = path_in(*state, "snapshots.hdf.series"), *broken = path_in(*state, "snapshot-3.hdf");
    const char *name = NULL;
    double t = 0;
    write_at(*state, "snapshot-2.hdf", 1.0 / 3);
    write_at(*state, "snapshot-1.hdf", 0.5);
    put_bytes(broken, "garbage", 7);
    assert_int_equal(snapshot_index(*state, UINT64_MAX, NULL, NULL, NULL, NULL), MNS_OK);
    json_t *json = json_load_file(index, 0, NULL);
    json_t *files = json_object_get(json, "files");
    assert_string_equal(json_string_value(json_object_get(json, "file-series-version")), "1.0");
    assert_int_equal(json_array_size(files), 2);
    assert_int_equal(json_unpack(json_array_get(files, 0), "{s:s, s:f}", "name", &name, "time", &t), 0);
    assert_string_equal(name, "snapshot-2.hdf");
    assert_true(t == 1.0 / 3);
    assert_int_equal(json_unpack(json_array_get(files, 1), "{s:s, s:f}", "name", &name, "time", &t), 0);
    assert_string_equal(name, "snapshot-1.hdf");
    assert_true(t == 0.5);
    json_decref(json);
    free(broken);
    free(index);
}

static double indexed_time(const char *dir, size_t k)
{
    char *path = path_in(dir, INDEX_NAME);
    json_t *json = json_load_file(path, 0, NULL);
    const double t = json_real_value(json_object_get(json_array_get(json_object_get(json, "files"), k), "time"));
    json_decref(json);
    free(path);
    return t;
}

static void pass_a_tick(void)
{
    nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL); /* of the clock of file systems */
}

/* What the index says of a file that is as it was is believed, so a lie in it shows which files were opened. */
static void only_files_that_changed_are_opened_for_the_index(void **state)
{
    static const char lie[] =
        "{\"files\": [{\"name\": \"snapshot-1.hdf\", \"time\": 7.5}, "
        "{\"name\": \"snapshot-2.hdf\", \"time\": 9.5}, {\"name\": \"gone.hdf\", \"time\": 1.0}]}";
    char *index = path_in(*state, INDEX_NAME), *away = path_in(*state, "away"),
         *one = path_in(*state, "snapshot-1.hdf");
    write_at(*state, "snapshot-1.hdf", 0.5);
    write_at(*state, "snapshot-2.hdf", 0.75);
    pass_a_tick();
    put_bytes(index, lie, sizeof lie - 1);
    pass_a_tick();
    write_at(*state, "snapshot-2.hdf", 8.5);
    assert_int_equal(snapshot_index(*state, UINT64_MAX, NULL, NULL, NULL, NULL), MNS_OK);
    assert_true(indexed_time(*state, 0) == 7.5);
    assert_true(indexed_time(*state, 1) == 8.5);
    pass_a_tick();
    assert_int_equal(rename(one, away) | rename(away, one), 0); /* as old as before, but it could be another one */
    assert_int_equal(snapshot_index(*state, UINT64_MAX, NULL, NULL, NULL, NULL), MNS_OK);
    assert_true(indexed_time(*state, 0) == 0.5);
    free(index);
    free(away);
    free(one);
}

static void note_text(void *arg, const char *text)
{
    strncat(arg, text, 500);
}

static void a_damaged_snapshot_is_left_out_with_a_note(void **state)
{
    char *bad = path_in(*state, "snapshot-2.hdf");
    char text[1024] = "";
    write_at(*state, "snapshot-1.hdf", 0.5);
    write_at(*state, "snapshot-2.hdf", 0.75);
    assert_int_equal(truncate(bad, 3000), 0);
    assert_int_equal(snapshot_index(*state, UINT64_MAX, NULL, note_text, text, NULL), MNS_OK);
    assert_true(indexed_time(*state, 0) == 0.5);
    assert_non_null(strstr(text, "snapshot-2.hdf' is damaged"));
    assert_null(strstr(text, "snapshot-1.hdf"));
    free(bad);
}

static void a_directory_without_snapshots_has_an_empty_index(void **state)
{
    char *index = path_in(*state, "snapshots.hdf.series"), *nowhere = path_in(*state, "nowhere");
    assert_int_equal(snapshot_index(*state, UINT64_MAX, NULL, NULL, NULL, NULL), MNS_OK);
    json_t *json = json_load_file(index, 0, NULL);
    assert_true(json_is_array(json_object_get(json, "files")));
    assert_int_equal(json_array_size(json_object_get(json, "files")), 0);
    assert_int_equal(snapshot_index(nowhere, UINT64_MAX, NULL, NULL, NULL, NULL), MNS_E_IO);
    json_decref(json);
    free(nowhere);
    free(index);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_field_comes_back_bit_for_bit, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(fields_that_were_not_captured_are_not_there, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_capture_without_positions_is_refused, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(walls_stay_out_if_the_case_says_so, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(every_field_says_its_unit_and_meaning, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(every_particle_is_a_vertex_cell, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_disk_full_at_any_byte_costs_only_the_new_file, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_full_file_system_is_no_space, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(hdf5_prints_nothing_of_ours_and_all_of_its_callers, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(the_index_lists_whole_snapshots_by_time, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(only_files_that_changed_are_opened_for_the_index, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_damaged_snapshot_is_left_out_with_a_note, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_directory_without_snapshots_has_an_empty_index, scratch_begin, scratch_end),
    };
    return cmocka_run_group_tests_name("snapshot", tests, NULL, NULL);
}
