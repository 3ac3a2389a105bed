/* SPDX-License-Identifier: BSD-3-Clause */
/* A journal as it is printed: what people and programs are told of a lease that came to nothing, and of records that no daemon writes. */
#include "batch/history_print.h"
#include "io/journal.h"
#include "io/names.h"
#include "journal.pb-c.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include <fcntl.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef Meniscus__JournalRecord Record;

static void add(Journal *journal, Record *record)
{
    uint8_t packed[256];
    record->has_kind = true;
    assert_true(meniscus__journal_record__get_packed_size(record) <= sizeof packed);
    const size_t size = meniscus__journal_record__pack(record, packed);
    assert_int_equal(journal_add(journal, packed, size, NULL), MNS_OK);
}

/* A lease that its holder was told of, another one that could not be written down, and the hash of a state. */
static void write_journal(const char *directory)
{
    char *path = path_in(directory, JOURNAL_NAME);
    Journal *journal = NULL;
    Record told = MENISCUS__JOURNAL_RECORD__INIT, undone = MENISCUS__JOURNAL_RECORD__INIT,
           hash = MENISCUS__JOURNAL_RECORD__INIT;
    told.kind = undone.kind = MENISCUS__JOURNAL_RECORD__KIND__LEASE;
    undone.has_undone = undone.undone = true;
    hash.kind = MENISCUS__JOURNAL_RECORD__KIND__HASH;
    assert_int_equal(journal_open(path, &journal, NULL, NULL), MNS_OK);
    add(journal, &told);
    add(journal, &undone);
    add(journal, &hash);
    assert_int_equal(journal_commit(journal, NULL), MNS_OK);
    journal_free(journal);
    free(path);
}

/* What it says on standard output; to be freed. */
static char *printed(const char *directory, bool json)
{
    size_t size;
    char *path = path_in(directory, "said");
    fflush(stdout);
    const int before = dup(STDOUT_FILENO), file = open(path, O_CREAT | O_TRUNC | O_WRONLY, 0600);
    assert_true(before >= 0 && file >= 0);
    dup2(file, STDOUT_FILENO);
    const int code = history_print(directory, false, json);
    fflush(stdout);
    dup2(before, STDOUT_FILENO);
    close(before);
    close(file);
    assert_int_equal(code, 0);
    char *said = (char *)bytes_of(path, &size);
    said = realloc(said, size + 1);
    assert_non_null(said);
    said[size] = 0;
    free(path);
    return said;
}

static void programs_are_told_whether_a_lease_came_to_something(void **state)
{
    write_journal(*state);
    char *said = printed(*state, true);
    json_t *all = json_loads(said, 0, NULL), *records = json_object_get(all, "records");
    assert_int_equal(json_array_size(records), 3);
    assert_true(json_is_false(json_object_get(json_array_get(records, 0), "undone")));
    assert_true(json_is_true(json_object_get(json_array_get(records, 1), "undone")));
    assert_true(json_is_null(json_object_get(json_array_get(records, 2), "undone")));
    json_decref(all);
    free(said);
}

static void people_are_told_only_if_it_came_to_nothing(void **state)
{
    write_journal(*state);
    char *said = printed(*state, false);
    const char *first = strstr(said, "lease: not done, as the journal could not be written\n");
    assert_non_null(first);
    assert_null(strstr(first + 1, "lease"));
    assert_ptr_equal(strstr(said, "lease"), first);
    free(said);
}

/* What was scheduled has changed nothing yet, and is told by what was asked for. */
static void what_is_scheduled_is_told_with_its_moment(void **state)
{
    char *path = path_in(*state, JOURNAL_NAME);
    Journal *journal = NULL;
    Meniscus__Assignment end = MENISCUS__ASSIGNMENT__INIT, *assignments[] = {&end};
    Meniscus__Set set = MENISCUS__SET__INIT;
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Record record = MENISCUS__JOURNAL_RECORD__INIT;
    end.path = (char *)"end_time";
    end.value = (char *)"3";
    set.n_assignments = 1;
    set.assignments = assignments;
    request.command_case = MENISCUS__REQUEST__COMMAND_SET;
    request.set = &set;
    request.has_at_step = true;
    request.at_step = 30;
    record.kind = MENISCUS__JOURNAL_RECORD__KIND__SCHEDULED;
    record.request = &request;
    assert_int_equal(journal_open(path, &journal, NULL, NULL), MNS_OK);
    add(journal, &record);
    assert_int_equal(journal_commit(journal, NULL), MNS_OK);
    journal_free(journal);
    char *people = printed(*state, false), *programs = printed(*state, true);
    assert_non_null(strstr(people, "set end_time = 3: scheduled for step 30\n"));
    json_t *all = json_loads(programs, 0, NULL), *told = json_array_get(json_object_get(all, "records"), 0);
    assert_string_equal(json_string_value(json_object_get(told, "arguments")), "end_time = 3");
    assert_int_equal(json_integer_value(json_object_get(told, "at_step")), 30);
    assert_true(json_is_null(json_object_get(told, "at_time")));
    json_decref(all);
    free(programs);
    free(people);
    free(path);
}

/* With checksums that are right, as a later version or a tool may make them. */
static void records_that_lack_what_they_should_have_are_printed_all_the_same(void **state)
{
    char *path = path_in(*state, JOURNAL_NAME);
    Journal *journal = NULL;
    Record bare = MENISCUS__JOURNAL_RECORD__INIT;
    bare.kind = MENISCUS__JOURNAL_RECORD__KIND__SCHEDULED;
    bare.level = (char *)"\xff";
    assert_int_equal(journal_open(path, &journal, NULL, NULL), MNS_OK);
    add(journal, &bare);
    assert_int_equal(journal_commit(journal, NULL), MNS_OK);
    journal_free(journal);
    char *people = printed(*state, false), *programs = printed(*state, true);
    assert_non_null(strstr(people, "scheduled"));
    json_t *all = json_loads(programs, 0, NULL), *record = json_array_get(json_object_get(all, "records"), 0);
    assert_string_equal(json_string_value(json_object_get(record, "kind")), "scheduled");
    assert_string_equal(json_string_value(json_object_get(record, "level")), "\xef\xbf\xbd");
    json_decref(all);
    free(programs);
    free(people);
    free(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(programs_are_told_whether_a_lease_came_to_something, scratch_begin,
                                        scratch_end),
        cmocka_unit_test_setup_teardown(people_are_told_only_if_it_came_to_nothing, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(what_is_scheduled_is_told_with_its_moment, scratch_begin, scratch_end),
        cmocka_unit_test_setup_teardown(records_that_lack_what_they_should_have_are_printed_all_the_same, scratch_begin,
                                        scratch_end),
    };
    return cmocka_run_group_tests_name("history_print", tests, NULL, NULL);
}
