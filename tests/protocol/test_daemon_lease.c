/* SPDX-License-Identifier: BSD-3-Clause */
/* One writer at a time, versions of the case, and both after a crash. */
#include "batch/replay.h"
#include "io/journal.h"
#include "io/names.h"
#include "journal.pb-c.h"
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <meniscus/exit.h>
#include <stdio.h>
#include <string.h>

static Meniscus__Request lease(Meniscus__Lease *message, uint64_t ttl_ms, const char *holder)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    meniscus__lease__init(message);
    message->has_ttl_ms = ttl_ms > 0;
    message->ttl_ms = ttl_ms;
    message->holder = (char *)holder;
    request.command_case = MENISCUS__REQUEST__COMMAND_LEASE;
    request.lease = message;
    return request;
}

/* The epoch that is given, under that of an older one or 0. */
static uint64_t take(Dialogue *dialogue, uint64_t ttl_ms, uint64_t under)
{
    Meniscus__Lease message;
    Meniscus__Request request = lease(&message, ttl_ms, "anna");
    request.has_lease_epoch = under > 0;
    request.lease_epoch = under;
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_string_equal(reply->lease->holder, "anna");
    const uint64_t epoch = reply->lease->epoch;
    meniscus__reply__free_unpacked(reply, NULL);
    return epoch;
}

static void give_back(Dialogue *dialogue, uint64_t epoch)
{
    Meniscus__Lease message;
    Meniscus__Request request = lease(&message, 0, NULL);
    message.has_release = message.release = request.has_lease_epoch = true;
    request.lease_epoch = epoch;
    steer_accepted(dialogue_ask(dialogue, &request));
}

/* Set end_time under a lease, or none, at a version, or any. */
static Meniscus__Reply *set_end(Dialogue *dialogue, const char *value, uint64_t epoch, uint64_t version)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    request.has_lease_epoch = epoch > 0;
    request.lease_epoch = epoch;
    request.has_if_version = version > 0;
    request.if_version = version;
    return steer_set_under(dialogue, &request, "end_time", value);
}

static Meniscus__Reply *rollback(Dialogue *dialogue, uint64_t version)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Rollback message = MENISCUS__ROLLBACK__INIT;
    message.has_version = true;
    message.version = version;
    request.command_case = MENISCUS__REQUEST__COMMAND_ROLLBACK;
    request.rollback = &message;
    return dialogue_ask(dialogue, &request);
}

static uint64_t version_of(Meniscus__Reply *reply)
{
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_true(reply->has_case_version);
    const uint64_t version = reply->case_version;
    meniscus__reply__free_unpacked(reply, NULL);
    return version;
}

static void refused_as(Meniscus__Reply *reply, Meniscus__Code code, const char *reason, const char *path)
{
    assert_int_equal(reply->code, code);
    assert_string_equal(reply->reason, reason);
    assert_string_equal(reply->path, path);
    meniscus__reply__free_unpacked(reply, NULL);
}

/* --- leases ------------------------------------------------------------------------------------------------------------ */

static void only_the_holder_changes_the_run(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    const uint64_t epoch = take(dialogue, 60000, 0);
    refused_as(set_end(dialogue, "3", 0, 0), MENISCUS__CODE__FAILED_PRECONDITION, "held", "lease_epoch");
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__FAILED_PRECONDITION);
    assert_int_equal(steer_code(dialogue, dialogue_reset()), MENISCUS__CODE__FAILED_PRECONDITION);
    steer_accepted(set_end(dialogue, "3", epoch, 0));
    assert_true(steer_get(dialogue, "end_time") == 3);
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_string_equal(reply->status->lease_holder, "anna");
    assert_true(reply->status->lease_s > 50 && reply->status->lease_s <= 60);
    meniscus__reply__free_unpacked(reply, NULL);
    give_back(dialogue, epoch);
    steer_accepted(set_end(dialogue, "4", 0, 0));
    refused_as(set_end(dialogue, "5", epoch, 0), MENISCUS__CODE__ABORTED, "expired", "lease_epoch");
    Meniscus__Request none = MENISCUS__REQUEST__INIT; /* says a lease, and is none */
    none.has_lease_epoch = true;
    refused_as(steer_set_under(dialogue, &none, "end_time", "5"), MENISCUS__CODE__INVALID_ARGUMENT, "invalid",
               "lease_epoch");
    assert_true(take(dialogue, 60000, 0) > epoch);
}

