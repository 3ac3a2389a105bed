/* SPDX-License-Identifier: BSD-3-Clause */
/* How many processors may be used: those that the process is bound to, and no more than its control groups let it use. */
#include "common/host/processors.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include <math.h>
#include <sched.h>

static int bound(void)
{
    cpu_set_t set;
    return sched_getaffinity(0, sizeof set, &set) ? 0 : CPU_COUNT(&set);
}

static void assert_quota(const char *root, double quota, int threads)
{
    const Processors found = processors_look(root);
    assert_int_equal(found.bound, bound());
    assert_true(found.quota == quota);
    assert_int_equal(found.threads, threads < bound() ? threads : bound());
}

static void without_a_quota_it_is_those_that_the_process_is_bound_to(void **state)
{
    assert_quota(*state, INFINITY, bound());
    put_file(*state, "proc/self/cgroup", "0::/user/me\n");
    put_file(*state, "sys/fs/cgroup/user/me/cpu.max", "max 100000\n");
    assert_quota(*state, INFINITY, bound());
}

static void a_part_of_a_processor_is_one_thread(void **state)
{
    put_file(*state, "proc/self/cgroup", "0::/user/me\n");
    put_file(*state, "sys/fs/cgroup/user/me/cpu.max", "50000 100000\n");
    assert_quota(*state, 0.5, 1);
    put_file(*state, "sys/fs/cgroup/user/me/cpu.max", "150000 100000\n");
    assert_quota(*state, 1.5, 2);
    put_file(*state, "sys/fs/cgroup/user/cpu.max", "25000 50000\n"); /* of all of the user's */
    assert_quota(*state, 0.5, 1);
}

static void groups_of_version_1_count_too(void **state)
{
    put_file(*state, "proc/self/cgroup", "7:cpu,cpuacct:/box\n4:memory:/box\n0::/\n");
    put_file(*state, "sys/fs/cgroup/cpu,cpuacct/box/cpu.cfs_quota_us", "-1\n");
    put_file(*state, "sys/fs/cgroup/cpu,cpuacct/box/cpu.cfs_period_us", "100000\n");
    assert_quota(*state, INFINITY, bound());
    put_file(*state, "sys/fs/cgroup/cpu,cpuacct/box/cpu.cfs_quota_us", "75000\n");
    assert_quota(*state, 0.75, 1);
}

/* A container has a path that is not there, and its own group in the place of the root. */
static void the_group_that_a_container_sees_as_the_root_counts(void **state)
{
    put_file(*state, "proc/self/cgroup", "3:cpu:/docker/4711\n");
    put_file(*state, "sys/fs/cgroup/cpu/cpu.cfs_quota_us", "50000\n");
    put_file(*state, "sys/fs/cgroup/cpu/cpu.cfs_period_us", "100000\n");
    assert_quota(*state, 0.5, 1);
}

static void rubbish_is_no_quota(void **state)
{
    static const char *const rubbish[] = {"", "\n", "0 100000\n", "-5 100000\n", "50000 0\n", "50000\n", "x y\n"};
    put_file(*state, "proc/self/cgroup", "rubbish\n0::/user/me\n");
    for (size_t k = 0; k < sizeof rubbish / sizeof *rubbish; k++) {
        put_file(*state, "sys/fs/cgroup/user/me/cpu.max", rubbish[k]);
        assert_quota(*state, INFINITY, bound());
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(without_a_quota_it_is_those_that_the_process_is_bound_to, scratch_begin,
                                        scratch_end),
        cmocka_unit_test_setup_teardown(a_part_of_a_processor_is_one_thread, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(groups_of_version_1_count_too, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(the_group_that_a_container_sees_as_the_root_counts, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(rubbish_is_no_quota, scratch_begin, scratch_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
