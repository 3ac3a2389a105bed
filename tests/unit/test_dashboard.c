/* SPDX-License-Identifier: BSD-3-Clause */
/* What the dashboard's gateway believes of browsers, what it keeps for them, and what it gives up when they are slow. */
#include "client/dashboard/ask.h"
#include "client/dashboard/diary.h"
#include "client/dashboard/history.h"
#include "client/dashboard/session.h"
#include "client/dashboard/watcher.h"
#include "proto/case_name.h"
#include "proto/guard.h"
#include "tests/support/check.h"
#include "tests/support/memory.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* --- who is let in ----------------------------------------------------------------------------------------------------- */

static void a_host_is_this_machine_by_a_name_that_nobody_else_can_give_it(void **state)
{
    (void)state;
    const Guard guard = {.n = 1, .names = {"node7.example"}};
    static const char *const good[] = {"localhost",     "localhost:9465", "LocalHost:1",
                                       "127.0.0.1",     "10.1.2.3:9465",  "[::1]:9465",
                                       "[2001:db8::7]", "node7.example",  "NODE7.example:80"};
    static const char *const bad[] = {"",
                                      "evil.example",
                                      "localhost.evil.example",
                                      "evil.example:9465",
                                      "127.0.0.1x",
                                      "127.0.0.1.evil.test",
                                      "localhost:",
                                      "localhost:80x",
                                      "[::1",
                                      "[evil.example]:9465",
                                      "[]",
                                      ":9465",
                                      "node7",
                                      "node7.example.evil.t",
                                      "localhost@evil"};
    for (size_t k = 0; k < sizeof good / sizeof *good; k++) assert_true(guard_host(&guard, good[k]));
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) assert_false(guard_host(&guard, bad[k]));
    char longest[2 * GUARD_TEXT];
    memset(longest, 'a', sizeof longest - 1);
    longest[sizeof longest - 1] = 0;
    assert_false(guard_host(&guard, longest));
}

static void only_pages_of_this_origin_may_open_a_socket(void **state)
{
    (void)state;
    assert_true(guard_origin("http://localhost:9465", "localhost:9465"));
    assert_true(guard_origin("https://Node7.example", "node7.example"));
    static const char *const bad[] = {"http://localhost:3000",
                                      "http://localhost",
                                      "http://evil.example",
                                      "null",
                                      "",
                                      "localhost:9465",
                                      "http://localhost:9465.evil.example",
                                      "ftp://localhost:9465",
                                      "http://localhost:9465/"};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) assert_false(guard_origin(bad[k], "localhost:9465"));
}

/* --- what browsers say ------------------------------------------------------------------------------------------------- */

static MnsStatus parse(const char *text, Ask *ret, MnsError *error)
{
    *error = (MnsError){0};
    return ask_parse(text, strlen(text), ret, error);
}

static void commands_are_read_with_their_entries(void **state)
{
    (void)state;
    Ask ask;
    MnsError error;
    assert_int_equal(parse("{\"do\":\"step\",\"id\":7,\"count\":10,\"lease\":1795390000}", &ask, &error), MNS_OK);
    assert_int_equal(ask.kind, ASK_STEP);
    assert_int_equal(ask.id, 7);
    assert_int_equal(ask.count, 10);
    assert_int_equal(ask.lease, 1795390000);
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"set\",\"id\":1,\"settings\":[\"gravity=[0, -2]\",\"end_time=3\"]}", &ask, &error),
                     MNS_OK);
    assert_int_equal(ask.n_settings, 2);
    assert_string_equal(ask.settings[1], "end_time=3");
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"show\",\"field\":\"pressure\",\"limit\":5,\"walls\":true}", &ask, &error),
                     MNS_OK);
    assert_string_equal(ask.field, "pressure");
    assert_true(ask.walls);
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"run_until\",\"id\":2,\"time\":1}", &ask, &error), MNS_OK);
    assert_close(ask.time, 1, 0);
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"snapshot\",\"id\":3,\"at_step\":0}", &ask, &error), MNS_OK);
    assert_true(ask.at_a_step && !ask.at_a_time);
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"pause\",\"id\":3}", &ask, &error), MNS_OK);
    assert_false(ask.at_a_step || ask.at_a_time);
    ask_done(&ask);
}

