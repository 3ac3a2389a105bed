/* SPDX-License-Identifier: BSD-3-Clause */
/* What a journal says of where a run was, also when one crash follows another. */
#include "common/case/name.h"
#include "run/lineage.h"
#include "run/order.h"
#include "tests/support/check.h"
#include <math.h>
#include <stdlib.h>

typedef Meniscus__JournalRecord Record;

enum { RECORDS = 16 };

/* Records as they are written, and what they point to. */
typedef struct Book {
    History history;
    HistoryRecord list[RECORDS];
    Record records[RECORDS];
    Meniscus__Request requests[RECORDS];
    Meniscus__Reply replies[RECORDS];
    Meniscus__Load loads[RECORDS];
    Meniscus__Set sets[RECORDS];
    Meniscus__Step steps[RECORDS];
    Meniscus__Again again;
    Meniscus__Again *all_again[1];
    Meniscus__Case given, stored;
    Meniscus__Who who; /* of the first load */
    Lineage lineage;
} Book;

static int begin(void **state)
{
    Book *book = calloc(1, sizeof *book);
    if (!book) return 1;
    meniscus__case__init(&book->given);
    meniscus__case__init(&book->stored);
    book->history.records = book->list;
    *state = book;
    return 0;
}

static int end(void **state)
{
    Book *book = *state;
    lineage_done(&book->lineage);
    free(book);
    return 0;
}

/* One more record of a command that ended well at this step, in this state. */
static Record *add(Book *book, Meniscus__Request__CommandCase command, uint64_t step, Meniscus__State state)
{
    const size_t k = book->history.n++;
    Record *record = &book->records[k];
    meniscus__journal_record__init(record);
    meniscus__request__init(&book->requests[k]);
    meniscus__reply__init(&book->replies[k]);
    meniscus__load__init(&book->loads[k]);
    meniscus__set__init(&book->sets[k]);
    meniscus__step__init(&book->steps[k]);
    book->list[k] = (HistoryRecord){.number = k + 1, .message = record};
    record->kind = MENISCUS__JOURNAL_RECORD__KIND__COMMAND;
    record->step = step;
    record->request = &book->requests[k];
    record->reply = &book->replies[k];
    record->reply->state = state;
    record->request->command_case = command;
    if (command == MENISCUS__REQUEST__COMMAND_LOAD) record->request->load = &book->loads[k];
    if (command == MENISCUS__REQUEST__COMMAND_SET) record->request->set = &book->sets[k];
    if (command == MENISCUS__REQUEST__COMMAND_STEP) record->request->step = &book->steps[k];
    return record;
}

static void add_load(Book *book)
{
    Record *record = add(book, MENISCUS__REQUEST__COMMAND_LOAD, 0, MENISCUS__STATE__READY);
    record->request->load->name = "dam";
    record->case_ = &book->given;
    record->who = &book->who;
    meniscus__who__init(&book->who);
    book->who.name = WHO_DAEMON;
}

/* The load of a daemon after a crash: from a checkpoint of this step. */
static Record *add_comeback(Book *book, uint64_t step)
{
    Record *record = add(book, MENISCUS__REQUEST__COMMAND_LOAD, step, MENISCUS__STATE__RECOVERING);
    record->request->load->name = "dam";
    record->request->load->has_resume = record->request->load->resume = true;
    record->case_ = &book->stored;
    record->has_comeback = record->comeback = true;
    return record;
}

static Record *add_begun(Book *book, uint64_t step)
{
    Record *record = add(book, MENISCUS__REQUEST__COMMAND_STEP, step, MENISCUS__STATE__RUNNING);
    record->kind = MENISCUS__JOURNAL_RECORD__KIND__BEGUN;
    record->reply = NULL;
    return record;
}

static Lineage *read(Book *book, MnsStatus status)
{
    lineage_done(&book->lineage);
    assert_int_equal(lineage_of(&book->history, "this", &book->lineage, NULL), status);
    return &book->lineage;
}

