/* SPDX-License-Identifier: BSD-3-Clause */
/* What the dashboard's gateway believes of browsers: who is let in, and what they say. */
#include "client/dashboard/ask.h"
#include "common/wire/guard.h"
#include "tests/support/check.h"
#include <stdlib.h>
#include <string.h>

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
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