static void every_entry_is_asked_for_and_read_by_its_own_name(void **state)
{
    (void)state;
    Ask ask;
    MnsError error;
    assert_int_equal(parse("{\"do\":\"step\",\"id\":1,\"lease\":2,\"count\":3}", &ask, &error), MNS_OK);
    assert_true(ask.id == 1 && ask.lease == 2 && ask.count == 3);
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"show\",\"field\":\"phase\",\"limit\":4,\"walls\":true}", &ask, &error), MNS_OK);
    assert_true(ask.limit == 4 && ask.walls && !strcmp(ask.field, "phase"));
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"rollback\",\"id\":1,\"version\":5}", &ask, &error), MNS_OK);
    assert_true(ask.version == 5);
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"run_until\",\"id\":1,\"time\":6}", &ask, &error), MNS_OK);
    assert_close(ask.time, 6, 0);
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"lease\",\"id\":1,\"seconds\":7,\"holder\":\"me\"}", &ask, &error), MNS_OK);
    assert_close(ask.seconds, 7, 0);
    assert_string_equal(ask.holder, "me");
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"stop\",\"id\":1,\"checkpoint\":true}", &ask, &error), MNS_OK);
    assert_true(ask.checkpoint && !ask.start && !ask.walls);
    ask_done(&ask);
    assert_int_equal(
        parse("{\"do\":\"load\",\"id\":1,\"name\":\"dam\",\"start\":true,\"settings\":[\"a=b\"]}", &ask, &error),
        MNS_OK);
    assert_true(ask.start && !ask.checkpoint && !strcmp(ask.name, "dam") && ask.n_settings == 1);
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"hello\",\"token\":\"abc\"}", &ask, &error), MNS_OK);
    assert_string_equal(ask.token, "abc");
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"pause\",\"id\":1,\"at_step\":8,\"at_time\":9}", &ask, &error), MNS_OK);
    assert_true(ask.at_step == 8 && ask.at_a_step && ask.at_a_time);
    assert_close(ask.at_time, 9, 0);
    ask_done(&ask);
    assert_int_equal(parse("{\"do\":\"cancel\",\"id\":1,\"request\":\"00\"}", &ask, &error), MNS_OK);
    assert_string_equal(ask.request, "00");
    ask_done(&ask);
}

static void what_a_message_lacks_is_named(void **state)
{
    (void)state;
    Ask ask;
    MnsError error;
    static const struct {
        const char *text, *path;
    } missing[] = {{"{\"do\":\"step\",\"id\":1}", "count"},
                   {"{\"do\":\"rollback\",\"id\":1}", "version"},
                   {"{\"do\":\"lease\",\"id\":1,\"seconds\":7}", "holder"},
                   {"{\"do\":\"lease\",\"id\":1,\"holder\":\"me\"}", "seconds"},
                   {"{\"do\":\"release\",\"id\":1}", "lease"},
                   {"{\"do\":\"cancel\",\"id\":1}", "request"},
                   {"{\"do\":\"show\",\"field\":\"phase\"}", "limit"},
                   {"{\"do\":\"show\",\"limit\":1}", "field"},
                   {"{\"do\":\"load\",\"id\":1}", "name"},
                   {"{\"do\":\"set\",\"id\":1}", "settings"}};
    for (size_t k = 0; k < sizeof missing / sizeof *missing; k++) {
        assert_int_equal(parse(missing[k].text, &ask, &error), MNS_E_INVALID);
        assert_string_equal(error.path, missing[k].path);
    }
}