static void a_run_that_the_daemon_loaded_and_no_more_is_untouched(void **state)
{
    Book *book = *state;
    add_load(book);
    const Lineage *lineage = read(book, MNS_OK);
    assert_true(lineage->untouched);
    assert_int_equal(lineage->state, RUN_READY);
    assert_ptr_equal(lineage->original, &book->given);
    assert_string_equal(lineage->name, "dam");
    book->who.name = "connection 1";
    assert_false(read(book, MNS_OK)->untouched);
    book->who.name = WHO_DAEMON;
    add(book, MENISCUS__REQUEST__COMMAND_SET, 0, MENISCUS__STATE__READY);
    assert_false(read(book, MNS_OK)->untouched);
}

static void a_run_is_where_its_last_command_left_it(void **state)
{
    Book *book = *state;
    add_load(book);
    add_begun(book, 0);
    add(book, MENISCUS__REQUEST__COMMAND_STEP, 30, MENISCUS__STATE__PAUSED);
    const Lineage *lineage = read(book, MNS_OK);
    assert_int_equal(lineage->state, RUN_PAUSED);
    assert_int_equal(lineage->step, 30);
    assert_null(lineage->begun);
}

static void a_second_crash_on_the_way_back_leaves_it_there(void **state)
{
    Book *book = *state;
    add_load(book);
    add_begun(book, 0);
    add(book, MENISCUS__REQUEST__COMMAND_STEP, 30, MENISCUS__STATE__PAUSED);
    Record *set = add(book, MENISCUS__REQUEST__COMMAND_SET, 30, MENISCUS__STATE__PAUSED);
    Record *comeback = add_comeback(book, 20);
    book->all_again[0] = &book->again;
    meniscus__again__init(&book->again);
    book->again.step = 30;
    book->again.request = set->request;
    comeback->n_again = 1;
    comeback->again = book->all_again;
    const Lineage *lineage = read(book, MNS_OK);
    assert_int_equal(lineage->state, RUN_PAUSED); /* not READY, as the load by itself would leave it */
    assert_int_equal(lineage->step, 30);
    assert_ptr_equal(lineage->entries[lineage->n - 1].request, set->request);
    assert_int_equal(lineage->entries[lineage->n - 1].step, 30);
    assert_ptr_equal(lineage->original, &book->given); /* and a reset leads to the case as it was loaded */
}

static void a_reset_leads_to_the_case_as_given_also_after_a_way_back_to_the_beginning(void **state)
{
    Book *book = *state;
    add_load(book);
    add(book, MENISCUS__REQUEST__COMMAND_SET, 0, MENISCUS__STATE__READY);
    add_comeback(book, 0); /* the checkpoint of the beginning, with what was set there */
    const Lineage *lineage = read(book, MNS_OK);
    assert_ptr_equal(lineage->original, &book->given);
    assert_int_equal(lineage->state, RUN_READY);
}

static void a_step_under_way_stays_so_through_two_crashes(void **state)
{
    Book *book = *state;
    add_load(book);
    const Record *begun = add_begun(book, 7);
    add_comeback(book, 5);
    const Lineage *lineage = read(book, MNS_OK);
    assert_ptr_equal(lineage->begun, begun->request);
    assert_int_equal(lineage->begun_step, 7);
    assert_int_equal(lineage->step, 7);
    assert_int_equal(lineage->state, RUN_RUNNING);
}

/* The run may have a checkpoint from beyond the step at which it set out. */
static void a_step_that_sets_out_again_after_a_crash_counts_from_where_it_began(void **state)
{
    Book *book = *state;
    uint8_t ids[2][ORDER_ID] = {"first", "second"};
    add_load(book);
    for (int k = 0; k < 2; k++) {
        const Record *begun = add_begun(book, k ? 9 : 7);
        begun->request->has_id = true;
        begun->request->id = (ProtobufCBinaryData){.len = ORDER_ID, .data = ids[0]};
        add_comeback(book, k ? 12 : 9);
    }
    assert_int_equal(read(book, MNS_OK)->begun_step, 7);
    book->requests[3].id.data = ids[1];
    assert_int_equal(read(book, MNS_OK)->begun_step, 9);
}

