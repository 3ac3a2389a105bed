/* SPDX-License-Identifier: BSD-3-Clause */
/* What the dashboard's gateway knows of what was before a browser came, and how that reaches it. */
#include "client/dashboard/diary.h"
#include "client/dashboard/history.h"
#include "client/dashboard/session.h"
#include "client/dashboard/watcher.h"
#include "common/case/name.h"
#include "tests/support/check.h"
#include <stdio.h>
#include <string.h>

/* --- what happened before ---------------------------------------------------------------------------------------------- */

static void a_line_of_a_log_is_an_event_or_nothing(void **state)
{
    (void)state;
    char line[] = "2026-11-25T23:14:07Z step 584 t 2.43 paused: at breakpoint b: reached\n";
    json_t *event = diary_event(line);
    assert_non_null(event);
    assert_string_equal(json_string_value(json_object_get(event, "what")), "paused");
    assert_string_equal(json_string_value(json_object_get(event, "text")), "at breakpoint b: reached");
    assert_int_equal(json_integer_value(json_object_get(event, "step")), 584);
    assert_close(json_number_value(json_object_get(event, "time")), 2.43, 0);
    json_decref(event);
    static const char *const none[] = {"", "\n", "2026-11-25T23:14:07Z", "step 1 t 2 a: b", "x step 1 t 2 no colon"};
    for (size_t k = 0; k < sizeof none / sizeof *none; k++) {
        char text[64];
        snprintf(text, sizeof text, "%s", none[k]);
        assert_null(diary_event(text));
    }
}

/* --- the past of the probes -------------------------------------------------------------------------------------------- */

static void add(History *history, double t, double value)
{
    history_add(history, t, 1, &(MnsValue){.name = "P1", .unit = "Pa", .number = value});
}

static void a_history_of_any_length_is_bounded_and_keeps_its_peaks(void **state)
{
    (void)state;
    static History history;
    history_init(&history);
    enum { N = 100 * HISTORY_POINTS };
    for (int k = 0; k < N; k++) add(&history, k, k == 12345 ? 1e6 : k == 54321 ? -1e6 : k % 7);
    const Series *series = &history.series[0];
    assert_int_equal(history.n, 1);
    assert_true(series->n <= HISTORY_POINTS && series->n >= HISTORY_POINTS / 4);
    assert_true(series->thinned > 0);
    bool high = false, low = false;
    for (size_t k = 0; k < series->n; k++) {
        if (k) assert_true(series->t[k] > series->t[k - 1]);
        high = high || (series->v[k] == 1e6 && series->t[k] == 12345);
        low = low || (series->v[k] == -1e6 && series->t[k] == 54321);
    }
    assert_true(high && low);
    assert_close(series->t[series->n - 1], N - 1, 0);
    history_clear(&history);
}

/* However long it has been: else the past of a long run would become a straight line. */
static void what_is_kept_lies_evenly_over_the_time(void **state)
{
    (void)state;
    static const int counts[] = {5000, 20000, 50000, 100000, 1000000};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        static History history;
        size_t in[10] = {0};
        history_init(&history);
        for (int k = 0; k < counts[c]; k++) add(&history, 1e-3 * k, sin(0.37 * k));
        const Series *series = &history.series[0];
        for (size_t k = 0; k < series->n; k++) in[(size_t)(series->t[k] / (1e-3 * counts[c]) * 10)]++;
        for (size_t k = 0; k < 9; k++) assert_in_range(in[k], series->n / 12, series->n / 8);
        assert_close(series->t[series->n - 1], 1e-3 * (counts[c] - 1), 1e-9);
        history_clear(&history);
    }
}

