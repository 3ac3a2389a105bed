/* SPDX-License-Identifier: BSD-3-Clause */
/* The thread that writes: nothing lost, nothing out of order, nobody waits for ever. */
#include "base/clock.h"
#include "run/writer.h"
#include "tests/support/check.h"
#include <math.h>
#include <stdatomic.h>
#include <time.h>

/* A job that notes its number when it is done, and fails while `broken`. */
typedef struct Probe {
    Job job;
    int number, told;
    MnsStatus told_status;
} Probe;

static _Atomic bool broken;
static int done[16];
static _Atomic int n_done;

static MnsStatus write_number(Job *job, MnsError *error)
{
    if (broken) return mns_fail(error, MNS_E_NO_SPACE, "the disk is full");
    done[n_done] = ((Probe *)job)->number;
    n_done++;
    return MNS_OK;
}

static void told(Job *job, MnsStatus status, const MnsError *error)
{
    Probe *probe = (Probe *)job;
    (void)error;
    probe->told++;
    probe->told_status = status;
}

static int begin(void **state)
{
    Writer *writer = NULL;
    broken = false;
    n_done = 0;
    const MnsStatus status = writer_new(NULL, NULL, &writer, NULL);
    *state = writer;
    return (int)status;
}

static int end(void **state)
{
    writer_free(*state);
    return 0;
}

static void make(Probe *probes, int n, bool heavy)
{
    for (int k = 0; k < n; k++)
        probes[k] = (Probe){.job = {.heavy = heavy, .write = write_number, .told = told}, .number = k};
}

static void jobs_are_done_in_order(void **state)
{
    Probe probes[6];
    make(probes, 6, true);
    for (int k = 0; k < 6; k++) writer_post(*state, &probes[k].job);
    assert_int_equal(writer_drain(*state, NULL), MNS_OK);
    assert_int_equal(n_done, 6);
    for (int k = 0; k < 6; k++) assert_int_equal(done[k], k);
}

static void a_failed_job_is_kept_and_done_before_all_behind_it(void **state)
{
    Probe probes[4];
    MnsError error = {.status = MNS_OK};
    make(probes, 4, true);
    broken = true;
    for (int k = 0; k < 4; k++) writer_post(*state, &probes[k].job);
    assert_int_equal(writer_drain(*state, &error), MNS_E_NO_SPACE);
    assert_string_equal(error.text, "the disk is full");
    assert_int_equal(n_done, 0);
    assert_int_equal(writer_retry(*state, NULL), MNS_E_NO_SPACE);
    broken = false;
    assert_int_equal(writer_retry(*state, NULL), MNS_OK);
    assert_int_equal(n_done, 4);
    for (int k = 0; k < 4; k++) assert_int_equal(done[k], k);
}

static void who_asked_is_told_of_the_first_failure_once(void **state)
{
    Probe probe;
    make(&probe, 1, false);
    broken = true;
    writer_post(*state, &probe.job);
    writer_drain(*state, NULL);
    writer_retry(*state, NULL);
    broken = false;
    writer_retry(*state, NULL);
    assert_int_equal(probe.told, 1);
    assert_int_equal(probe.told_status, MNS_E_NO_SPACE);
}

static MnsStatus fail_slowly(Job *job, MnsError *error)
{
    (void)job;
    nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL);
    return mns_fail(error, MNS_E_NO_SPACE, "the disk is full");
}

static void who_waits_behind_a_failure_is_told_too(void **state)
{
    Probe probes[3];
    make(probes, 3, true);
    probes[0].job.write = fail_slowly;
    writer_post(*state, &probes[0].job);
    writer_post(*state, &probes[1].job); /* while the writer is busy */
    assert_int_equal(writer_drain(*state, NULL), MNS_E_NO_SPACE);
    writer_post(*state, &probes[2].job); /* when it has failed */
    for (int k = 0; k < 3; k++) {
        assert_int_equal(probes[k].told, 1);
        assert_int_equal(probes[k].told_status, MNS_E_NO_SPACE);
    }
    assert_int_equal(writer_discard(*state), 3);
}

static void a_call_passes_a_failed_job_which_stays(void **state)
{
    Probe probes[2];
    make(probes, 2, false);
    broken = true;
    writer_post(*state, &probes[0].job);
    assert_int_equal(writer_drain(*state, NULL), MNS_E_NO_SPACE);
    broken = false;
    assert_int_equal(writer_call(*state, &probes[1].job, NULL), MNS_OK);
    assert_int_equal(n_done, 1);
    assert_int_equal(done[0], 1);
    assert_int_equal(writer_failure(*state, NULL), MNS_E_NO_SPACE);
    assert_int_equal(writer_discard(*state), 1);
    assert_int_equal(writer_failure(*state, NULL), MNS_OK);
}

