/* SPDX-License-Identifier: BSD-3-Clause */
/* A checkpoint gives back the state bit for bit, or says that it is damaged: never a wrong state, never a crash. */
#include "io/atomic_file.h"
#include "io/checkpoint.h"
#include "io/h5.h"
#include "io/seal.h"
#include "tests/support/draw.h"
#include "tests/support/io_fixture.h"
#include "tests/support/sims.h"

#include <endian.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <cmocka.h>

static const char blob[] = "a packed case\0with a zero in it";

static MnsStatus write_state(const char *dir, const MnsCapture *state, unsigned keep, char *ret_path)
{
    const FileMeta meta = noise_meta();
    return checkpoint_write(dir, state, &meta, blob, sizeof blob, keep, ret_path, NULL);
}

/* A whole checkpoint at a step, last written at `second`. @return its path, to be freed. */
static char *write_step(const char *dir, uint64_t step, time_t second, unsigned keep)
{
    char *path = calloc(1, IO_PATH_MAX);
    MnsCapture *state = noise_capture(2, 20, 10, step);
    state->progress.step = step;
    assert_int_equal(write_state(dir, state, keep, path), MNS_OK);
    put_date(path, second);
    mns_capture_free(state);
    return path;
}

static void assert_newest(const char *dir, const char *path)
{
    Checkpoint read;
    assert_int_equal(checkpoint_newest(dir, &read, NULL, NULL, NULL, NULL), MNS_OK);
    assert_string_equal(read.path, path);
    checkpoint_done(&read);
}

/* What is said of it is read from error, which may be NULL. */
static void assert_refused(const char *path, MnsStatus status, MnsError *error)
{
    Checkpoint read;
    assert_int_equal(checkpoint_read(path, &read, error), status);
}

/* --- what goes in comes out -------------------------------------------------------------------------------------- */

static void assert_comes_back(const char *dir, int dim)
{
    char path[IO_PATH_MAX];
    MnsCapture *written = noise_capture(dim, 301, 200, 5);
    Checkpoint read;
    assert_int_equal(write_state(dir, written, 3, path), MNS_OK);
    assert_non_null(strstr(path, "/checkpoint-0000004711.hdf"));
    assert_int_equal(checkpoint_read(path, &read, NULL), MNS_OK);
    assert_true(same_values(written, read.state, written->fields));
    assert_true(same_progress(&written->progress, &read.state->progress));
    assert_int_equal(read.case_size, sizeof blob);
    assert_memory_equal(read.case_blob, blob, sizeof blob);
    assert_string_equal(read.path, path);
    checkpoint_done(&read);
    mns_capture_free(written);
}

static void state_case_and_progress_come_back_bit_for_bit(void **state)
{
    assert_comes_back(*state, 2);
    assert_comes_back(*state, 3);
}

/* 25 steps, a file, 25 more; and another simulation that begins with the file. */
static void assert_goes_on_from_file(const char *dir, int dim)
{
    char path[IO_PATH_MAX];
    MnsCase *c = case_dam_break(dim, dim == 2 ? 12 : 6);
    const FileMeta meta = {.c = c, .case_name = "dambreak", .case_text = "title: Dam break\n"};
    MnsSim *first = sim_of(c), *second = sim_of(c);
    MnsCapture *state = NULL;
    Checkpoint read;
    sim_steps(first, 25);
    assert_int_equal(mns_sim_capture(first, mns_sim_state_fields(first), &state, NULL), MNS_OK);
    assert_int_equal(checkpoint_write(dir, state, &meta, blob, sizeof blob, 1, path, NULL), MNS_OK);
    sim_steps(first, 25);
    assert_int_equal(checkpoint_read(path, &read, NULL), MNS_OK);
    assert_int_equal(mns_sim_restore(second, read.state, NULL), MNS_OK);
    assert_true(mns_sim_hash(second) != mns_sim_hash(first));
    sim_steps(second, 25);
    assert_true(mns_sim_hash(second) == mns_sim_hash(first));
    checkpoint_done(&read);
    mns_capture_free(state);
    mns_sim_free(second);
    sim_done(first, c);
}