static void nothing_that_browsers_say_is_believed(void **state)
{
    (void)state;
    static const struct {
        const char *text, *path;
    } bad[] = {
        {"", ""},
        {"hello", ""},
        {"{", ""},
        {"[]", "do"},
        {"{}", "do"},
        {"{\"do\":7}", "do"},
        {"{\"do\":\"shutdown\",\"id\":1}", "do"},
        {"{\"do\":\"start\"}", "id"},
        {"{\"do\":\"start\",\"id\":-1}", "id"},
        {"{\"do\":\"start\",\"id\":1.5}", "id"},
        {"{\"do\":\"start\",\"id\":\"1\"}", "id"},
        {"{\"do\":\"start\",\"id\":1,\"count\":1}", "count"},
        {"{\"do\":\"start\",\"id\":1,\"__proto__\":{}}", "__proto__"},
        {"{\"do\":\"step\",\"id\":1}", "count"},
        {"{\"do\":\"run_until\",\"id\":1,\"time\":\"1\"}", "time"},
        {"{\"do\":\"run_until\",\"id\":1,\"time\":null}", "time"},
        {"{\"do\":\"stop\",\"id\":1,\"checkpoint\":1}", "checkpoint"},
        {"{\"do\":\"set\",\"id\":1,\"settings\":[]}", "settings"},
        {"{\"do\":\"set\",\"id\":1,\"settings\":[7]}", "settings"},
        {"{\"do\":\"set\",\"id\":1,\"settings\":\"a=b\"}", "settings"},
        {"{\"do\":\"load\",\"id\":1,\"name\":7}", "name"},
        {"{\"do\":\"start\",\"do\":\"stop\",\"id\":1}", ""},
        {"{\"do\":\"hello\",\"token\":\"a\\u0000b\"}", ""},
    };
    Ask ask;
    MnsError error;
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        assert_int_equal(parse(bad[k].text, &ask, &error), MNS_E_INVALID);
        assert_string_equal(error.path, bad[k].path);
        assert_null(ask.json);
    }
    assert_int_equal(ask_parse("{\"do\":\"\xff\"}", 11, &ask, &error), MNS_E_INVALID);
    char *longest = malloc(ASK_BYTES + 1);
    memset(longest, ' ', ASK_BYTES + 1);
    memcpy(longest, "{\"do\":\"hello\"}", 14);
    assert_int_equal(ask_parse(longest, ASK_BYTES, &ask, &error), MNS_OK);
    ask_done(&ask);
    assert_int_equal(ask_parse(longest, ASK_BYTES + 1, &ask, &error), MNS_E_INVALID);
    memset(longest, '[', ASK_BYTES);
    assert_int_equal(ask_parse(longest, ASK_BYTES, &ask, &error), MNS_E_INVALID);
    free(longest);
}

static void a_refusal_goes_back_under_the_id_that_was_said(void **state)
{
    (void)state;
    Ask ask;
    MnsError error;
    assert_int_equal(parse("{\"do\":\"start\",\"id\":41,\"x\":1}", &ask, &error), MNS_E_INVALID);
    assert_int_equal(ask.id, 41);
}

static void too_many_settings_are_refused(void **state)
{
    (void)state;
    Ask ask;
    MnsError error;
    char text[1024] = "{\"do\":\"set\",\"id\":1,\"settings\":[\"a=1\"";
    for (size_t k = 1; k < ASK_WORDS; k++) strcat(text, ",\"a=1\"");
    const size_t n = strlen(text);
    strcpy(text + n, "]}");
    assert_int_equal(parse(text, &ask, &error), MNS_OK);
    ask_done(&ask);
    strcpy(text + n, ",\"a=1\"]}");
    assert_int_equal(parse(text, &ask, &error), MNS_E_INVALID);
}

/* A browser names cases, not files. */
static void other_files_than_cases_cannot_be_loaded(void **state)
{
    (void)state;
    static const char *const names[] = {"/etc/passwd", "../secret", "a.yaml", "~", "a b", "A"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        MnsError error = {0};
        const Ask ask = {.kind = ASK_LOAD, .name = names[k]};
        MnsReply *reply = NULL;
        /* It is refused before the daemon is asked. */
        assert_int_equal(ask_call(&ask, NULL, &reply, &error), MNS_E_INVALID);
        assert_string_equal(error.path, "name");
    }
}

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

/* --- what waits for a browser ------------------------------------------------------------------------------------------ */

static const double places[] = {0, 1, 2, 3, 4, 5}, values[] = {3, 4, 0, 0, -5, 12};
static const uint8_t phases[] = {0, 1, 2};

static Frame *picture(const Wish *wish, uint64_t step)
{
    const MnsArray arrays[] = {
        {.name = "position", .type = "<f8", .unit = "m", .n_dims = 2, .shape = {3, 2}, .data = places},
        {.name = "velocity", .type = "<f8", .unit = "m/s", .n_dims = 2, .shape = {3, 2}, .data = values},
        {.name = "phase", .type = "|u1", .unit = "1", .n_dims = 1, .shape = {3}, .data = phases},
    };
    const MnsReply reply = {.step = step, .time = 0.5, .n_arrays = 3, .arrays = arrays};
    Frame *frame;
    assert_int_equal(frame_new(wish, (FrameKey){1, step}, 2, 6, &reply, &frame, NULL), MNS_OK);
    frame->users = 1;
    return frame;
}

