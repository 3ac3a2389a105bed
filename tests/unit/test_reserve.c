/* SPDX-License-Identifier: BSD-3-Clause */
/* Room that is held is really there, can grow, and has no name. What a full disk does is tests/system/test_disk_full.py. */
#include "io/reserve.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include <dirent.h>
#include <string.h>
#include <sys/stat.h>

static unsigned files_in(const char *directory)
{
    unsigned n = 0;
    DIR *stream = opendir(directory);
    if (!stream) fail_msg("cannot open %s", directory);
    for (struct dirent *entry; (entry = readdir(stream));) n += entry->d_name[0] != '.' || strlen(entry->d_name) > 2;
    closedir(stream);
    return n;
}

static uint64_t room_of(const Reserve *reserve)
{
    struct stat about;
    assert_int_equal(fstat(reserve->fd, &about), 0);
    return (uint64_t)about.st_blocks * 512;
}

static void what_is_held_takes_room_and_no_name(void **state)
{
    (void)state;
    char *home = scratch_new();
    Reserve reserve = {.held = false};
    for (uint64_t size = 100000; size <= 300000; size += 100000) {
        assert_int_equal(reserve_hold(&reserve, home, size, NULL), MNS_OK);
        assert_true(reserve.held && reserve.size == size);
        assert_true(room_of(&reserve) >= size);
        assert_int_equal(files_in(home), 0);
    }
    assert_int_equal(reserve_hold(&reserve, home, 5, NULL), MNS_OK); /* it does not shrink */
    assert_true(room_of(&reserve) >= 300000);
    reserve_release(&reserve);
    assert_false(reserve.held);
    reserve_release(&reserve);
    scratch_free(home);
}

static void a_directory_that_is_not_there_is_named(void **state)
{
    (void)state;
    Reserve reserve = {.held = false};
    MnsError error;
    assert_int_equal(reserve_hold(&reserve, "/nowhere/at/all", 1000, &error), MNS_E_IO);
    assert_non_null(strstr(error.text, "/nowhere/at/all"));
    assert_false(reserve.held);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_held_takes_room_and_no_name),
        cmocka_unit_test(a_directory_that_is_not_there_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