static void a_run_goes_on_from_the_file_as_if_it_had_never_stopped(void **state)
{
    assert_goes_on_from_file(*state, 2);
    assert_goes_on_from_file(*state, 3);
}

static void an_empty_case_is_kept_as_it_is(void **state)
{
    char path[IO_PATH_MAX];
    const FileMeta meta = noise_meta();
    MnsCapture *written = noise_capture(2, 30, 20, 5);
    Checkpoint read;
    assert_int_equal(checkpoint_write(*state, written, &meta, NULL, 0, 3, path, NULL), MNS_OK);
    assert_int_equal(checkpoint_read(path, &read, NULL), MNS_OK);
    assert_int_equal(read.case_size, 0);
    checkpoint_done(&read);
    mns_capture_free(written);
}

static void a_full_disk_drops_no_older_checkpoint(void **state)
{
    char *old = write_step(*state, 1, 1000, 1);
    MnsCapture *next = noise_capture(2, 1000, 500, 5);
    limit_files(20000);
    assert_int_equal(write_state(*state, next, 1, NULL), MNS_E_NO_SPACE);
    limit_files(SIZE_MAX);
    assert_true(exists(old));
    assert_false(holds(*state, ".tmp"));
    assert_int_equal(write_state(*state, next, 1, NULL), MNS_OK);
    assert_false(exists(old));
    mns_capture_free(next);
    free(old);
}

/* --- rotation ---------------------------------------------------------------------------------------------------- */

static void the_last_written_are_kept(void **state)
{
    char *a = write_step(*state, 100, 1000, 2), *b = write_step(*state, 200, 2000, 2);
    char *c = write_step(*state, 300, 3000, 2);
    assert_false(exists(a));
    assert_true(exists(b));
    assert_true(exists(c));
    free(c);
    free(b);
    free(a);
}

static void the_one_just_written_is_kept_whatever_is_asked(void **state)
{
    char *a = write_step(*state, 100, 1000, 0);
    assert_true(exists(a));
    char *b = write_step(*state, 200, 2000, 0);
    assert_false(exists(a));
    assert_true(exists(b));
    free(b);
    free(a);
}

/* After a restore the steps go back, but the run goes on from what was written last. */
static void an_earlier_step_written_later_is_the_newest(void **state)
{
    char *a = write_step(*state, 500, 1000, 3), *b = write_step(*state, 600, 2000, 3);
    char *c = write_step(*state, 400, 3000, 2);
    assert_false(exists(a));
    assert_true(exists(b));
    assert_newest(*state, c);
    free(c);
    free(b);
    free(a);
}

static void note_text(void *arg, const char *text)
{
    snprintf(arg, 512, "%s", text);
}

/* As after cp -r, or in an archive. */
static void dates_that_were_changed_do_not_change_which_is_the_newest(void **state)
{
    char *a = write_step(*state, 100, 5000, 2), *b = write_step(*state, 200, 2000, 2);
    char text[512] = "";
    char name[256];
    Checkpoint read;
    assert_true(checkpoint_last(*state, name));
    assert_string_equal(name, "checkpoint-0000000200.hdf");
    assert_int_equal(checkpoint_newest(*state, &read, NULL, note_text, text, NULL), MNS_OK);
    assert_string_equal(read.path, b);
    assert_non_null(strstr(text, "checkpoint-0000000100.hdf' looks newer"));
    checkpoint_done(&read);
    char *c = write_step(*state, 300, 1000, 2);
    assert_false(exists(a));
    assert_true(exists(b));
    assert_newest(*state, c);
    free(c);
    free(b);
    free(a);
}

/* With no number in it, as an older program did. */
static void seal_again(const char *path)
{
    const int fd = open(path, O_RDWR | O_CLOEXEC);
    assert_true(fd >= 0);
    assert_int_equal(seal_write(fd, path, &(SealNote){.number = 0}, NULL), MNS_OK);
    close(fd);
}