/* What must always be possible, and what changes nothing. */
static void a_pause_a_stop_and_looking_need_no_lease(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, (const char *[]){"end_time=100", NULL});
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    take(dialogue, 60000, 0);
    assert_int_equal(steer_code(dialogue, dialogue_pause()), MENISCUS__CODE__OK);
    assert_int_equal(steer_code(dialogue, dialogue_resume()), MENISCUS__CODE__FAILED_PRECONDITION);
    assert_int_equal(steer_code(dialogue, dialogue_checkpoint()), MENISCUS__CODE__OK);
    assert_int_equal(steer_code(dialogue, dialogue_stop()), MENISCUS__CODE__OK);
}

static void a_lease_ends_by_itself_unless_it_is_renewed(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    const uint64_t epoch = take(dialogue, 2000, 0);
    assert_int_equal(take(dialogue, 6000, epoch), epoch);
    steer_sleep(2100);
    refused_as(set_end(dialogue, "3", 0, 0), MENISCUS__CODE__FAILED_PRECONDITION, "held", "lease_epoch");
    steer_sleep(4000);
    refused_as(set_end(dialogue, "3", epoch, 0), MENISCUS__CODE__ABORTED, "expired", "lease_epoch");
    steer_accepted(set_end(dialogue, "3", 0, 0));
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_null(reply->status->lease_holder);
    meniscus__reply__free_unpacked(reply, NULL);
}

static void a_lease_out_of_bounds_is_refused(void **state)
{
    static const uint64_t times[] = {0, 99, 86400001};
    Dialogue *dialogue = *state;
    Meniscus__Lease message;
    for (size_t k = 0; k < 3; k++) {
        Meniscus__Request request = lease(&message, times[k], "anna");
        refused_as(dialogue_ask(dialogue, &request), MENISCUS__CODE__INVALID_ARGUMENT, "invalid", "ttl_ms");
    }
    Meniscus__Request request = lease(&message, 1000, "");
    refused_as(dialogue_ask(dialogue, &request), MENISCUS__CODE__INVALID_ARGUMENT, "invalid", "holder");
}

static void a_lease_outlives_a_crash(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    const uint64_t epoch = take(dialogue, 60000, 0);
    dialogue_crash(dialogue);
    steer_wait_for(dialogue, MENISCUS__STATE__READY);
    refused_as(set_end(dialogue, "3", 0, 0), MENISCUS__CODE__FAILED_PRECONDITION, "held", "lease_epoch");
    steer_accepted(set_end(dialogue, "3", epoch, 0));
    give_back(dialogue, epoch);
    assert_true(take(dialogue, 60000, 0) > epoch);
}

/* The journal of the run that is loaded knows of it, and when it has ended before that, too. */
static void a_lease_from_before_the_load_outlives_a_crash(void **state)
{
    Dialogue *dialogue = *state;
    const uint64_t epoch = take(dialogue, 60000, 0);
    LoadRequest load;
    dialogue_load_init(&load, "dam", dialogue_case, NULL);
    load.request.has_lease_epoch = true;
    load.request.lease_epoch = epoch;
    assert_int_equal(dialogue_code(dialogue, &load.request), MENISCUS__CODE__OK);
    dialogue_crash(dialogue);
    steer_wait_for(dialogue, MENISCUS__STATE__READY);
    refused_as(set_end(dialogue, "3", 0, 0), MENISCUS__CODE__FAILED_PRECONDITION, "held", "lease_epoch");
    steer_accepted(set_end(dialogue, "3", epoch, 0));
    assert_int_equal(steer_code(dialogue, dialogue_stop()), MENISCUS__CODE__OK);
    give_back(dialogue, epoch);
    load.load.has_resume = load.load.resume = true;
    load.request.has_lease_epoch = false;
    assert_int_equal(dialogue_code(dialogue, &load.request), MENISCUS__CODE__OK);
    dialogue_load_done(&load);
    dialogue_crash(dialogue);
    steer_wait_for(dialogue, MENISCUS__STATE__READY);
    steer_accepted(set_end(dialogue, "4", 0, 0));
    assert_true(take(dialogue, 60000, 0) > epoch);
}