static float float_at(const unsigned char *bytes)
{
    float value;
    memcpy(&value, bytes, sizeof value);
    return value;
}

static void a_picture_is_laid_out_as_the_manual_says(void **state)
{
    (void)state;
    const Wish wish = {.field = "velocity", .limit = 3};
    Frame *frame = picture(&wish, 41);
    frame_set_skipped(frame, 258);
    const unsigned char *bytes = frame->bytes + FRAME_HEADROOM;
    const size_t length = bytes[0] + 256u * bytes[1];
    assert_int_equal(length % 4, 0);
    assert_int_equal(bytes[4] + 256 * bytes[5], 258);
    json_t *header = json_loadb((const char *)bytes + 8, length, 0, NULL);
    assert_int_equal(json_integer_value(json_object_get(header, "step")), 41);
    assert_int_equal(json_integer_value(json_object_get(header, "particles")), 3);
    assert_int_equal(json_integer_value(json_object_get(header, "all")), 6);
    assert_int_equal(json_integer_value(json_object_get(header, "dimensions")), 2);
    assert_true(json_is_true(json_object_get(header, "magnitude")));
    json_decref(header);
    const unsigned char *data = bytes + 8 + length;
    for (size_t k = 0; k < 6; k++) assert_close(float_at(data + 4 * k), places[k], 0);
    assert_close(float_at(data + 24), 5, 0);
    assert_close(float_at(data + 32), 13, 0);
    assert_memory_equal(data + 36, phases, 3);
    assert_int_equal(frame->size, 8 + length + 39);
    frame_release(frame);
}

static void an_answer_without_what_was_asked_is_no_picture(void **state)
{
    (void)state;
    const MnsArray place = {
        .name = "position", .type = "<f8", .unit = "m", .n_dims = 2, .shape = {3, 2}, .data = places};
    const MnsReply reply = {.n_arrays = 1, .arrays = &place}, nothing = {0};
    Frame *frame;
    assert_int_equal(frame_new(&(Wish){.field = "phase"}, (FrameKey){0}, 1, 3, &reply, &frame, NULL), MNS_E_CORRUPT);
    assert_int_equal(frame_new(&(Wish){.field = "phase"}, (FrameKey){0}, 1, 3, &nothing, &frame, NULL), MNS_E_CORRUPT);
}

static void numbers_of_a_type_that_fields_have_not_are_no_picture(void **state)
{
    (void)state;
    static const char *const good[] = {"<f8", "<u4", "|u1"}, *const bad[] = {"<f4", "<u8", "<i4", "|i1", ">f8", ""};
    MnsArray arrays[] = {{.name = "position", .type = "<f8", .unit = "m", .n_dims = 2, .shape = {3, 2}, .data = places},
                         {.name = "phase", .type = "|u1", .unit = "", .n_dims = 1, .shape = {3}, .data = phases},
                         {.name = "pressure", .type = "<f8", .unit = "Pa", .n_dims = 1, .shape = {3}, .data = places}};
    const MnsReply reply = {.n_arrays = 3, .arrays = arrays};
    const Wish wish = {.field = "pressure"};
    for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
        Frame *frame = NULL;
        arrays[2].type = good[k];
        assert_int_equal(frame_new(&wish, (FrameKey){0}, 1, 3, &reply, &frame, NULL), MNS_OK);
        frame_free(frame);
    }
    arrays[2].type = "<f8";
    for (size_t a = 0; a < 3; a++) {
        const char *was = arrays[a].type;
        for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
            Frame *frame = NULL;
            MnsError error = {0};
            arrays[a].type = bad[k];
            assert_int_equal(frame_new(&wish, (FrameKey){0}, 1, 3, &reply, &frame, &error), MNS_E_CORRUPT);
            assert_string_equal(error.path, arrays[a].name);
        }
        arrays[a].type = was;
    }
}