static void values_that_are_none_do_not_hide_those_that_are(void **state)
{
    (void)state;
    static History history;
    history_init(&history);
    for (int k = 0; k < HISTORY_POINTS + 1; k++) add(&history, k, k % 4 == 2 ? 5 : (double)NAN);
    const Series *series = &history.series[0];
    size_t found = 0;
    for (size_t k = 0; k < series->n; k++) found += series->v[k] == 5;
    assert_in_range(found, HISTORY_POINTS / 4 - 2, HISTORY_POINTS / 4);
    history_clear(&history);
}

static void a_new_time_line_takes_the_place_of_the_old(void **state)
{
    (void)state;
    static History history;
    history_init(&history);
    for (int k = 0; k < 10; k++) add(&history, k, k);
    add(&history, 3, 100);
    json_t *json = history_json(&history, 0);
    const json_t *probe = json_array_get(json, 0);
    assert_int_equal(json_array_size(json_object_get(probe, "t")), 4);
    assert_close(json_number_value(json_array_get(json_object_get(probe, "v"), 3)), 100, 0);
    assert_string_equal(json_string_value(json_object_get(probe, "unit")), "Pa");
    json_decref(json);
    add(&history, 0, (double)NAN);
    json = history_json(&history, 0);
    assert_true(json_is_null(json_array_get(json_object_get(json_array_get(json, 0), "v"), 0)));
    json_decref(json);
    history_clear(&history);
}

static void names_as_long_as_names_may_be_are_not_mixed_up(void **state)
{
    (void)state;
    static History history;
    char one[CASE_NAME_SIZE], other[CASE_NAME_SIZE];
    memset(one, 'p', sizeof one - 1);
    one[sizeof one - 1] = 0;
    memcpy(other, one, sizeof one);
    other[sizeof other - 2] = 'q';
    history_init(&history);
    for (int k = 0; k < 3; k++)
        history_add(&history, k, 2, (const MnsValue[]){{.name = one, .unit = "Pa"}, {.name = other, .unit = "m"}});
    assert_int_equal(history.n, 2);
    assert_int_equal(history.series[1].n, 3);
    assert_string_equal(history.series[1].name, other);
    history_clear(&history);
}

static void the_past_goes_before_what_was_heard(void **state)
{
    (void)state;
    static History history, past;
    history_init(&history);
    history_init(&past);
    for (int k = 7; k < 10; k++) add(&history, k, k);
    for (int k = 0; k < 2 * HISTORY_POINTS; k++) add(&past, -1 + 4e-3 * k, k == 777 ? 1e6 : -1); /* to 31 */
    history_add(&past, 3, 1, &(MnsValue){.name = "P2", .unit = "m", .number = 4});
    const uint64_t version = history.version;
    history_precede(&history, &past);
    assert_int_not_equal(history.version, version);
    assert_int_equal(past.n, 0);
    assert_int_equal(history.n, 2);
    assert_string_equal(history.series[1].name, "P2");
    const Series *series = &history.series[0];
    assert_true(series->n <= HISTORY_POINTS && series->thinned > 0);
    bool has_peak = false;
    for (size_t k = 0; k < series->n; k++) {
        if (k) assert_true(series->t[k] > series->t[k - 1]);
        has_peak = has_peak || series->v[k] == 1e6;
    }
    assert_true(has_peak);
    for (size_t k = 0; k < 3; k++) assert_close(series->v[series->n - 3 + k], 7 + (double)k, 0);
    assert_true(series->t[series->n - 4] < 7);
    history_clear(&history);
}

/* --- the past on its way ------------------------------------------------------------------------------------------------- */

static void nobody_wakes(void *arg)
{
    (void)arg;
}

/* As many probes as there may be, each with as many points as there may be. */
static Hub *full_of_history(void)
{
    static MnsValue probes[HISTORY_PROBES];
    static char names[HISTORY_PROBES][8];
    static Hub *hub; /* lives as long as the process */
    if (!hub) hub = hub_new("nobody");
    hub_set_wake(hub, nobody_wakes, NULL);
    for (size_t k = 0; k < HISTORY_PROBES; k++) {
        snprintf(names[k], sizeof names[k], "P%zu", k);
        probes[k] = (MnsValue){.name = names[k], .unit = "Pa"};
    }
    for (int i = 0; i < HISTORY_POINTS; i++) {
        for (size_t k = 0; k < HISTORY_PROBES; k++) probes[k].number = -101325.0 / (1 + i);
        hub_sample(hub, 1e-5 / 3 * i, HISTORY_PROBES, probes);
    }
    return hub;
}