static void what_was_under_way_and_is_called_off_before_the_run_is_back_leaves_it_paused(void **state)
{
    Book *book = *state;
    add_load(book);
    add_begun(book, 7);
    add_comeback(book, 5);
    add(book, MENISCUS__REQUEST__COMMAND_STEP, 7, MENISCUS__STATE__RECOVERING)->reply->code = MENISCUS__CODE__ABORTED;
    const Lineage *lineage = read(book, MNS_OK);
    assert_null(lineage->begun);
    assert_int_equal(lineage->state, RUN_PAUSED);
    assert_int_equal(lineage->step, 7);
}

static void a_shutdown_ends_a_run_but_not_on_its_way_back(void **state)
{
    Book *book = *state;
    add_load(book);
    add_begun(book, 0);
    add(book, MENISCUS__REQUEST__COMMAND_STEP, 30, MENISCUS__STATE__PAUSED);
    add_comeback(book, 20);
    Record *shutdown = add(book, MENISCUS__REQUEST__COMMAND_SHUTDOWN, 24, MENISCUS__STATE__STOPPING);
    shutdown->has_comeback = shutdown->comeback = true;
    const Lineage *lineage = read(book, MNS_OK);
    assert_int_equal(lineage->step, 30);
    assert_int_equal(lineage->state, RUN_PAUSED);
    shutdown->has_comeback = shutdown->comeback = false;
    read(book, MNS_E_STATE);
}

/* A set that waits for a time, accepted at this step, under an id of its own. */
static Record *add_scheduled(Book *book, uint64_t step, double t, uint8_t *id)
{
    Record *record = add(book, MENISCUS__REQUEST__COMMAND_SET, step, MENISCUS__STATE__RUNNING);
    record->kind = MENISCUS__JOURNAL_RECORD__KIND__SCHEDULED;
    record->reply = NULL;
    record->request->has_at_time = true;
    record->request->at_time = t;
    record->request->id = (ProtobufCBinaryData){.len = ORDER_ID, .data = id};
    return record;
}

/* What came of it. */
static Record *add_outcome(Book *book, const Record *scheduled, uint64_t step, Meniscus__Code code)
{
    Record *record = add(book, MENISCUS__REQUEST__COMMAND_SET, step, MENISCUS__STATE__RUNNING);
    record->request = scheduled->request;
    record->reply->code = code;
    return record;
}

static size_t count_pending(const Lineage *lineage)
{
    size_t n = 0;
    for (size_t k = 0; k < lineage->n; k++)
        n += lineage->entries[k].scheduled && lineage->entries[k].until == UINT64_MAX;
    return n;
}

static void what_is_scheduled_waits_until_a_record_tells_what_came_of_it(void **state)
{
    Book *book = *state;
    uint8_t ids[2][ORDER_ID] = {"first", "second"};
    add_load(book);
    add(book, MENISCUS__REQUEST__COMMAND_START, 0, MENISCUS__STATE__RUNNING);
    const Record *first = add_scheduled(book, 10, 0.3, ids[0]), *second = add_scheduled(book, 10, 0.5, ids[1]);
    const Lineage *lineage = read(book, MNS_OK);
    assert_int_equal(count_pending(lineage), 2);
    assert_int_equal(lineage->state, RUN_RUNNING);
    assert_true(isinf(lineage_limit(lineage, 9, 0)));
    assert_true(lineage_limit(lineage, 10, 0) == 0.3);
    assert_true(lineage_limit(lineage, 10, 0.3) == 0.5); /* what is past shortens nothing */
    add_outcome(book, first, 30, MENISCUS__CODE__OK);
    lineage = read(book, MNS_OK);
    assert_int_equal(count_pending(lineage), 1);
    assert_true(lineage_limit(lineage, 29, 0) == 0.3);
    assert_true(lineage_limit(lineage, 30, 0) == 0.5);
    assert_ptr_equal(lineage->entries[lineage->n - 1].request, first->request); /* and it is done again */
    add_outcome(book, second, 40, MENISCUS__CODE__ABORTED);
    lineage = read(book, MNS_OK);
    assert_int_equal(count_pending(lineage), 0);
    assert_int_equal(lineage->step, 40); /* its time has shortened a step there all the same */
    assert_true(isinf(lineage_limit(lineage, 40, 0)));
    assert_false(lineage->entries[lineage->n - 1].request == second->request &&
                 !lineage->entries[lineage->n - 1].scheduled); /* and it is not */
}

