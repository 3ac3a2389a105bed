/* SPDX-License-Identifier: BSD-3-Clause */
/* How much memory there is: the least of what the machine, the control groups and the limit of addresses leave. */
#include "run/memory.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include <string.h>

static void assert_free(const char *root, size_t bytes, const char *part)
{
    const char *why = "";
    assert_int_equal(memory_free(root, &why), bytes);
    assert_non_null(strstr(why, part));
}

static void without_other_limits_it_is_what_the_machine_has_available(void **state)
{
    put_file(*state, "proc/meminfo", "MemTotal: 900 kB\nMemFree: 5 kB\nMemAvailable:     700 kB\nSwapFree: 10 kB\n");
    assert_free(*state, 700 * 1024, "this machine");
}

static void a_group_leaves_its_limit_less_what_is_used_and_not_given_back(void **state)
{
    put_file(*state, "proc/meminfo", "MemAvailable: 700000 kB\n");
    put_file(*state, "proc/self/cgroup", "0::/user/me\n");
    put_file(*state, "sys/fs/cgroup/user/me/memory.max", "100000\n");
    put_file(*state, "sys/fs/cgroup/user/me/memory.current", "30000\n");
    assert_free(*state, 70000, "control group");
    put_file(*state, "sys/fs/cgroup/user/me/memory.stat", "anon 20000\ninactive_file 10000\n");
    assert_free(*state, 80000, "control group");
    put_file(*state, "sys/fs/cgroup/user/memory.max", "90000\n"); /* of all of the user's */
    put_file(*state, "sys/fs/cgroup/user/memory.current", "40000\n");
    assert_free(*state, 50000, "control group");
    put_file(*state, "sys/fs/cgroup/user/memory.max", "max\n");
    assert_free(*state, 80000, "control group");
    put_file(*state, "sys/fs/cgroup/user/me/memory.current", "200000\n");
    assert_free(*state, 0, "control group");
}

static void groups_of_version_1_count_too(void **state)
{
    put_file(*state, "proc/meminfo", "MemAvailable: 700000 kB\n");
    put_file(*state, "proc/self/cgroup", "7:cpu,cpuacct:/box\n4:memory:/box\n1:name=systemd:/\n");
    put_file(*state, "sys/fs/cgroup/memory/box/memory.limit_in_bytes", "100000\n");
    put_file(*state, "sys/fs/cgroup/memory/box/memory.usage_in_bytes", "60000\n");
    assert_free(*state, 40000, "control group");
}

/* A container has a path that is not there, and its own group in the place of the root. */
static void the_group_that_a_container_sees_as_the_root_counts(void **state)
{
    put_file(*state, "proc/self/cgroup", "0::/docker/4711\n");
    put_file(*state, "sys/fs/cgroup/memory.max", "100000\n");
    put_file(*state, "sys/fs/cgroup/memory.current", "30000\n");
    assert_free(*state, 70000, "control group");
}

static void where_nothing_is_known_nothing_is_refused(void **state)
{
    assert_free(*state, SIZE_MAX, "");
}

static void this_machine_has_some(void **state)
{
    (void)state;
    const char *why = NULL;
    const size_t bytes = memory_free("", &why);
    assert_true(bytes > 1000000 && bytes < SIZE_MAX);
    assert_non_null(why);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(without_other_limits_it_is_what_the_machine_has_available, scratch_begin,
                                        scratch_end),
        cmocka_unit_test_setup_teardown(a_group_leaves_its_limit_less_what_is_used_and_not_given_back, scratch_begin,
                                        scratch_end),
        cmocka_unit_test_setup_teardown(groups_of_version_1_count_too, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(the_group_that_a_container_sees_as_the_root_counts, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(where_nothing_is_known_nothing_is_refused, scratch_begin, scratch_end),
        cmocka_unit_test(this_machine_has_some),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