static void a_failed_call_is_not_kept(void **state)
{
    Probe probe;
    MnsError error = {.status = MNS_OK};
    make(&probe, 1, false);
    broken = true;
    assert_int_equal(writer_call(*state, &probe.job, &error), MNS_E_NO_SPACE);
    assert_int_equal(error.status, MNS_E_NO_SPACE);
    assert_int_equal(writer_drain(*state, NULL), MNS_OK);
}

/* Fails whatever `broken` says. */
static MnsStatus refuse(Job *job, MnsError *error)
{
    (void)job;
    return mns_fail(error, MNS_E_IO, "a directory of that name is in the way");
}

static void a_salvage_writes_all_but_what_fails_and_no_row_behind_a_missing_one(void **state)
{
    Probe probes[6];
    MnsError error = {.status = MNS_OK};
    make(probes, 6, false);
    probes[0].job.write = refuse;
    probes[2].job.write = refuse;
    probes[1].job.row = probes[2].job.row = probes[3].job.row = true;
    for (int k = 0; k < 6; k++) writer_post(*state, &probes[k].job);
    assert_int_equal(writer_salvage(*state, &error), MNS_E_IO);
    assert_string_equal(error.text, "a directory of that name is in the way");
    assert_int_equal(n_done, 3);
    assert_int_equal(done[0], 1);
    assert_int_equal(done[1], 4);
    assert_int_equal(done[2], 5);
    probes[0].job.write = probes[2].job.write = write_number;
    assert_int_equal(writer_retry(*state, NULL), MNS_OK);
    assert_int_equal(n_done, 6);
    assert_int_equal(done[3], 0);
    assert_int_equal(done[4], 2);
    assert_int_equal(done[5], 3);
}

static void a_salvage_writes_nothing_that_seals_what_is_missing(void **state)
{
    Probe probes[3];
    make(probes, 3, false);
    probes[0].job.seals = probes[2].job.seals = true;
    probes[1].job.write = refuse;
    for (int k = 0; k < 3; k++) writer_post(*state, &probes[k].job);
    assert_int_equal(writer_salvage(*state, NULL), MNS_E_IO);
    assert_int_equal(n_done, 1);
    assert_int_equal(done[0], 0);
    probes[1].job.write = write_number;
    assert_int_equal(writer_salvage(*state, NULL), MNS_OK);
    assert_int_equal(n_done, 3);
    assert_int_equal(done[2], 2);
}

static void a_late_job_waits_for_its_moment_and_not_if_hurried(void **state)
{
    Probe probes[3];
    make(probes, 3, false);
    const double moment = clock_now() + 0.05;
    writer_post_late(*state, &probes[0].job, moment);
    while (n_done < 1) nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    assert_true(clock_now() >= moment);
    writer_drain(*state, NULL);
    writer_post_late(*state, &probes[1].job, INFINITY);
    writer_post(*state, &probes[2].job);
    assert_int_equal(writer_drain(*state, NULL), MNS_OK);
    assert_int_equal(n_done, 2);
    assert_int_equal(done[1], 2);
    writer_hurry(*state);
    assert_int_equal(writer_drain(*state, NULL), MNS_OK);
    assert_int_equal(n_done, 3);
    writer_hurry(*state);
    assert_int_equal(writer_drain(*state, NULL), MNS_OK);
}

static void a_late_job_is_discarded_with_the_others(void **state)
{
    Probe probe;
    make(&probe, 1, false);
    writer_post_late(*state, &probe.job, INFINITY);
    assert_int_equal(writer_discard(*state), 1);
    assert_int_equal(probe.told_status, MNS_E_INTERRUPTED);
    writer_hurry(*state);
    assert_int_equal(writer_drain(*state, NULL), MNS_OK);
    assert_int_equal(n_done, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(jobs_are_done_in_order, begin, end),
        cmocka_unit_test_setup_teardown(a_failed_job_is_kept_and_done_before_all_behind_it, begin, end),
        cmocka_unit_test_setup_teardown(who_asked_is_told_of_the_first_failure_once, begin, end),
        cmocka_unit_test_setup_teardown(who_waits_behind_a_failure_is_told_too, begin, end),
        cmocka_unit_test_setup_teardown(a_call_passes_a_failed_job_which_stays, begin, end),
        cmocka_unit_test_setup_teardown(a_failed_call_is_not_kept, begin, end),
        cmocka_unit_test_setup_teardown(a_salvage_writes_all_but_what_fails_and_no_row_behind_a_missing_one, begin,
                                        end),
        cmocka_unit_test_setup_teardown(a_salvage_writes_nothing_that_seals_what_is_missing, begin, end),
        cmocka_unit_test_setup_teardown(a_late_job_waits_for_its_moment_and_not_if_hurried, begin, end),
        cmocka_unit_test_setup_teardown(a_late_job_is_discarded_with_the_others, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