static void what_is_scheduled_outlives_two_crashes_but_no_restore(void **state)
{
    Book *book = *state;
    uint8_t id[ORDER_ID] = "one";
    add_load(book);
    const Record *scheduled = add_scheduled(book, 10, 0.5, id);
    add(book, MENISCUS__REQUEST__COMMAND_SET, 40, MENISCUS__STATE__PAUSED);
    Record *comeback = add_comeback(book, 20);
    meniscus__again__init(&book->again);
    book->all_again[0] = &book->again;
    book->again.step = 20;
    book->again.request = scheduled->request;
    book->again.has_scheduled = book->again.scheduled = true;
    comeback->n_again = 1;
    comeback->again = book->all_again;
    const Lineage *lineage = read(book, MNS_OK);
    assert_int_equal(count_pending(lineage), 1);
    assert_true(lineage_limit(lineage, 10, 0) == 0.5);
    assert_true(lineage_limit(lineage, 20, 0) == 0.5);
    Record *restore = add(book, MENISCUS__REQUEST__COMMAND_RESTORE, 15, MENISCUS__STATE__READY);
    restore->case_ = &book->stored;
    lineage = read(book, MNS_OK);
    assert_int_equal(count_pending(lineage), 0);
    assert_true(lineage_limit(lineage, 14, 0) == 0.5); /* the steps before were shortened by it all the same */
    assert_true(isinf(lineage_limit(lineage, 15, 0)));
}

/* The clock of the wall may have been put back, or have been wrong when it was given. */
static void a_lease_lives_by_the_wall_clock_but_no_longer_than_it_was_given_for(void **state)
{
    Book *book = *state;
    Meniscus__Lease lease = MENISCUS__LEASE__INIT;
    Meniscus__LeaseGrant grant = MENISCUS__LEASE_GRANT__INIT;
    add_load(book);
    Record *record = add(book, MENISCUS__REQUEST__COMMAND_LEASE, 0, MENISCUS__STATE__READY);
    record->request->lease = &lease;
    record->reply->result_case = MENISCUS__REPLY__RESULT_LEASE;
    record->reply->lease = &grant;
    record->wall_us = 1000000000;
    grant.epoch = 7;
    grant.ttl_ms = 30000;
    const Lineage *lineage = read(book, MNS_OK);
    assert_int_equal(lineage->lease.epoch, 7);
    assert_float_equal(lineage_lease_left(lineage, 1010), 20, 1e-9);
    assert_float_equal(lineage_lease_left(lineage, 1031), -1, 1e-9);
    assert_float_equal(lineage_lease_left(lineage, 10), 30, 1e-9);
}

typedef struct Given {
    Meniscus__Lease lease;
    Meniscus__LeaseGrant grant;
} Given;

/* A lease that was given or renewed, since this start of the machine. */
static Record *add_lease(Book *book, Given *given, uint64_t epoch)
{
    Record *record = add(book, MENISCUS__REQUEST__COMMAND_LEASE, 0, MENISCUS__STATE__READY);
    *given = (Given){MENISCUS__LEASE__INIT, MENISCUS__LEASE_GRANT__INIT};
    record->request->lease = &given->lease;
    record->reply->result_case = MENISCUS__REPLY__RESULT_LEASE;
    record->reply->lease = &given->grant;
    record->has_boot = true;
    record->boot = (ProtobufCBinaryData){4, (uint8_t *)"this"};
    given->grant.epoch = epoch;
    given->grant.ttl_ms = 30000;
    return record;
}

