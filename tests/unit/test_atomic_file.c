/* SPDX-License-Identifier: BSD-3-Clause */
/* A file with its final name is always whole, and what goes wrong is said exactly. */
#include "io/atomic_file.h"
#include "tests/support/draw.h"
#include "tests/support/io_fixture.h"

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static void assert_content(const char *path, const char *text)
{
    size_t size = 0;
    unsigned char *bytes = bytes_of(path, &size);
    assert_int_equal(size, strlen(text));
    assert_memory_equal(bytes, text, size);
    free(bytes);
}

static void a_file_appears_with_its_name_only_when_committed(void **state)
{
    char *path = path_in(*state, "a.txt");
    AtomicFile file;
    assert_int_equal(atomic_begin(&file, path, NULL), MNS_OK);
    assert_int_equal(file_write_at(file.fd, "new", 3, 0), 0);
    assert_int_not_equal(access(path, F_OK), 0);
    assert_int_equal(atomic_commit(&file, NULL), MNS_OK);
    assert_content(path, "new");
    assert_false(holds(*state, ".tmp"));
    free(path);
}

static void a_cancelled_file_leaves_the_old_one(void **state)
{
    char *path = path_in(*state, "a.txt");
    AtomicFile file;
    assert_int_equal(atomic_write(path, "old", 3, NULL), MNS_OK);
    assert_int_equal(atomic_begin(&file, path, NULL), MNS_OK);
    assert_int_equal(file_write_at(file.fd, "new", 3, 0), 0);
    atomic_cancel(&file);
    assert_content(path, "old");
    assert_false(holds(*state, ".tmp"));
    free(path);
}

static void a_full_disk_is_said_and_leaves_the_old_file(void **state)
{
    char *path = path_in(*state, "a.txt"), *big = calloc(1, 100000);
    MnsError error;
    assert_int_equal(atomic_write(path, "old", 3, NULL), MNS_OK);
    limit_files(65536);
    assert_int_equal(atomic_write(path, big, 100000, &error), MNS_E_NO_SPACE);
    assert_non_null(strstr(error.text, path));
    assert_content(path, "old");
    assert_false(holds(*state, ".tmp"));
    limit_files(SIZE_MAX);
    assert_int_equal(atomic_write(path, big, 100000, &error), MNS_OK);
    free(big);
    free(path);
}

static void what_a_killed_writer_left_behind_is_in_nobodys_way(void **state)
{
    char *path = path_in(*state, "a.txt"), *left = path_in(*state, "a.txt.tmp");
    put_bytes(left, "left behind, and longer", 23);
    assert_int_equal(atomic_write(path, "new", 3, NULL), MNS_OK);
    assert_content(path, "new");
    free(left);
    free(path);
}

static void a_link_in_place_of_the_temporary_is_not_followed(void **state)
{
    char *path = path_in(*state, "a.txt"), *trap = path_in(*state, "a.txt.tmp"), *victim = path_in(*state, "victim");
    put_bytes(victim, "mine", 4);
    assert_int_equal(symlink(victim, trap), 0);
    assert_int_equal(atomic_write(path, "new", 3, NULL), MNS_E_IO);
    assert_content(victim, "mine");
    free(victim);
    free(trap);
    free(path);
}

static void a_missing_directory_is_named(void **state)
{
    char *path = path_in(*state, "nowhere/a.txt");
    MnsError error;
    assert_int_equal(atomic_write(path, "new", 3, &error), MNS_E_IO);
    assert_non_null(strstr(error.text, "nowhere/a.txt"));
    free(path);
}

static void a_directory_is_not_replaced_by_a_file(void **state)
{
    char *path = path_in(*state, "sub"), *left = path_in(*state, "sub.tmp");
    assert_int_equal(mkdir(path, 0777), 0);
    assert_int_equal(atomic_write(path, "new", 3, NULL), MNS_E_IO);
    assert_int_equal(access(left, F_OK), -1);
    assert_int_equal(rmdir(path), 0);
    free(left);
    free(path);
}

static void a_path_too_long_is_refused(void **state)
{
    (void)state;
    char path[IO_PATH_MAX];
    MnsError error;
    memset(path, 'x', sizeof path - 1);
    path[sizeof path - 1] = '\0';
    assert_int_equal(atomic_write(path, "new", 3, &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "4091"));
}

