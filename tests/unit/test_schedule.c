/* SPDX-License-Identifier: BSD-3-Clause */
/* When outputs are due. */
#include "run/schedule.h"
#include "tests/support/check.h"
#include <math.h>

/* How often something of an interval is due in n steps of dt. */
static int count(double interval, double dt, int n)
{
    int due = schedule_due(interval, -INFINITY, 0);
    for (int k = 1; k <= n; k++) due += schedule_due(interval, (k - 1) * dt, k * dt);
    return due;
}

static void an_interval_of_zero_is_never_due(void **state)
{
    (void)state;
    assert_int_equal(count(0, 0.1, 100), 0);
}

static void the_beginning_counts(void **state)
{
    (void)state;
    assert_true(schedule_due(5, -INFINITY, 0));
    assert_false(schedule_due(5, 0, 0.1));
}

static void each_multiple_is_met_once_whatever_the_step(void **state)
{
    (void)state;
    assert_int_equal(count(0.1, 0.01, 1000), 101);
    assert_int_equal(count(0.1, 0.03, 1000), 301);
    assert_int_equal(count(0.1, 1. / 128, 1280), 101);
}

static void a_step_over_several_multiples_is_due_once(void **state)
{
    (void)state;
    assert_int_equal(count(0.1, 0.35, 10), 11);
}

static void a_boundary_at_the_very_multiple_is_due_there(void **state)
{
    (void)state;
    for (int k = 1; k < 2000; k++) {
        const double t = k * 0.1;
        assert_true(schedule_due(0.1, t - 1e-3, t));
        assert_false(schedule_due(0.1, t, t + 1e-3));
    }
}

/* A run to 0.3 s with a file each 0.1 s has one of its end. */
static void a_multiple_as_people_write_it_is_met(void **state)
{
    (void)state;
    static const struct {
        double interval, t;
    } rows[] = {{0.1, 0.3}, {0.1, 0.6}, {0.1, 0.7}, {0.2, 0.6}, {0.001, 0.009}, {0.07, 0.21}, {1e-5, 0.3}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const double t = rows[k].t;
        assert_true(schedule_due(rows[k].interval, t * 0.9999999, t));
        assert_false(schedule_due(rows[k].interval, t, t * 1.0000001));
        assert_false(schedule_due(rows[k].interval, t * 0.9999998, t * 0.9999999));
    }
}

static void absurd_intervals_end(void **state)
{
    (void)state;
    assert_true(schedule_due(1e-300, 1, 2));
    assert_false(schedule_due(1e300, 1, 2));
}

static void what_takes_long_to_write_is_written_seldom(void **state)
{
    (void)state;
    assert_true(schedule_flush(0, false) == 10);
    assert_true(schedule_flush(0.4, false) == 10);
    assert_close(schedule_flush(3, false), 60, 1e-9);
    assert_true(schedule_flush(0.01, true) == 1);
    assert_close(schedule_flush(3, true), 60, 1e-9);
}

static void checkpoints_take_a_hundredth_of_the_time_unless_they_get_too_rare(void **state)
{
    (void)state;
    assert_true(schedule_checkpoint(60, 0) == 60);
    assert_true(schedule_checkpoint(60, 0.5) == 60);
    assert_true(fabs(schedule_checkpoint(60, 2) - 200) < 1e-9);
    assert_true(schedule_checkpoint(60, 20) == 600);
    assert_true(schedule_checkpoint(0, 20) == 0); /* never */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(checkpoints_take_a_hundredth_of_the_time_unless_they_get_too_rare),
        cmocka_unit_test(an_interval_of_zero_is_never_due),
        cmocka_unit_test(the_beginning_counts),
        cmocka_unit_test(each_multiple_is_met_once_whatever_the_step),
        cmocka_unit_test(a_step_over_several_multiples_is_due_once),
        cmocka_unit_test(a_boundary_at_the_very_multiple_is_due_there),
        cmocka_unit_test(a_multiple_as_people_write_it_is_met),
        cmocka_unit_test(absurd_intervals_end),
        cmocka_unit_test(what_takes_long_to_write_is_written_seldom),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