static void add_told(Book *book, bool undone)
{
    Record *record = add(book, MENISCUS__REQUEST__COMMAND__NOT_SET, 0, MENISCUS__STATE__READY);
    record->kind = MENISCUS__JOURNAL_RECORD__KIND__LEASE;
    record->request = NULL;
    record->reply = NULL;
    record->undone = undone;
}

/* The daemon was killed while the record was on its way to the disk, or could not get it there. */
static void a_lease_that_nobody_was_told_of_is_none(void **state)
{
    Book *book = *state;
    Given given[4];
    add_load(book);
    add_lease(book, &given[0], 7);
    assert_int_equal(read(book, MNS_OK)->lease.epoch, 0);
    add_told(book, false);
    assert_int_equal(read(book, MNS_OK)->lease.epoch, 7);
    add_lease(book, &given[1], 8);
    assert_int_equal(read(book, MNS_OK)->lease.epoch, 7);
    add_told(book, false);
    add_told(book, true);
    assert_int_equal(read(book, MNS_OK)->lease.epoch, 7);
    Record *release = add_lease(book, &given[2], 7);
    release->reply->result_case = MENISCUS__REPLY__RESULT__NOT_SET;
    release->reply->lease = NULL;
    given[2].lease.release = true;
    assert_true(read(book, MNS_OK)->lease.until_us > 0);
    add_lease(book, &given[3], 9);
    add_told(book, false); /* of both */
    assert_int_equal(read(book, MNS_OK)->lease.epoch, 9);
    assert_false(history_untold(&book->history, 5, "this") || history_untold(&book->history, 0, "this"));
    assert_true(history_untold(&book->history, 3, "this"));
}

/* That somebody was told need not have got to the disk. */
static void a_lease_is_kept_when_the_machine_itself_has_failed_or_it_is_of_an_older_daemon(void **state)
{
    Book *book = *state;
    Given given;
    add_load(book);
    Record *record = add_lease(book, &given, 7);
    record->boot.data = (uint8_t *)"past";
    assert_int_equal(read(book, MNS_OK)->lease.epoch, 7);
    record->has_boot = false;
    assert_int_equal(read(book, MNS_OK)->lease.epoch, 7);
}

/* Whether somebody was told is judged where the daemon comes back first: what happens to the machine later says nothing of it, nor do those who are
 * told of another lease. */
static void a_lease_that_was_none_once_stays_none(void **state)
{
    Book *book = *state;
    Given given[2];
    add_load(book);
    add_lease(book, &given[0], 7);
    Record *back = add_comeback(book, 0);
    back->has_boot = true;
    back->boot = (ProtobufCBinaryData){4, (uint8_t *)"this"};
    add_lease(book, &given[1], 8);
    add_told(book, false);
    read(book, MNS_OK);
    assert_true(history_untold(&book->history, 1, "next"));
    assert_true(history_untold(&book->history, 1, "this"));
    assert_false(history_untold(&book->history, 3, "this") || history_untold(&book->history, 2, "this"));
    back->boot.data = (uint8_t *)"next";
    assert_false(history_untold(&book->history, 1, "next"));
}

/* All results of a reply are in one place: of another kind, or of a later version, none of it is a lease. */
static void a_lease_whose_reply_has_another_result_is_none(void **state)
{
    Book *book = *state;
    Given given;
    Meniscus__WaitResult other = MENISCUS__WAIT_RESULT__INIT;
    add_load(book);
    Record *record = add_lease(book, &given, 7);
    record->reply->result_case = MENISCUS__REPLY__RESULT_WAIT;
    record->reply->wait = &other;
    add_told(book, false);
    assert_int_equal(read(book, MNS_OK)->lease.epoch, 0);
}