static void files_without_a_number_go_by_their_dates(void **state)
{
    char *a = write_step(*state, 200, 1000, 9), *b = write_step(*state, 100, 2000, 9);
    seal_again(a);
    seal_again(b);
    put_date(a, 3000);
    put_date(b, 2000);
    assert_newest(*state, a);
    free(b);
    free(a);
}

static void other_files_are_left_alone(void **state)
{
    char *other = path_in(*state, "checkpoint-notes.txt"), *folder = path_in(*state, "checkpoint-1.hdf");
    put_bytes(other, "mine", 4);
    assert_int_equal(mkdir(folder, 0777), 0);
    char *a = write_step(*state, 100, 1000, 2), *b = write_step(*state, 200, 2000, 2);
    assert_true(exists(other));
    assert_true(exists(folder));
    assert_true(exists(a));
    assert_true(exists(b));
    free(b);
    free(a);
    free(folder);
    free(other);
}

/* --- damage ------------------------------------------------------------------------------------------------------ */

static void count_note(void *arg, const char *text)
{
    assert_true(strlen(text) > 20);
    ++*(int *)arg;
}

static void damaged_ones_are_passed_over_with_a_note(void **state)
{
    char *whole = write_step(*state, 1, 1000, 9), *cut = write_step(*state, 2, 2000, 9);
    char *flipped = write_step(*state, 3, 3000, 9);
    char *empty = path_in(*state, "checkpoint-0000000004.hdf"), *garbage = path_in(*state, "checkpoint-0000000005.hdf");
    unsigned char junk[4096];
    size_t size = 0;
    int notes = 0;
    Checkpoint read;
    assert_int_equal(truncate(cut, 3000), 0);
    unsigned char *bytes = bytes_of(flipped, &size);
    bytes[size / 2] ^= 4;
    put_bytes(flipped, bytes, size);
    put_bytes(empty, "", 0);
    memset(junk, 0xa5, sizeof junk);
    put_bytes(garbage, junk, sizeof junk);
    assert_int_equal(checkpoint_newest(*state, &read, NULL, count_note, &notes, NULL), MNS_OK);
    assert_string_equal(read.path, whole);
    assert_int_equal(notes, 4);
    checkpoint_done(&read);
    free(bytes);
    free(garbage);
    free(empty);
    free(flipped);
    free(cut);
    free(whole);
}

/* Whoever put them there may take them for checkpoints. */
static void what_is_no_file_is_passed_over_with_a_note(void **state)
{
    char *whole = write_step(*state, 1, 1000, 9), *folder = path_in(*state, "checkpoint-0000000002.hdf");
    char *link = path_in(*state, "checkpoint-0000000003.hdf"), *pipe = path_in(*state, "checkpoint-0000000004.hdf");
    int notes = 0;
    Checkpoint read;
    assert_int_equal(mkdir(folder, 0777), 0);
    assert_int_equal(symlink(link, link), 0);
    assert_int_equal(mkfifo(pipe, 0666), 0);
    assert_int_equal(checkpoint_newest(*state, &read, NULL, count_note, &notes, NULL), MNS_OK);
    assert_string_equal(read.path, whole);
    assert_int_equal(notes, 3);
    checkpoint_done(&read);
    assert_refused(pipe, MNS_E_CORRUPT, NULL); /* and nobody waits for one to write into it */
    free(pipe);
    free(link);
    free(folder);
    free(whole);
}

static void no_whole_checkpoint_is_not_found(void **state)
{
    char *path = path_in(*state, "checkpoint-0000000001.hdf"), *nowhere = path_in(*state, "nowhere");
    Checkpoint read = {.case_size = 77};
    MnsError error;
    assert_int_equal(checkpoint_newest(*state, &read, NULL, NULL, NULL, &error), MNS_E_NOT_FOUND);
    assert_int_equal(checkpoint_newest(nowhere, &read, NULL, NULL, NULL, &error), MNS_E_IO);
    put_bytes(path, "garbage", 7);
    assert_int_equal(checkpoint_newest(*state, &read, NULL, NULL, NULL, &error), MNS_E_NOT_FOUND);
    assert_non_null(strstr(error.text, "none of the 1"));
    assert_int_equal(checkpoint_read(nowhere, &read, &error), MNS_E_NOT_FOUND);
    assert_int_equal(read.case_size, 77);
    free(nowhere);
    free(path);
}

