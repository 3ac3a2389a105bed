/* SPDX-License-Identifier: BSD-3-Clause */
/* The journal: what was committed is there, what a crash tore is cut off, what was changed is found and named. */
#include "io/journal.h"
#include "tests/support/check.h"
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

static char path[] = "/tmp/meniscus-journal-XXXXXX";

static int begin(void **state)
{
    (void)state;
    const int fd = mkstemp(path);
    if (fd >= 0) close(fd);
    return fd < 0 || unlink(path);
}

static int end(void **state)
{
    (void)state;
    unlink(path);
    memcpy(path + sizeof path - 7, "XXXXXX", 6);
    return 0;
}

enum { RECORDS = 3, FRAME = 40, HEAD = 8 };
static const char *const texts[RECORDS] = {"load", "", "gravity = [0, -2]"};

static Journal *opened(JournalReport *report)
{
    Journal *journal = NULL;
    MnsError error;
    assert_int_equal(journal_open(path, &journal, report, &error), MNS_OK);
    return journal;
}

static void write_texts(void)
{
    MnsError error;
    Journal *journal = opened(NULL);
    for (int k = 0; k < RECORDS; k++)
        assert_int_equal(journal_add(journal, texts[k], strlen(texts[k]), &error), MNS_OK);
    assert_true(journal_behind(journal));
    assert_int_equal(journal_commit(journal, &error), MNS_OK);
    assert_false(journal_behind(journal));
    journal_free(journal);
}

static size_t size_of_file(void)
{
    struct stat about;
    assert_int_equal(stat(path, &about), 0);
    return (size_t)about.st_size;
}

static MnsStatus compare(void *arg, uint64_t number, uint64_t offset, const void *data, size_t size, MnsError *error)
{
    (void)error;
    uint64_t *expected = arg;
    const char *text = texts[number - 1];
    assert_int_equal(size, strlen(text));
    assert_memory_equal(data, text, size);
    assert_int_equal(offset, *expected);
    *expected += FRAME + size;
    return MNS_OK;
}

static void what_was_committed_is_read_back_in_order(void **state)
{
    (void)state;
    JournalReport report;
    MnsError error;
    uint64_t offset = HEAD;
    write_texts();
    assert_int_equal(journal_read(path, compare, &offset, &report, &error), MNS_OK);
    assert_int_equal(report.records, RECORDS);
    assert_int_equal(report.size, size_of_file());
    assert_int_equal(report.torn, 0);
}

static void a_journal_goes_on_behind_its_last_record(void **state)
{
    (void)state;
    JournalReport report;
    MnsError error;
    write_texts();
    Journal *journal = opened(&report);
    assert_int_equal(report.records, RECORDS);
    assert_int_equal(journal_reserve(journal, 1000, &error), MNS_OK);
    assert_int_equal(journal_add(journal, "more", 4, &error), MNS_OK);
    assert_int_equal(journal_records(journal), RECORDS + 1);
    assert_int_equal(journal_commit(journal, &error), MNS_OK);
    journal_free(journal);
    assert_int_equal(journal_read(path, NULL, NULL, &report, &error), MNS_OK);
    assert_int_equal(report.records, RECORDS + 1);
    assert_int_equal(report.torn, 0);
}

/* At whatever byte the last write ended: the records before it are there, and the journal goes on. */
static void a_torn_end_is_told_from_damage_and_cut_off(void **state)
{
    (void)state;
    JournalReport report;
    MnsError error;
    write_texts();
    const size_t whole = size_of_file(), last = whole - FRAME - strlen(texts[RECORDS - 1]);
    for (size_t size = last + 1; size < whole; size++) {
        unlink(path);
        write_texts();
        assert_int_equal(truncate(path, (off_t)size), 0);
        assert_int_equal(journal_read(path, NULL, NULL, &report, &error), MNS_OK);
        assert_int_equal(report.records, RECORDS - 1);
        assert_int_equal(report.torn, size - last);
        journal_free(opened(&report));
        assert_int_equal(report.torn, size - last);
        assert_int_equal(size_of_file(), last);
    }
    for (size_t size = 0; size < HEAD; size++) { /* killed while it was made */
        assert_int_equal(truncate(path, 0), 0);
        unlink(path);
        write_texts();
        assert_int_equal(truncate(path, (off_t)size), 0);
        journal_free(opened(&report));
        assert_int_equal(size_of_file(), HEAD);
    }
}

static void room_that_was_never_filled_is_a_torn_end(void **state)
{
    (void)state;
    JournalReport report;
    MnsError error;
    write_texts();
    const size_t whole = size_of_file();
    assert_int_equal(truncate(path, (off_t)whole + 9000), 0);
    assert_int_equal(journal_read(path, NULL, NULL, &report, &error), MNS_OK);
    assert_int_equal(report.records, RECORDS);
    assert_int_equal(report.torn, 9000);
}

static void change(size_t at)
{
    unsigned char byte;
    const int fd = open(path, O_RDWR);
    assert_true(fd >= 0);
    assert_int_equal(pread(fd, &byte, 1, (off_t)at), 1);
    byte ^= 0x10;
    assert_int_equal(pwrite(fd, &byte, 1, (off_t)at), 1);
    close(fd);
}

