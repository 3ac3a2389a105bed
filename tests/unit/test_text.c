/* SPDX-License-Identifier: BSD-3-Clause */
/* Texts from outside: what is no UTF-8 is told by a sign for it, and all else is left as it is. */
#include "common/host/text.h"
#include "tests/support/check.h"
#include <stdlib.h>
#include <string.h>

#define FFFD "\xef\xbf\xbd"

static void a_text_becomes_valid_and_stays_so(void **state)
{
    (void)state;
    static const char *const pairs[][2] = {
        {"", ""},
        {"tank.yaml", "tank.yaml"},
        {"caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8c\x8a\n", "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8c\x8a\n"},
        {"caf\xe9.yaml", "caf" FFFD ".yaml"},
        {"\xe9", FFFD},                            /* begins what does not come */
        {"cut \xe2\x82", "cut " FFFD FFFD},        /* in the middle of a character */
        {"\xc0\xaf", FFFD FFFD},                   /* a slash, longer than it need be */
        {"\xed\xa0\x80", FFFD FFFD FFFD},          /* half a pair of UTF-16 */
        {"\xf4\x90\x80\x80", FFFD FFFD FFFD FFFD}, /* beyond the last */
        {"\xff\xfe", FFFD FFFD},
    };
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++) {
        char *once = text_valid(pairs[k][0]), *twice = text_valid(once);
        assert_string_equal(once, pairs[k][1]);
        assert_string_equal(twice, once);
        free(once);
        free(twice);
    }
}

static void a_text_is_shown_without_what_a_terminal_obeys_or_hides(void **state)
{
    (void)state;
    static const char *const pairs[][2] = {
        {"", ""},
        {"caf\xc3\xa9 \xf0\x9f\x8c\x8a \\n", "caf\xc3\xa9 \xf0\x9f\x8c\x8a \\n"},
        {"a\nb\tc", "a\\nb\\tc"},
        {"\x1b[31m\x7f", "\\u001b[31m\\u007f"},
        {"\xc2\x9b", "\\u009b"},           /* orders of terminals, too */
        {"\xe2\x80\xaetxt", "\\u202etxt"}, /* from right to left; NOLINT(misc-misleading-bidirectional) */
        {"a\xe2\x80\x8b\xef\xbb\xbf", "a\\u200b\\ufeff"},
        {"\xf3\xa0\x81\x81", "\\udb40\\udc41"},                      /* a tag */
        {"a\xe1\xa0\x8b\xe1\xa0\x8f", "a\\u180b\\u180f"},            /* variation selectors: of Mongolian, */
        {"a\xf3\xa0\x84\x80\xef\xb8\x80", "a\\udb40\\udd00\\ufe00"}, /* of all others, */
        {"\xe2\x9d\xa4\xef\xb8\x8f", "\xe2\x9d\xa4\xef\xb8\x8f"},    /* and that of a red heart, which is meant */
        {"\xff", FFFD},
    };
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++) assert_string_equal(text_shown(pairs[k][0]), pairs[k][1]);
    assert_string_equal(text_shown(NULL), "");
    const char *first = text_shown("one");
    for (int k = 1; k < TEXT_SHOWN; k++) text_shown("more");
    assert_string_equal(first, "one");
}

static void a_name_has_nothing_that_is_not_seen(void **state)
{
    (void)state;
    /* NOLINTBEGIN(misc-misleading-bidirectional) */
    static const char *const hidden[] = {"\xcd\x8f",         "\xe1\xa0\x8b",     "\xe1\xa0\x8d",     "\xe1\xa0\x8f",
                                         "\xef\xb8\x80",     "\xef\xb8\x8f",     "\xef\xbe\xa0",     "\xe2\x80\xae",
                                         "\xf3\xa0\x84\x80", "\xf3\xa0\x87\xaf", "\xf0\x9d\x85\xb3", "\x1b"};
    /* NOLINTEND(misc-misleading-bidirectional) */
    for (size_t k = 0; k < sizeof hidden / sizeof *hidden; k++) assert_false(text_is_clean(hidden[k], false));
    assert_true(text_is_clean("caf\xc3\xa9 \xe2\x9d\xa4 \xf0\x9f\x8c\x8a", false));
    assert_int_equal(text_name_check("-rf", "name", NULL), MNS_E_INVALID);
    assert_int_equal(text_name_check("a-b", "name", NULL), MNS_OK);
}

static void a_text_in_pieces_is_cut_between_characters(void **state)
{
    (void)state;
    char out[64];
    assert_int_equal(text_cut("a\xe2\x80", 3), 2);
    assert_int_equal(text_cut("a\xf0\x9f\x8c", 4), 3);
    assert_int_equal(text_cut("\xe2\x82\xac", 3), 0);
    assert_int_equal(text_cut("\x80\x80\x80\x80", 4), 0);
    assert_int_equal(text_cut("", 0), 0);
    out[text_escape("a\n\0\xe2", 4, true, out)] = 0;
    assert_string_equal(out, "a\n\\u0000" FFFD);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_text_becomes_valid_and_stays_so),
        cmocka_unit_test(a_text_is_shown_without_what_a_terminal_obeys_or_hides),
        cmocka_unit_test(a_name_has_nothing_that_is_not_seen),
        cmocka_unit_test(a_text_in_pieces_is_cut_between_characters),
    };
    return cmocka_run_group_tests_name("text", tests, NULL, NULL);
}