/* One random change: a byte, a run of zeros, a cut or something appended. @return the new size. */
static size_t damage(unsigned char *bytes, size_t size, uint64_t *seed)
{
    const size_t at = draw(seed) % size, length = 1 + draw(seed) % 600;
    switch (draw(seed) % 4) {
    case 0: bytes[at] ^= (unsigned char)(1u << draw(seed) % 8); return size;
    case 1: memset(bytes + at, 0, at + length < size ? length : size - at); return size;
    case 2: return at;
    default: memset(bytes + size, 0x5a, length); return size + length;
    }
}

static void damage_is_an_error_or_makes_no_difference(void **state)
{
    char path[IO_PATH_MAX];
    MnsCapture *written = noise_capture(2, 40, 30, 5);
    uint64_t seed = 20240501;
    size_t size = 0;
    int refused = 0;
    assert_int_equal(write_state(*state, written, 1, path), MNS_OK);
    unsigned char *whole = bytes_of(path, &size), *bytes = malloc(size + 1024);
    for (int k = 0; k < 2000; k++) {
        Checkpoint read;
        memcpy(bytes, whole, size);
        put_bytes(path, bytes, damage(bytes, size, &seed));
        const MnsStatus status = checkpoint_read(path, &read, NULL);
        if (status) {
            assert_int_equal(status, MNS_E_CORRUPT);
            refused++;
            continue;
        }
        assert_true(same_values(written, read.state, written->fields));
        assert_true(same_progress(&written->progress, &read.state->progress));
        checkpoint_done(&read);
    }
    assert_true(refused > 1000);
    free(bytes);
    free(whole);
    mns_capture_free(written);
}

/* Also in its version: another one is believed only if the seal is whole. */
static void every_bit_of_the_seal_counts(void **state)
{
    char *path = write_step(*state, 1, 1000, 1);
    size_t size = 0;
    unsigned char *bytes = bytes_of(path, &size);
    for (size_t bit = 0; bit < 8 * (size_t)SEAL_SIZE; bit++) {
        bytes[bit / 8] ^= (unsigned char)(1u << bit % 8);
        put_bytes(path, bytes, size);
        assert_refused(path, MNS_E_CORRUPT, NULL);
        bytes[bit / 8] ^= (unsigned char)(1u << bit % 8);
    }
    free(bytes);
    free(path);
}

static void the_format_of_another_version_is_named(void **state)
{
    char *path = write_step(*state, 1, 1000, 1);
    size_t size = 0;
    MnsError error;
    unsigned char *bytes = bytes_of(path, &size);
    bytes[8] = SEAL_VERSION + 1;
    const uint64_t hash = htole64(XXH64(bytes, SEAL_SIZE - sizeof hash, 0));
    memcpy(bytes + SEAL_SIZE - sizeof hash, &hash, sizeof hash);
    put_bytes(path, bytes, size);
    assert_refused(path, MNS_E_VERSION, &error);
    assert_non_null(strstr(error.text, "format 2"));
    free(bytes);
    free(path);
}

static void a_cut_file_says_what_is_missing(void **state)
{
    char *path = write_step(*state, 1, 1000, 1), wanted[64];
    size_t size = 0;
    MnsError error;
    free(bytes_of(path, &size));
    snprintf(wanted, sizeof wanted, "it has 3000 bytes, %zu were written", size);
    assert_int_equal(truncate(path, 3000), 0);
    assert_refused(path, MNS_E_CORRUPT, &error);
    assert_non_null(strstr(error.text, wanted));
    free(path);
}

/* --- behind a seal that is right --------------------------------------------------------------------------------- */

static hid_t open_to_change(const char *path)
{
    const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    assert_true(file >= 0);
    return file;
}

