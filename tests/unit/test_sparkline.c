/* SPDX-License-Identifier: BSD-3-Clause */
/* A line of blocks shows the newest values, from the least of them to the greatest. */
#include "client/cli/sparkline.h"
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const double untold = -77;

typedef struct Drawn {
    char text[SPARKLINE_TEXT_SIZE];
    double least, greatest;
    size_t n;
} Drawn;

static Drawn draw(const History *history, size_t width, bool has_blocks)
{
    Drawn drawn = {.least = untold, .greatest = untold};
    drawn.n = sparkline(history, width, has_blocks, drawn.text, &drawn.least, &drawn.greatest);
    return drawn;
}

static void each_height_is_a_block_of_its_own(void **state)
{
    (void)state;
    History history = {.n = 0};
    for (int k = 0; k < 8; k++) sparkline_add(&history, 3 - 0.5 * k);
    const Drawn drawn = draw(&history, 20, true);
    assert_string_equal(drawn.text, "█▇▆▅▄▃▂▁");
    assert_int_equal(drawn.n, 8);
    assert_true(drawn.least == -0.5);
    assert_true(drawn.greatest == 3);
    assert_string_equal(draw(&history, 20, false).text, "%#*+=-:.");
}

static void only_the_newest_count(void **state)
{
    (void)state;
    History history = {.n = 0};
    sparkline_add(&history, 1e9);
    for (int k = 0; k < HISTORY_SIZE; k++) sparkline_add(&history, k % 5);
    const Drawn all = draw(&history, 1000, false), few = draw(&history, 3, false);
    assert_int_equal(all.n, HISTORY_SIZE);
    assert_true(all.greatest == 4);
    assert_int_equal(few.n, 3); /* 1, 2, 3 */
    assert_string_equal(few.text, ".+%");
    assert_true(few.least == 1);
}

static void what_is_not_finite_is_a_gap(void **state)
{
    (void)state;
    History history = {.n = 0};
    const double values[] = {-DBL_MAX, NAN, DBL_MAX, INFINITY, 0};
    for (size_t k = 0; k < sizeof values / sizeof *values; k++) sparkline_add(&history, values[k]);
    assert_string_equal(draw(&history, 20, false).text, ". % +");
}

static void nothing_and_what_does_not_change_can_be_drawn(void **state)
{
    (void)state;
    History history = {.n = 0};
    assert_string_equal(draw(&history, 20, true).text, "");
    assert_true(draw(&history, 20, true).least == untold);
    sparkline_add(&history, 4);
    sparkline_add(&history, 4);
    assert_string_equal(draw(&history, 20, true).text, "▄▄");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_height_is_a_block_of_its_own),
        cmocka_unit_test(only_the_newest_count),
        cmocka_unit_test(what_is_not_finite_is_a_gap),
        cmocka_unit_test(nothing_and_what_does_not_change_can_be_drawn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