static void a_load_without_a_name_is_of_the_case_that_it_was_called_then(void **state)
{
    Book *book = *state;
    add_load(book);
    book->loads[0].name = NULL;
    assert_string_equal(read(book, MNS_OK)->name, CASE_NAMELESS);
}

/* No daemon writes it, and none may be led astray by it. */
static void what_is_scheduled_without_a_request_waits_for_nothing(void **state)
{
    Book *book = *state;
    add_load(book);
    Record *back = add_comeback(book, 0);
    meniscus__again__init(&book->again);
    book->again.scheduled = true;
    book->all_again[0] = &book->again;
    back->again = book->all_again;
    back->n_again = 1;
    const Lineage *lineage = read(book, MNS_OK);
    for (size_t k = 0; k < lineage->n; k++) assert_false(lineage->entries[k].scheduled);
}

/* A record comes when the file is written: the run has gone on since, and something may have been scheduled. */
static void a_snapshot_is_made_again_where_it_was_made(void **state)
{
    Book *book = *state;
    uint8_t id[ORDER_ID] = {7};
    Meniscus__SnapshotNow snapshot = MENISCUS__SNAPSHOT_NOW__INIT;
    add_load(book);
    add(book, MENISCUS__REQUEST__COMMAND_SET, 10, MENISCUS__STATE__RUNNING);
    add_scheduled(book, 30, 5, id);
    Record *record = add(book, MENISCUS__REQUEST__COMMAND_SNAPSHOT, 40, MENISCUS__STATE__RUNNING);
    record->request->snapshot = &snapshot;
    record->reply->has_effect_step = true;
    record->reply->effect_step = 20;
    const Lineage *lineage = read(book, MNS_OK);
    assert_int_equal(lineage->n, 3);
    for (size_t k = 1; k < lineage->n; k++) assert_true(lineage->entries[k - 1].step <= lineage->entries[k].step);
    assert_ptr_equal(lineage->entries[1].request, record->request);
    assert_int_equal(lineage->n_waiting, 1);
    assert_true(lineage->entries[lineage->waiting[0]].scheduled);
    assert_true(lineage_needs(lineage, 1, 0) && lineage_needs(lineage, 1, 20));
    assert_false(lineage_needs(lineage, 1, 21)); /* it is there, whatever becomes of the checkpoint */
    record->has_broken = record->broken = true;
    assert_int_equal(read(book, MNS_OK)->n, 2);
    record->has_broken = record->broken = false;
    record->reply->code = MENISCUS__CODE__RESOURCE_EXHAUSTED;
    assert_int_equal(read(book, MNS_OK)->n, 2);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_run_that_the_daemon_loaded_and_no_more_is_untouched),
        TEST(a_run_is_where_its_last_command_left_it),
        TEST(a_second_crash_on_the_way_back_leaves_it_there),
        TEST(a_reset_leads_to_the_case_as_given_also_after_a_way_back_to_the_beginning),
        TEST(a_step_under_way_stays_so_through_two_crashes),
        TEST(a_step_that_sets_out_again_after_a_crash_counts_from_where_it_began),
        TEST(what_was_under_way_and_is_called_off_before_the_run_is_back_leaves_it_paused),
        TEST(a_shutdown_ends_a_run_but_not_on_its_way_back),
        TEST(what_is_scheduled_waits_until_a_record_tells_what_came_of_it),
        TEST(what_is_scheduled_outlives_two_crashes_but_no_restore),
        TEST(a_lease_lives_by_the_wall_clock_but_no_longer_than_it_was_given_for),
        TEST(a_lease_that_was_none_once_stays_none),
        TEST(a_lease_that_nobody_was_told_of_is_none),
        TEST(a_lease_is_kept_when_the_machine_itself_has_failed_or_it_is_of_an_older_daemon),
        TEST(a_lease_whose_reply_has_another_result_is_none),
        TEST(what_is_scheduled_without_a_request_waits_for_nothing),
        TEST(a_snapshot_is_made_again_where_it_was_made),
        TEST(a_load_without_a_name_is_of_the_case_that_it_was_called_then),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