/* As a daemon did that settled a lease after the end of the run: of no step. */
static void tell_behind_the_end(const char *directory)
{
    char path[4096];
    uint8_t packed[64];
    Journal *journal;
    Meniscus__JournalRecord record = MENISCUS__JOURNAL_RECORD__INIT;
    record.has_kind = record.has_wall_us = record.has_step = true;
    record.kind = MENISCUS__JOURNAL_RECORD__KIND__LEASE;
    snprintf(path, sizeof path, "%s/" JOURNAL_NAME, directory);
    assert_int_equal(journal_open(path, &journal, NULL, NULL), MNS_OK);
    const size_t size = meniscus__journal_record__pack(&record, packed);
    assert_int_equal(journal_add(journal, packed, size, NULL), MNS_OK);
    assert_int_equal(journal_commit(journal, NULL), MNS_OK);
    journal_free(journal);
}

static void a_replay_passes_over_whoever_was_told_behind_the_end(void **state)
{
    Dialogue *dialogue = *state;
    char here[256];
    LoadRequest load;
    steer_load_here(dialogue, NULL, here);
    steer_go(dialogue, 3);
    assert_int_equal(steer_code(dialogue, dialogue_checkpoint()), MENISCUS__CODE__OK);
    assert_int_equal(steer_code(dialogue, dialogue_stop()), MENISCUS__CODE__OK);
    tell_behind_the_end(here);
    assert_int_equal(replay_run(here, -1, false), MNS_EXIT_DONE);
    dialogue_load_init(&load, "dam", dialogue_case, NULL);
    load.load.has_resume = load.load.resume = true;
    assert_int_equal(dialogue_code(dialogue, &load.request), MENISCUS__CODE__OK);
    dialogue_load_done(&load);
    steer_go(dialogue, 2);
    assert_int_equal(steer_code(dialogue, dialogue_stop()), MENISCUS__CODE__OK);
    assert_int_equal(replay_run(here, -1, false), MNS_EXIT_DONE);
}

/* --- versions ---------------------------------------------------------------------------------------------------------- */

static void each_change_is_a_version_that_can_be_gone_back_to(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, (const char *[]){"end_time=2", NULL});
    assert_int_equal(version_of(set_end(dialogue, "3", 0, 0)), 2);
    assert_int_equal(version_of(set_end(dialogue, "4", 0, 0)), 3);
    assert_int_equal(version_of(rollback(dialogue, 1)), 4);
    assert_true(steer_get(dialogue, "end_time") == 2);
    assert_int_equal(version_of(rollback(dialogue, 3)), 5);
    assert_true(steer_get(dialogue, "end_time") == 4);
    refused_as(rollback(dialogue, 6), MENISCUS__CODE__NOT_FOUND, "not found", "version");
    refused_as(rollback(dialogue, 0), MENISCUS__CODE__NOT_FOUND, "not found", "version");
    assert_int_equal(steer_code(dialogue, dialogue_reset()), MENISCUS__CODE__OK);
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_int_equal(reply->status->case_version, 6);
    meniscus__reply__free_unpacked(reply, NULL);
    refused_as(rollback(dialogue, 5), MENISCUS__CODE__NOT_FOUND, "not found", "version");
}

static void a_change_can_be_for_one_version_only(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, (const char *[]){"end_time=2", NULL});
    assert_int_equal(version_of(set_end(dialogue, "3", 0, 1)), 2);
    refused_as(set_end(dialogue, "4", 0, 1), MENISCUS__CODE__FAILED_PRECONDITION, "wrong state", "if_version");
    assert_true(steer_get(dialogue, "end_time") == 3);
    Meniscus__Request status = dialogue_status();
    status.has_if_version = true;
    status.if_version = 2;
    refused_as(dialogue_ask(dialogue, &status), MENISCUS__CODE__INVALID_ARGUMENT, "invalid", "if_version");
}

