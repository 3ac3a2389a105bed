/* SPDX-License-Identifier: BSD-3-Clause */
/* Texts from outside: what is no UTF-8 is told by a sign for it, and all else is left as it is. */
#include "proto/text.h"
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
        {"\xf3\xa0\x81\x81", "\\udb40\\udc41"}, /* a tag */
        {"\xff", FFFD},
    };
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++) assert_string_equal(text_shown(pairs[k][0]), pairs[k][1]);
    assert_string_equal(text_shown(NULL), "");
    const char *first = text_shown("one");
    for (int k = 1; k < TEXT_SHOWN; k++) text_shown("more");
    assert_string_equal(first, "one");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_text_becomes_valid_and_stays_so),
        cmocka_unit_test(a_text_is_shown_without_what_a_terminal_obeys_or_hides),
    };
    return cmocka_run_group_tests_name("text", tests, NULL, NULL);
}