static json_t *next_piece(Hub *hub, Session *session)
{
    Text *text;
    Frame *frame;
    session_next(session, &text, &frame);
    if (!text) return NULL;
    assert_true(session->waiting_bytes == 0);
    json_t *piece = json_loadb((const char *)text->bytes + FRAME_HEADROOM, text->size, 0, NULL);
    text_release(text);
    assert_true(hub_recall_more(hub, session));
    assert_true(session->waiting_bytes < SESSION_MOST_BYTES / 32);
    return piece;
}

static bool says(const json_t *piece, const char *entry)
{
    return json_is_true(json_object_get(piece, entry));
}

static void a_history_of_any_size_reaches_a_browser_piece_by_piece(void **state)
{
    (void)state;
    Hub *hub = full_of_history();
    Session session;
    size_t n = 0;
    bool last = false;
    session_init(&session, 1);
    session.welcome = true;
    assert_true(hub_recall(hub, &session));
    for (json_t *piece; (piece = next_piece(hub, &session)); json_decref(piece), n++) {
        const json_t *probe = json_array_get(json_object_get(piece, "probes"), 0);
        char name[8];
        snprintf(name, sizeof name, "P%zu", n);
        assert_string_equal(json_string_value(json_object_get(probe, "name")), name);
        assert_int_equal(json_array_size(json_object_get(probe, "v")), HISTORY_POINTS);
        assert_int_equal(says(piece, "first"), n == 0);
        assert_false(last);
        last = says(piece, "last");
        /* However often it is asked for meanwhile. */
        if (n == 7) assert_true(hub_recall_history(hub, &session) && hub_recall_history(hub, &session));
    }
    assert_true(last);
    assert_int_equal(n, HISTORY_PROBES);
    session_done(&session);
    hub_forget(hub);
}

static void another_run_on_the_way_begins_the_history_again(void **state)
{
    (void)state;
    Hub *hub = full_of_history();
    Session session;
    session_init(&session, 1);
    session.welcome = true;
    assert_true(hub_recall_history(hub, &session));
    for (int k = 0; k < 3; k++) json_decref(next_piece(hub, &session));
    hub_forget(hub);
    hub_sample(hub, 0, 1, &(MnsValue){.name = "other", .unit = "m"});
    json_decref(next_piece(hub, &session)); /* it waited */
    json_t *piece = next_piece(hub, &session);
    assert_true(says(piece, "first") && says(piece, "last"));
    const json_t *probe = json_array_get(json_object_get(piece, "probes"), 0);
    assert_string_equal(json_string_value(json_object_get(probe, "name")), "other");
    json_decref(piece);
    assert_null(next_piece(hub, &session));
    hub_forget(hub);
    session_done(&session);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_history_of_any_length_is_bounded_and_keeps_its_peaks),
        cmocka_unit_test(a_line_of_a_log_is_an_event_or_nothing),
        cmocka_unit_test(what_is_kept_lies_evenly_over_the_time),
        cmocka_unit_test(values_that_are_none_do_not_hide_those_that_are),
        cmocka_unit_test(a_new_time_line_takes_the_place_of_the_old),
        cmocka_unit_test(names_as_long_as_names_may_be_are_not_mixed_up),
        cmocka_unit_test(the_past_goes_before_what_was_heard),
        cmocka_unit_test(a_history_of_any_size_reaches_a_browser_piece_by_piece),
        cmocka_unit_test(another_run_on_the_way_begins_the_history_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