static void going_back_must_not_end_the_run_in_the_past(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, (const char *[]){"end_time=0.01", NULL});
    steer_accepted(set_end(dialogue, "5", 0, 0));
    steer_accepted(steer_until(dialogue, 0.05));
    refused_as(rollback(dialogue, 1), MENISCUS__CODE__INVALID_ARGUMENT, "invalid", "end_time");
    assert_true(steer_get(dialogue, "end_time") == 5);
}

/* Also from before the checkpoint that it comes back to, and after a second crash. */
static void versions_are_found_again_after_a_crash(void **state)
{
    Dialogue *dialogue = *state;
    char path[256];
    dialogue_load(dialogue, (const char *[]){"end_time=2", NULL});
    steer_accepted(set_end(dialogue, "3", 0, 0));
    steer_go(dialogue, 3);
    steer_write_checkpoint(dialogue, path);
    steer_accepted(set_end(dialogue, "4", 0, 0));
    assert_int_equal(version_of(rollback(dialogue, 2)), 4);
    steer_go(dialogue, 2);
    for (int k = 0; k < 2; k++) {
        dialogue_crash(dialogue);
        steer_wait_for(dialogue, MENISCUS__STATE__PAUSED);
        assert_true(steer_get(dialogue, "end_time") == 3);
        Meniscus__Reply *reply = steer_status(dialogue);
        assert_int_equal(reply->status->case_version, 4);
        meniscus__reply__free_unpacked(reply, NULL);
    }
    assert_int_equal(version_of(rollback(dialogue, 3)), 5);
    assert_true(steer_get(dialogue, "end_time") == 4);
    assert_int_equal(version_of(rollback(dialogue, 1)), 6);
    assert_true(steer_get(dialogue, "end_time") == 2);
}

/* What was set before the first that is kept is in all of them. */
static void of_very_many_versions_the_last_are_found_again_after_a_crash(void **state)
{
    enum { N = 300, KEPT = 256 };
    Dialogue *dialogue = *state;
    char text[16];
    dialogue_load(dialogue, NULL);
    steer_accepted(steer_set(dialogue, "scheme.cfl", "0.125"));
    for (int k = 3; k <= N; k++) {
        snprintf(text, sizeof text, "%d", 1000 + k);
        assert_int_equal(version_of(set_end(dialogue, text, 0, 0)), k);
    }
    dialogue_crash(dialogue);
    steer_wait_for(dialogue, MENISCUS__STATE__READY);
    refused_as(rollback(dialogue, N - KEPT), MENISCUS__CODE__NOT_FOUND, "not found", "version");
    assert_int_equal(version_of(rollback(dialogue, N - KEPT + 1)), N + 1);
    assert_true(steer_get(dialogue, "end_time") == 1000 + N - KEPT + 1);
    assert_true(steer_get(dialogue, "scheme.cfl") == 0.125);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, steer_begin, steer_end)
    const struct CMUnitTest tests[] = {
        TEST(only_the_holder_changes_the_run),
        TEST(a_pause_a_stop_and_looking_need_no_lease),
        TEST(a_lease_ends_by_itself_unless_it_is_renewed),
        TEST(a_lease_out_of_bounds_is_refused),
        TEST(a_lease_outlives_a_crash),
        TEST(a_lease_from_before_the_load_outlives_a_crash),
        TEST(a_replay_passes_over_whoever_was_told_behind_the_end),
        TEST(each_change_is_a_version_that_can_be_gone_back_to),
        TEST(a_change_can_be_for_one_version_only),
        TEST(going_back_must_not_end_the_run_in_the_past),
        TEST(versions_are_found_again_after_a_crash),
        TEST(of_very_many_versions_the_last_are_found_again_after_a_crash),
    };
    return cmocka_run_group_tests_name("daemon_lease", tests, NULL, NULL);
}