static void one_in_so_many_that_about_the_limit_is_left(void **state)
{
    (void)state;
    assert_int_equal(frame_every(100, 100), 1);
    assert_int_equal(frame_every(149, 100), 1);
    assert_int_equal(frame_every(150, 100), 2);
    assert_int_equal(frame_every(1200000, 100000), 12);
    assert_int_equal(frame_every(0, 100), 1);
}

static Session watching(const Wish *wish)
{
    Session session;
    session_init(&session, 1);
    session.welcome = session.shows = true;
    session.wish = *wish;
    return session;
}

static void only_the_newest_picture_waits_and_the_others_are_counted(void **state)
{
    (void)state;
    const Wish wish = {.field = "velocity", .limit = 3}, other = {.field = "velocity", .limit = 4};
    Session session = watching(&wish);
    Text *text;
    Frame *frame, *frames[4], *foreign = picture(&other, 9);
    session_offer(&session, foreign);
    assert_false(session_has_next(&session));
    for (uint64_t k = 0; k < 4; k++) session_offer(&session, frames[k] = picture(&wish, k));
    session_next(&session, &text, &frame);
    assert_null(text);
    assert_ptr_equal(frame, frames[3]);
    assert_int_equal(session.skipped, 3);
    assert_int_equal(frame->bytes[FRAME_HEADROOM + 4], 3);
    frame_release(frame);
    /* It has seen this one. */
    session_offer(&session, frames[3]);
    assert_false(session_has_next(&session));
    for (size_t k = 0; k < 4; k++) frame_release(frames[k]);
    frame_release(foreign);
    session_done(&session);
}

static void a_browser_that_does_not_draw_gets_no_more(void **state)
{
    (void)state;
    const Wish wish = {.field = "velocity", .limit = 3};
    Session session = watching(&wish);
    Text *text;
    Frame *frame;
    for (uint64_t k = 0; k < SESSION_AHEAD + 1; k++) {
        Frame *next = picture(&wish, k);
        session_offer(&session, next);
        frame_release(next);
        session_next(&session, &text, &frame);
        assert_int_equal(frame != NULL, k < SESSION_AHEAD);
        if (frame) frame_release(frame);
    }
    assert_false(session_has_room(&session));
    session_drawn(&session, 1);
    session_next(&session, &text, &frame);
    assert_non_null(frame);
    frame_release(frame);
    /* However much it says it has drawn. */
    session_drawn(&session, UINT64_MAX);
    assert_int_equal(session.ahead, 0);
    session_done(&session);
}

static Text *text_of(size_t size, bool lossy)
{
    char *words = malloc(size + 1);
    memset(words, 'x', size);
    words[size] = 0;
    Text *text = text_new(words, lossy);
    free(words);
    text->users = 1;
    return text;
}

