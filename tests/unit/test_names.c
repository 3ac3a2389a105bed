/* SPDX-License-Identifier: BSD-3-Clause */
/* Names of numbered files are read as they are written, and no others are. */
#include "io/names.h"
#include "tests/support/check.h"

static void a_name_leads_back_to_its_step(void **state)
{
    (void)state;
    static const uint64_t steps[] = {0, 7, 100, 9999999999, 10000000000, UINT64_MAX};
    static const char *const begins[] = {CHECKPOINT_BEGIN, SNAPSHOT_BEGIN};
    for (size_t k = 0; k < 2 * sizeof steps / sizeof *steps; k++) {
        char name[NUMBERED_NAME];
        uint64_t step = 1;
        name_numbered(begins[k % 2], steps[k / 2], name);
        assert_true(name_step(name, &step));
        assert_true(step == steps[k / 2]);
    }
}

static void names_are_as_people_know_them(void **state)
{
    (void)state;
    char name[NUMBERED_NAME];
    name_numbered(CHECKPOINT_BEGIN, 100, name);
    assert_string_equal(name, "checkpoint-0000000100.hdf");
    name_numbered(SNAPSHOT_BEGIN, 12345678901, name);
    assert_string_equal(name, "snapshot-12345678901.hdf");
}

static void other_names_are_not_taken_for_ours(void **state)
{
    (void)state;
    static const char *const others[] = {"",
                                         "probes.hdf",
                                         "snapshots.hdf.series",
                                         "checkpoint-.hdf",
                                         "checkpoint-100.hdf",
                                         "checkpoint--000000100.hdf",
                                         "checkpoint- 000000100.hdf",
                                         "checkpoint-0000000100.hdf.tmp",
                                         "checkpoint-0000000100.h5",
                                         "checkpoint-00000000100.hdf",
                                         "Snapshot-0000000100.hdf",
                                         "my-snapshot-0000000100.hdf",
                                         "snapshot-99999999999999999999999.hdf"};
    for (size_t k = 0; k < sizeof others / sizeof *others; k++) {
        uint64_t step = 42;
        if (name_step(others[k], &step)) fail_msg("%s is taken for step %lu", others[k], (unsigned long)step);
        assert_true(step == 42);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_name_leads_back_to_its_step),
        cmocka_unit_test(names_are_as_people_know_them),
        cmocka_unit_test(other_names_are_not_taken_for_ours),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
