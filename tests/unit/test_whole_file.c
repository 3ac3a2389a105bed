/* SPDX-License-Identifier: BSD-3-Clause */
/* Files of the command line: on the disk before they have their name, and their name on the disk before anybody is told. */
#include "client/cli/stream.h"
#include "client/cli/whole_file.h"
#include "tests/support/check.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char place[64], path[128], part[160];
static char synced[8]; /* in order: f, a file without its name yet; F, with it; d, a directory */
static int refusal;    /* errno of the next fsync(), 0: it is done */

/* Instead of the system's. */
int fsync(int fd)
{
    struct stat info;
    const bool is_directory = !fstat(fd, &info) && S_ISDIR(info.st_mode);
    const size_t n = strlen(synced);
    if (n + 1 < sizeof synced) synced[n] = is_directory ? 'd' : access(path, F_OK) ? 'f' : 'F';
    errno = refusal;
    return refusal ? -1 : 0;
}

static int begin(void **state)
{
    (void)state;
    strcpy(place, "/tmp/mns-whole-XXXXXX");
    assert_non_null(mkdtemp(place));
    refusal = 0;
    memset(synced, 0, sizeof synced);
    return 0;
}

static int end(void **state)
{
    (void)state;
    unlink(path);
    unlink(part);
    return rmdir(place);
}

static void call_it(const char *name)
{
    snprintf(path, sizeof path, "%s/%s", place, name);
    snprintf(part, sizeof part, "%s.part", path);
}

static void assert_holds(const char *file, const char *text)
{
    char found[64] = "";
    FILE *from = fopen(file, "rb");
    assert_non_null(from);
    assert_int_equal(fread(found, 1, sizeof found - 1, from), strlen(text));
    fclose(from);
    assert_string_equal(found, text);
}

static bool write_text(FILE *file, const void *arg)
{
    return fputs(arg, file) >= 0;
}

static void a_file_is_on_the_disk_before_it_has_its_name(void **state)
{
    (void)state;
    call_it("table.csv");
    assert_int_equal(whole_file_write(path, "the table", write_text, "x,y\n", NULL), MNS_OK);
    assert_string_equal(synced, "fd");
    assert_holds(path, "x,y\n");
    assert_int_not_equal(access(part, F_OK), 0);
}

static void a_disk_that_is_full_is_told_by_every_way_of_saying_so(void **state)
{
    (void)state;
    static const int full[] = {ENOSPC, EDQUOT, EFBIG};
    const MnsStreamItem item = {.file = "a.vtkhdf", .data = "abc", .size = 3, .whole = true};
    call_it("table.csv");
    for (size_t k = 0; k < sizeof full / sizeof *full; k++) {
        MnsError error = {0};
        refusal = full[k];
        assert_int_equal(whole_file_write(path, "the table", write_text, "x", &error), MNS_E_NO_SPACE);
        assert_non_null(strstr(error.text, strerror(full[k])));
        assert_int_not_equal(access(path, F_OK), 0);
        assert_int_not_equal(access(part, F_OK), 0);
        assert_int_equal(stream_put_file(place, &item, NULL), MNS_E_NO_SPACE);
    }
    refusal = EIO;
    assert_int_equal(whole_file_write(path, "the table", write_text, "x", NULL), MNS_E_IO);
    call_it("a.vtkhdf");
}

static void a_snapshot_that_comes_in_pieces_has_its_name_with_the_last(void **state)
{
    (void)state;
    MnsStreamItem item = {.file = "a.vtkhdf", .data = "abcd", .size = 4};
    call_it("a.vtkhdf");
    assert_int_equal(stream_put_file(place, &item, NULL), MNS_OK);
    assert_string_equal(synced, "");
    assert_holds(part, "abcd");
    assert_int_not_equal(access(path, F_OK), 0);
    item = (MnsStreamItem){.file = "a.vtkhdf", .data = "ef", .size = 2, .offset = 4, .whole = true};
    assert_int_equal(stream_put_file(place, &item, NULL), MNS_OK);
    assert_string_equal(synced, "fd");
    assert_holds(path, "abcdef");
}

static void arrays_are_on_the_disk_too(void **state)
{
    (void)state;
    const double values[] = {1, 2};
    MnsArray array = {
        .name = "density", .type = "<f8", .n_dims = 1, .shape = {2}, .size = sizeof values, .data = values};
    const MnsStreamItem item = {.step = 7, .n_arrays = 1, .arrays = &array};
    struct stat info;
    call_it("density-0000000007.npy");
    assert_int_equal(stream_put_arrays(place, &item, NULL), MNS_OK);
    assert_string_equal(synced, "fd");
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_size, 128 + sizeof values);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_file_is_on_the_disk_before_it_has_its_name, begin, end),
        cmocka_unit_test_setup_teardown(a_disk_that_is_full_is_told_by_every_way_of_saying_so, begin, end),
        cmocka_unit_test_setup_teardown(a_snapshot_that_comes_in_pieces_has_its_name_with_the_last, begin, end),
        cmocka_unit_test_setup_teardown(arrays_are_on_the_disk_too, begin, end),
    };
    return cmocka_run_group_tests_name("whole files", tests, NULL, NULL);
}