static void close_changed(hid_t file, const char *path)
{
    assert_true(H5Fclose(file) >= 0);
    seal_again(path);
}

/* Add 1 to the first byte of a dataset, as a failing memory would have done before the file was sealed. */
static void assert_change_is_noticed(const char *dir, const char *name)
{
    char *path = write_step(dir, 5, 1000, 1);
    unsigned char bytes[4096];
    MnsError error;
    const hid_t file = open_to_change(path), set = H5Dopen2(file, name, H5P_DEFAULT), type = H5Dget_type(set);
    assert_true(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes) >= 0);
    bytes[0]++;
    assert_true(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes) >= 0);
    H5Tclose(type);
    H5Dclose(set);
    close_changed(file, path);
    assert_refused(path, MNS_E_CORRUPT, &error);
    assert_non_null(strstr(error.text, "checksum"));
    free(path);
}

static void every_part_has_a_checksum_of_its_own(void **state)
{
    char name[128];
    for (int k = 0; mns_fields()[k].name; k++) {
        snprintf(name, sizeof name, "/state/%s", mns_fields()[k].name);
        assert_change_is_noticed(*state, name);
    }
    assert_change_is_noticed(*state, "/case");
}

static void set_scalar(hid_t file, const char *name, uint64_t value)
{
    const hid_t scalar = H5Screate(H5S_SCALAR);
    assert_true(H5Adelete_by_name(file, "/state", name, H5P_DEFAULT) >= 0);
    const hid_t mark =
        H5Acreate_by_name(file, "/state", name, H5T_NATIVE_UINT64, scalar, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(H5Awrite(mark, H5T_NATIVE_UINT64, &value) >= 0);
    H5Aclose(mark);
    H5Sclose(scalar);
}

static void a_changed_scalar_is_noticed(void **state)
{
    static const char *const names[] = {"dim", "n",        "n_fluid", "spacing",  "t",
                                        "dt",  "dt_first", "step",    "rebuilds", "guarded"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        char *path = write_step(*state, 5, 1000, 1);
        MnsError error;
        const hid_t file = open_to_change(path);
        set_scalar(file, names[k], 4);
        close_changed(file, path);
        assert_refused(path, MNS_E_CORRUPT, &error);
        assert_non_null(strstr(error.text, "checksum of its scalars"));
        free(path);
    }
}

/* Whether one is missing, the scheme knows (test_restart.c). */
static void unknown_fields_are_another_version(void **state)
{
    char *path = write_step(*state, 5, 1000, 1);
    const hid_t file = open_to_change(path);
    H5Gclose(H5Gcreate2(file, "/state/flavour", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    close_changed(file, path);
    assert_refused(path, MNS_E_VERSION, NULL);
    free(path);
}

/* A longer one would be written past the end of the capture. */
static void a_field_of_another_length_is_refused(void **state)
{
    MnsError error;
    for (hsize_t length = 19; length <= 21; length += 2) {
        char *path = write_step(*state, 5, 1000, 1);
        const hid_t file = open_to_change(path), space = H5Screate_simple(2, (hsize_t[]){1, length}, NULL);
        assert_true(H5Ldelete(file, "/state/density", H5P_DEFAULT) >= 0);
        H5Dclose(H5Dcreate2(file, "/state/density", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
        H5Sclose(space);
        close_changed(file, path);
        assert_refused(path, MNS_E_CORRUPT, &error);
        assert_non_null(strstr(error.text, "shape"));
        free(path);
    }
}

/* A dataset without a checksum, and without any bytes in the file. */
static void assert_case_refused(const char *dir, int rank, const hsize_t *dims, const char *wanted)
{
    char *path = write_step(dir, 5, 1000, 1);
    MnsError error;
    const hid_t file = open_to_change(path), space = H5Screate_simple(rank, dims, NULL);
    assert_true(H5Ldelete(file, "/case", H5P_DEFAULT) >= 0);
    H5Dclose(H5Dcreate2(file, "/case", H5T_NATIVE_UINT8, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Sclose(space);
    close_changed(file, path);
    assert_refused(path, MNS_E_CORRUPT, &error);
    assert_non_null(strstr(error.text, wanted));
    free(path);
}

/* Its rows would be written past the end of the memory for it. */
static void a_case_of_two_dimensions_is_refused(void **state)
{
    assert_case_refused(*state, 2, (hsize_t[]){16, 4096}, "shape");
}

/* Else a few bytes would ask for any amount of memory; and lack of memory passes no file over for an older one. */
static void what_a_file_cannot_hold_is_damage_and_no_lack_of_memory(void **state)
{
    static const char *const whole[] = {"dim", "n", "n_fluid", "step", "rebuilds", "guarded"};
    static const char *const real[] = {"spacing", "t", "dt", "dt_first"};
    MnsError error;
    assert_case_refused(*state, 1, (hsize_t[]){UINT64_C(1) << 40}, "more bytes");
    char *path = write_step(*state, 5, 1000, 1);
    const hid_t file = open_to_change(path);
    uint64_t values[10];
    for (int k = 0; k < 10; k++) {
        const hid_t mark = H5Aopen_by_name(file, "/state", k < 6 ? whole[k] : real[k - 6], H5P_DEFAULT, H5P_DEFAULT);
        assert_true(H5Aread(mark, k < 6 ? H5T_NATIVE_UINT64 : H5T_NATIVE_DOUBLE, &values[k]) >= 0);
        H5Aclose(mark);
    }
    set_scalar(file, "n", values[1] = UINT32_MAX);
    set_scalar(file, "xxh64", XXH64(values, sizeof values, 0));
    close_changed(file, path);
    assert_refused(path, MNS_E_CORRUPT, &error);
    assert_non_null(strstr(error.text, "more bytes"));
    free(path);
}

static void an_hdf5_file_without_a_state_is_refused(void **state)
{
    char *path = path_in(*state, "checkpoint-0000000001.hdf");
    const hid_t creation = H5Pcreate(H5P_FILE_CREATE);
    H5Pset_userblock(creation, SEAL_SIZE);
    close_changed(H5Fcreate(path, H5F_ACC_TRUNC, creation, H5P_DEFAULT), path);
    H5Pclose(creation);
    assert_refused(path, MNS_E_CORRUPT, NULL);
    put_bytes(path, "nothing but bytes", 17);
    assert_int_equal(truncate(path, 4096), 0);
    seal_again(path);
    assert_refused(path, MNS_E_CORRUPT, NULL);
    free(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(state_case_and_progress_come_back_bit_for_bit, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_run_goes_on_from_the_file_as_if_it_had_never_stopped, scratch_begin,
                                        scratch_end),
        cmocka_unit_test_setup_teardown(an_empty_case_is_kept_as_it_is, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_full_disk_drops_no_older_checkpoint, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(the_last_written_are_kept, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(the_one_just_written_is_kept_whatever_is_asked, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(an_earlier_step_written_later_is_the_newest, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(dates_that_were_changed_do_not_change_which_is_the_newest, scratch_begin,
                                        scratch_end),
        cmocka_unit_test_setup_teardown(files_without_a_number_go_by_their_dates, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(other_files_are_left_alone, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(damaged_ones_are_passed_over_with_a_note, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(what_is_no_file_is_passed_over_with_a_note, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(no_whole_checkpoint_is_not_found, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(damage_is_an_error_or_makes_no_difference, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(every_bit_of_the_seal_counts, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(the_format_of_another_version_is_named, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_cut_file_says_what_is_missing, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(every_part_has_a_checksum_of_its_own, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_changed_scalar_is_noticed, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(unknown_fields_are_another_version, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_field_of_another_length_is_refused, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_case_of_two_dimensions_is_refused, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(what_a_file_cannot_hold_is_damage_and_no_lack_of_memory, scratch_begin,
                                        scratch_end),
        cmocka_unit_test_setup_teardown(an_hdf5_file_without_a_state_is_refused, scratch_begin, scratch_end),
    };
    return cmocka_run_group_tests_name("checkpoint", tests, NULL, NULL);
}
