/* SPDX-License-Identifier: BSD-3-Clause */
/* Lines on standard error: whole, of one line each, and nobody waits for who reads them. */
#include "base/log.h"
#include "tests/support/check.h"
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct Pipe {
    int out, before; /* where it is read; standard error as it was */
} Pipe;

static int begin(void **state)
{
    static Pipe pipe_of;
    int ends[2];
    if (pipe(ends)) return -1;
    pipe_of = (Pipe){.out = ends[0], .before = dup(STDERR_FILENO)};
    dup2(ends[1], STDERR_FILENO);
    close(ends[1]);
    *state = &pipe_of;
    return 0;
}

static int end(void **state)
{
    const Pipe *p = *state;
    dup2(p->before, STDERR_FILENO);
    close(p->before);
    close(p->out);
    return 0;
}

/* What is there now, as a string. */
static size_t take(const Pipe *p, char *text, size_t size)
{
    fcntl(p->out, F_SETFL, O_NONBLOCK);
    size_t n = 0;
    for (ssize_t got; (got = read(p->out, text + n, size - 1 - n)) > 0;) n += (size_t)got;
    text[n] = 0;
    return n;
}

static void no_text_forges_a_line(void **state)
{
    char text[256];
    if (getenv("JOURNAL_STREAM")) skip(); /* lines begin otherwise */
    log_line(LOG_ERROR, "%s", "one\nmeniscusd: two\x7f");
    log_line(LOG_DETAIL, "of too little account");
    take(*state, text, sizeof text);
    assert_string_equal(text, "meniscusd: one meniscusd: two \n");
}

static void nobody_waits_for_a_reader_and_what_is_lost_is_counted(void **state)
{
    enum { LINES = 2000, ROOM = 1 << 20 };
    static char text[ROOM];
    char lost[80];
    unsigned written = 0;
    if (getenv("JOURNAL_STREAM")) skip();
    for (int k = 0; k < LINES; k++) log_line(LOG_ERROR, "%0200d", k); /* the test ends only if none of them waits */
    take(*state, text, sizeof text);
    for (const char *c = text; *c; c++) written += *c == '\n';
    assert_true(written > 10 && written < LINES);
    log_line(LOG_ERROR, "again");
    take(*state, text, sizeof text);
    snprintf(lost, sizeof lost, "meniscusd: %u lines were lost, as nobody read them\nmeniscusd: again\n",
             LINES - written);
    assert_string_equal(text, lost);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(no_text_forges_a_line, begin, end),
        cmocka_unit_test_setup_teardown(nobody_waits_for_a_reader_and_what_is_lost_is_counted, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