static void a_read_says_where_the_file_ends(void **state)
{
    char *path = path_in(*state, "a.txt");
    char found[8] = "";
    size_t got = 0;
    AtomicFile file;
    assert_int_equal(atomic_begin(&file, path, NULL), MNS_OK);
    assert_int_equal(file_write_at(file.fd, "hello", 5, 0), 0);
    assert_int_equal(file_read_at(file.fd, found, sizeof found, 2, &got), 0);
    assert_int_equal(got, 3);
    assert_memory_equal(found, "llo", 3);
    assert_int_equal(file_read_at(-1, found, sizeof found, 0, &got), EBADF);
    atomic_cancel(&file);
    free(path);
}

static void a_filled_file_has_no_name_yet_and_then_all_its_bytes(void **state)
{
    char *path = path_in(*state, "a.txt"), *big = calloc(1, 100000);
    AtomicFile file;
    put_bytes(path, "old", 3);
    assert_int_equal(atomic_fill(&file, path, "newer", 5, NULL), MNS_OK);
    assert_content(path, "old");
    assert_int_equal(atomic_commit(&file, NULL), MNS_OK);
    assert_content(path, "newer");
    limit_files(65536);
    assert_int_equal(atomic_fill(&file, path, big, 100000, NULL), MNS_E_NO_SPACE);
    limit_files(SIZE_MAX);
    assert_content(path, "newer");
    assert_false(holds(*state, ".tmp"));
    free(big);
    free(path);
}

/* Sizes around that of the buffer. */
static void a_copy_has_the_same_bytes(void **state)
{
    char *from = path_in(*state, "a.txt"), *to = path_in(*state, "b.txt"), *bytes = malloc(150000);
    uint64_t seed = 7;
    for (size_t k = 0; k < 150000; k++) bytes[k] = (char)draw(&seed);
    const size_t sizes[] = {0, 5, 65535, 65536, 65537, 131072, 150000};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        size_t size = 0;
        put_bytes(from, bytes, sizes[k]);
        assert_int_equal(atomic_copy(from, to, NULL), MNS_OK);
        unsigned char *found = bytes_of(to, &size);
        assert_int_equal(size, sizes[k]);
        assert_memory_equal(found, bytes, size);
        free(found);
    }
    assert_false(holds(*state, ".tmp"));
    free(bytes);
    free(to);
    free(from);
}

static void every_errno_has_its_status(void **state)
{
    (void)state;
    assert_int_equal(file_fail(NULL, ENOSPC, "write", "a"), MNS_E_NO_SPACE);
    assert_int_equal(file_fail(NULL, EDQUOT, "write", "a"), MNS_E_NO_SPACE);
    assert_int_equal(file_fail(NULL, EFBIG, "write", "a"), MNS_E_NO_SPACE);
    assert_int_equal(file_fail(NULL, ENOENT, "create", "a"), MNS_E_IO);
    assert_int_equal(file_fail(NULL, ENOMEM, "read", "a"), MNS_E_MEMORY);
    assert_int_equal(file_fail(NULL, EACCES, "open", "a"), MNS_E_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_file_appears_with_its_name_only_when_committed, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_cancelled_file_leaves_the_old_one, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_full_disk_is_said_and_leaves_the_old_file, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(what_a_killed_writer_left_behind_is_in_nobodys_way, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_link_in_place_of_the_temporary_is_not_followed, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_missing_directory_is_named, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_directory_is_not_replaced_by_a_file, scratch_begin, scratch_end),
        cmocka_unit_test(a_path_too_long_is_refused),
        cmocka_unit_test_setup_teardown(a_read_says_where_the_file_ends, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(a_filled_file_has_no_name_yet_and_then_all_its_bytes, scratch_begin,
                                        scratch_end),
        cmocka_unit_test_setup_teardown(a_copy_has_the_same_bytes, scratch_begin, scratch_end),
        cmocka_unit_test(every_errno_has_its_status),
    };
    return cmocka_run_group_tests_name("atomic_file", tests, NULL, NULL);
}