static void a_changed_byte_anywhere_is_found_and_named(void **state)
{
    (void)state;
    JournalReport report;
    MnsError error;
    write_texts();
    const size_t whole = size_of_file();
    size_t begin_of[RECORDS + 1] = {HEAD};
    for (int k = 0; k < RECORDS; k++) begin_of[k + 1] = begin_of[k] + FRAME + strlen(texts[k]);
    for (size_t at = 0; at < whole; at++) {
        int record = -1; /* the head of the file */
        char sentence[80];
        while (record < RECORDS && at >= begin_of[record + 1]) record++;
        change(at);
        error.text[0] = 0;
        assert_int_equal(journal_read(path, NULL, NULL, &report, &error), MNS_E_CORRUPT);
        if (record >= 0) {
            snprintf(sentence, sizeof sentence, "record %d, which begins at byte %zu,", record + 1, begin_of[record]);
            assert_non_null(strstr(error.text, sentence));
            assert_int_equal(report.records, record);
        }
        Journal *journal = NULL;
        assert_int_equal(journal_open(path, &journal, NULL, &error), MNS_E_CORRUPT);
        assert_null(journal);
        assert_int_equal(size_of_file(), whole);
        change(at);
    }
}

static void a_record_that_was_taken_out_is_missed(void **state)
{
    (void)state;
    JournalReport report;
    MnsError error;
    char bytes[400];
    write_texts();
    const size_t whole = size_of_file(), first = FRAME + strlen(texts[0]);
    const int fd = open(path, O_RDWR);
    assert_int_equal(pread(fd, bytes, sizeof bytes, 0), whole);
    memmove(bytes + HEAD, bytes + HEAD + first, whole - HEAD - first);
    assert_int_equal(pwrite(fd, bytes, whole - first, 0), whole - first);
    assert_int_equal(ftruncate(fd, (off_t)(whole - first)), 0);
    close(fd);
    assert_int_equal(journal_read(path, NULL, NULL, &report, &error), MNS_E_CORRUPT);
    assert_non_null(strstr(error.text, "record 1, "));
}

/* What could not be written is kept, and written when there is room. */
static void a_write_that_fails_is_tried_again(void **state)
{
    (void)state;
    JournalReport report;
    MnsError error;
    struct rlimit before, tight;
    char big[5000];
    memset(big, 'x', sizeof big);
    Journal *journal = opened(NULL);
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before);
    tight = before;
    tight.rlim_cur = 2000;
    setrlimit(RLIMIT_FSIZE, &tight);
    assert_int_equal(journal_add(journal, big, sizeof big, &error), MNS_OK);
    const MnsStatus failed = journal_commit(journal, &error);
    setrlimit(RLIMIT_FSIZE, &before);
    assert_int_equal(failed, MNS_E_NO_SPACE);
    assert_true(journal_behind(journal));
    assert_int_equal(journal_commit(journal, &error), MNS_OK);
    journal_free(journal);
    assert_int_equal(journal_read(path, NULL, NULL, &report, &error), MNS_OK);
    assert_int_equal(report.records, 1);
}

/* Thousands of records that nobody waited for: they are with the system, though the journal never was committed. */
static void what_was_written_outlives_the_program(void **state)
{
    (void)state;
    enum { MANY = 4000, SIZE = 500 };
    JournalReport report;
    MnsError error;
    char data[SIZE] = {0};
    Journal *journal = opened(NULL);
    for (int k = 0; k < MANY; k++) {
        assert_int_equal(journal_add(journal, data, sizeof data, &error), MNS_OK);
        assert_int_equal(journal_write(journal, &error), MNS_OK);
    }
    assert_int_equal(journal_read(path, NULL, NULL, &report, &error), MNS_OK);
    assert_int_equal(report.records, MANY);
    journal_free(journal);
}

static void a_file_that_is_not_there_is_said_so(void **state)
{
    (void)state;
    JournalReport report;
    MnsError error;
    assert_int_equal(journal_read(path, NULL, NULL, &report, &error), MNS_E_NOT_FOUND);
}

/* A machine that stops may leave a file that has its length, and of its last pages none. */
static void pages_that_a_crash_left_empty_are_cut_off(void **state)
{
    (void)state;
    enum { N = 20, SIZE = 1500, PAGE = 4096 };
    char text[SIZE];
    MnsError error;
    Journal *journal = opened(NULL);
    memset(text, 'x', sizeof text);
    for (int k = 0; k < N; k++) assert_int_equal(journal_add(journal, text, sizeof text, &error), MNS_OK);
    assert_int_equal(journal_commit(journal, &error), MNS_OK);
    journal_free(journal);
    const size_t size = size_of_file();
    for (size_t from = size / PAGE * PAGE; from > 0; from -= PAGE) {
        JournalReport report;
        assert_int_equal(truncate(path, (off_t)from), 0);
        assert_int_equal(truncate(path, (off_t)size), 0);
        assert_int_equal(journal_read(path, NULL, NULL, &report, &error), MNS_OK);
        assert_int_equal(report.records, (from - HEAD) / (FRAME + SIZE));
        assert_int_equal(report.torn, size - report.size);
    }
    JournalReport report;
    journal = opened(&report);
    assert_int_equal(report.records, 2);
    journal_free(journal);
    assert_int_equal(size_of_file(), HEAD + 2 * (FRAME + SIZE));
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)
    const struct CMUnitTest tests[] = {
        TEST(what_was_committed_is_read_back_in_order),
        TEST(a_journal_goes_on_behind_its_last_record),
        TEST(a_torn_end_is_told_from_damage_and_cut_off),
        TEST(room_that_was_never_filled_is_a_torn_end),
        TEST(a_changed_byte_anywhere_is_found_and_named),
        TEST(a_record_that_was_taken_out_is_missed),
        TEST(a_write_that_fails_is_tried_again),
        TEST(what_was_written_outlives_the_program),
        TEST(a_file_that_is_not_there_is_said_so),
        cmocka_unit_test_setup_teardown(pages_that_a_crash_left_empty_are_cut_off, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
