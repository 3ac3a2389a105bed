/* SPDX-License-Identifier: BSD-3-Clause */
/* How fast a run goes: rates, times. The clock is the test's. */
#include "run/meter.h"
#include "tests/support/check.h"

/* Steps of dt, one each `wall` seconds from `now`, from step `first`. Returns the clock afterwards. */
static double go(Meter *meter, uint64_t first, int n, double dt, double wall, double now)
{
    for (int k = 1; k <= n; k++) {
        const uint64_t step = first + (uint64_t)k;
        now += wall;
        meter_step(meter, (MnsProgress){.step = step, .t = dt * (double)step}, 100, wall / 2, now);
    }
    return now;
}

static void nothing_is_known_before_the_first_step(void **state)
{
    (void)state;
    Meter meter = {.ran = 0};
    meter_begin(&meter, (MnsProgress){.t = 0}, 50);
    assert_true(isnan(meter_rate(&meter)));
    assert_true(isnan(meter_eta(&meter, 0, 1)));
    assert_true(isnan(meter_ns(&meter)));
}

static void rates_are_known_from_the_first_step(void **state)
{
    (void)state;
    Meter meter = {.ran = 0};
    meter_begin(&meter, (MnsProgress){.t = 0}, 50);
    go(&meter, 0, 1, 0.01, 0.1, 50);
    assert_close(meter_rate(&meter), 10, 1e-9);
    assert_close(meter_eta(&meter, 0.01, 1.01), 10, 1e-9);
    assert_close(meter_ns(&meter), 0.05 / 100 * 1e9, 1);
}

static void a_pause_changes_neither_rate_nor_time_in_motion(void **state)
{
    (void)state;
    Meter meter = {.ran = 0};
    meter_begin(&meter, (MnsProgress){.t = 0}, 50);
    double now = go(&meter, 0, 20, 0.01, 0.1, 50);
    assert_close(meter_ran(&meter, now + 1), 3, 1e-9);
    meter_halt(&meter, now);
    meter_halt(&meter, now + 5);
    assert_close(meter_ran(&meter, now + 100), 2, 1e-9);
    meter_begin(&meter, (MnsProgress){.step = 20, .t = 0.2}, now + 100);
    now = go(&meter, 20, 20, 0.01, 0.1, now + 100);
    assert_close(meter_ran(&meter, now), 4, 1e-9);
    assert_close(meter_rate(&meter), 10, 1e-6);
}

static void the_last_seconds_decide(void **state)
{
    (void)state;
    Meter meter = {.ran = 0};
    meter_begin(&meter, (MnsProgress){.t = 0}, 0);
    const double now = go(&meter, 0, 100, 0.01, 0.1, 0);
    go(&meter, 100, 20, 0.01, 1, now);
    assert_close(meter_rate(&meter), 1, 0.01);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_known_before_the_first_step),
        cmocka_unit_test(rates_are_known_from_the_first_step),
        cmocka_unit_test(a_pause_changes_neither_rate_nor_time_in_motion),
        cmocka_unit_test(the_last_seconds_decide),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
