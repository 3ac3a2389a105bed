/* SPDX-License-Identifier: BSD-3-Clause */
/* Figures for whoever watches: whole, of one moment, never older than the ones before, and never waited for. */
#include "run/document.h"
#include "run/figures.h"
#include "tests/support/check.h"
#include "tests/support/dialogue.h"
#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

enum { ROUNDS = 20000 };

/* Figures that all say the same number. */
static RunFigures all_of(uint64_t n)
{
    RunFigures figures = {.steps = n, .stepping = (double)n, .n_timers = n % FIGURES_TIMERS, .sampled_at = (double)n};
    for (size_t k = 0; k < MNS_MAX_PROBES; k++) figures.probes[k] = (double)n;
    return figures;
}

static bool are_whole(const RunFigures *figures)
{
    const double n = (double)figures->steps;
    for (size_t k = 0; k < MNS_MAX_PROBES; k++)
        if (figures->probes[k] != n) return false;
    return figures->stepping == n && figures->sampled_at == n && figures->n_timers == figures->steps % FIGURES_TIMERS;
}

static void the_latest_are_seen_and_stay_until_the_next_look(void **state)
{
    (void)state;
    Figures *figures = figures_new();
    assert_int_equal(figures_look(figures)->steps, 0);
    for (uint64_t n = 1; n <= 5; n++) {
        const RunFigures now = all_of(n);
        figures_put(figures, &now);
    }
    const RunFigures *seen = figures_look(figures);
    assert_int_equal(seen->steps, 5);
    for (uint64_t n = 6; n <= 9; n++) {
        const RunFigures now = all_of(n);
        figures_put(figures, &now);
        assert_int_equal(seen->steps, 5);
    }
    assert_int_equal(figures_look(figures)->steps, 9);
    assert_int_equal(figures_look(figures)->steps, 9);
    figures_free(figures);
}

static void *put_many(void *arg)
{
    for (uint64_t n = 1; n <= ROUNDS; n++) {
        const RunFigures now = all_of(n);
        figures_put(arg, &now);
    }
    return NULL;
}

static void what_is_seen_while_they_change_is_of_one_moment(void **state)
{
    (void)state;
    Figures *figures = figures_new();
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, put_many, figures), 0);
    for (uint64_t last = 0; last < ROUNDS;) {
        const RunFigures *seen = figures_look(figures);
        assert_true(are_whole(seen));
        assert_true(seen->steps >= last);
        last = seen->steps;
    }
    pthread_join(thread, NULL);
    figures_free(figures);
}

static Document *new_document(const char *name)
{
    LoadRequest load;
    Document *document = NULL;
    dialogue_load_init(&load, name, dialogue_case, NULL);
    assert_int_equal(document_new(load.load.case_, name, &document, NULL), MNS_OK);
    dialogue_load_done(&load);
    return document;
}

static void a_case_is_there_as_long_as_it_is_looked_at(void **state)
{
    (void)state;
    Figures *figures = figures_new();
    Document *first = new_document("first"), *second = new_document("second");
    figures_put(figures, &(RunFigures){.document = first});
    const RunFigures *seen = figures_look(figures);
    document_leave(first); /* the run has gone over to another */
    for (int k = 0; k < 3; k++) figures_put(figures, &(RunFigures){.document = second});
    document_leave(second);
    assert_string_equal(seen->document->name, "first");
    assert_string_equal(figures_look(figures)->document->name, "second");
    figures_free(figures); /* with the last shares: the address sanitizer counts */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_latest_are_seen_and_stay_until_the_next_look),
        cmocka_unit_test(what_is_seen_while_they_change_is_of_one_moment),
        cmocka_unit_test(a_case_is_there_as_long_as_it_is_looked_at),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