static void what_waits_for_a_slow_browser_is_bounded(void **state)
{
    (void)state;
    Session session;
    session_init(&session, 1);
    Text *sample = text_of(1 << 20, true), *news = text_of(1 << 20, false), *got;
    Frame *frame;
    for (int k = 0; k < 10; k++) assert_true(session_send(&session, sample));
    assert_int_equal(session.waiting_bytes, SESSION_LOSSY_BYTES);
    assert_int_equal(session.lost, 6);
    for (int k = 0; k < 12; k++) assert_true(session_send(&session, news));
    assert_int_equal(session.waiting_bytes, SESSION_MOST_BYTES);
    assert_false(session_send(&session, news));
    while (session_has_next(&session)) {
        session_next(&session, &got, &frame);
        text_release(got);
    }
    assert_int_equal(session.waiting_bytes, 0);
    /* When there is room again it is told how many were lost. */
    assert_true(session_send(&session, sample));
    session_next(&session, &got, &frame);
    const char lost[] = "{\"topic\":\"lost\",\"messages\":6}";
    assert_memory_equal(got->bytes + FRAME_HEADROOM, lost, sizeof lost - 1);
    text_release(got);
    text_release(news);
    session_done(&session);
    assert_int_equal(sample->users, 1);
    text_release(sample);
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

/* --- commands ----------------------------------------------------------------------------------------------------------- */

static void why_a_command_cannot_begin_is_told(void **state)
{
    (void)state;
    static Hub *hub; /* lives as long as the process */
    MnsError error;
    hub = hub_new("nobody");
    if (memory_can_fail) {
        memory_is_gone(true);
        const MnsStatus status = worker_start(hub, 1, &(Ask){.kind = ASK_PAUSE}, &error);
        memory_is_gone(false);
        assert_int_equal(status, MNS_E_MEMORY);
        assert_non_null(strstr(error.text, "no memory"));
    }
    for (int k = 0; k < HUB_COMMANDS; k++) assert_true(hub_begin_command(hub)); /* what failed gave its place back */
    assert_int_equal(worker_start(hub, 1, &(Ask){.kind = ASK_PAUSE}, &error), MNS_E_LIMIT);
    assert_non_null(strstr(error.text, "16 commands are under way"));
}

/* What one browser is answered, when it comes. */
static json_t *answer_of(Hub *hub)
{
    Text *text = NULL;
    uint64_t browser;
    for (int k = 0; k < 2000 && !(text = hub_take_text(hub, &browser)); k++)
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
    assert_non_null(text);
    json_t *answer = json_loadb((const char *)text->bytes + FRAME_HEADROOM, text->size, 0, NULL);
    text->users++;
    text_release(text);
    assert_non_null(answer);
    return answer;
}

static void the_journal_of_another_machine_is_not_looked_for_on_this_one(void **state)
{
    (void)state;
    static Hub *hub; /* lives as long as the process */
    hub = hub_new("tcp://192.0.2.7:5555");
    hub_set_wake(hub, nobody_wakes, NULL);
    hub_set_directory(hub, "/tmp"); /* which is here too */
    assert_int_equal(worker_start(hub, 1, &(Ask){.kind = ASK_JOURNAL, .id = 7}, NULL), MNS_OK);
    json_t *answer = answer_of(hub);
    const char *message = json_string_value(json_object_get(json_object_get(answer, "error"), "message"));
    assert_non_null(message);
    assert_non_null(strstr(message, "the machine of the daemon"));
    assert_non_null(strstr(message, "meniscus log /tmp"));
    json_decref(answer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_host_is_this_machine_by_a_name_that_nobody_else_can_give_it),
        cmocka_unit_test(only_pages_of_this_origin_may_open_a_socket),
        cmocka_unit_test(commands_are_read_with_their_entries),
        cmocka_unit_test(every_entry_is_asked_for_and_read_by_its_own_name),
        cmocka_unit_test(what_a_message_lacks_is_named),
        cmocka_unit_test(nothing_that_browsers_say_is_believed),
        cmocka_unit_test(a_refusal_goes_back_under_the_id_that_was_said),
        cmocka_unit_test(too_many_settings_are_refused),
        cmocka_unit_test(other_files_than_cases_cannot_be_loaded),
        cmocka_unit_test(a_history_of_any_length_is_bounded_and_keeps_its_peaks),
        cmocka_unit_test(a_line_of_a_log_is_an_event_or_nothing),
        cmocka_unit_test(what_is_kept_lies_evenly_over_the_time),
        cmocka_unit_test(values_that_are_none_do_not_hide_those_that_are),
        cmocka_unit_test(a_new_time_line_takes_the_place_of_the_old),
        cmocka_unit_test(names_as_long_as_names_may_be_are_not_mixed_up),
        cmocka_unit_test(the_past_goes_before_what_was_heard),
        cmocka_unit_test(a_picture_is_laid_out_as_the_manual_says),
        cmocka_unit_test(an_answer_without_what_was_asked_is_no_picture),
        cmocka_unit_test(numbers_of_a_type_that_fields_have_not_are_no_picture),
        cmocka_unit_test(one_in_so_many_that_about_the_limit_is_left),
        cmocka_unit_test(only_the_newest_picture_waits_and_the_others_are_counted),
        cmocka_unit_test(a_browser_that_does_not_draw_gets_no_more),
        cmocka_unit_test(what_waits_for_a_slow_browser_is_bounded),
        cmocka_unit_test(a_history_of_any_size_reaches_a_browser_piece_by_piece),
        cmocka_unit_test(another_run_on_the_way_begins_the_history_again),
        cmocka_unit_test(why_a_command_cannot_begin_is_told),
        cmocka_unit_test(the_journal_of_another_machine_is_not_looked_for_on_this_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
