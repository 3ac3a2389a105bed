/* SPDX-License-Identifier: BSD-3-Clause */
/* Ticks are round, within the range, not too many, and say what they mean. */
#include "client/cli/render_ticks.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

static void a_tank_of_usual_size_has_usual_ticks(void **state)
{
    (void)state;
    const Ticks t = ticks_make(0, 5.366, 12);
    assert_int_equal(t.n, 11);
    assert_string_equal(t.label[0], "0.0");
    assert_string_equal(t.label[1], "0.5");
    assert_string_equal(t.label[10], "5.0");
    assert_int_equal(t.exponent, 0);
}

/* The mantissa of the step is 1, 2 or 5, every tick is a multiple of it, and there is room for no step more. */
static void ticks_of_any_range_are_round_and_fill_it(void **state)
{
    (void)state;
    srand48(1);
    for (int k = 0; k < 20000; k++) {
        const double size = pow(10, 24 * drand48() - 12), lo = size * (8 * drand48() - 4),
                     hi = lo + size * (0.01 + drand48());
        const int most = 2 + (int)(drand48() * 12);
        const Ticks t = ticks_make(lo, hi, most);
        const double slack = 1e-6 * (hi - lo), mantissa = t.step / pow(10, floor(log10(t.step) + 1e-9));
        assert_true(fabs(mantissa - 1) < 1e-6 || fabs(mantissa - 2) < 1e-6 || fabs(mantissa - 5) < 1e-6);
        assert_true(t.n >= 1 && t.n <= most);
        assert_true(t.value[0] >= lo - slack && t.value[0] - t.step < lo + slack);
        assert_true(t.value[t.n - 1] <= hi + slack && t.value[t.n - 1] + t.step > hi - slack);
        for (int i = 0; i < t.n; i++) assert_true(fabs(remainder(t.value[i], t.step)) < 1e-6 * t.step);
    }
}

static void labels_read_back_as_the_values(void **state)
{
    (void)state;
    const Ticks t = ticks_make(-2.4e7, 1.1e7, 8);
    assert_int_equal(t.exponent, 7);
    for (int k = 0; k < t.n; k++) {
        const char *digits = t.label[k];
        const int minus = (unsigned char)digits[0] == 0xe2; /* the sign is a real minus, three bytes long */
        const double value = (minus ? -1 : 1) * strtod(digits + 3 * minus, NULL) * 1e7;
        assert_true(fabs(value - t.value[k]) < 1e-6 * t.step);
    }
}

static void zero_has_no_sign(void **state)
{
    (void)state;
    const Ticks t = ticks_make(-0.3, 0.3, 7);
    assert_int_equal(t.n, 7);
    assert_string_equal(t.label[3], "0.0");
    assert_string_equal(t.label[2], "−0.1");
}

static void a_tiny_range_gets_a_power_of_ten(void **state)
{
    (void)state;
    const Ticks t = ticks_make(0, 8e-12, 9);
    assert_int_equal(t.exponent, -12);
    assert_string_equal(t.label[1], "1");
}

static void units_are_printed_as_in_books(void **state)
{
    (void)state;
    char text[40];
    unit_print("kg/m^3", sizeof text, text);
    assert_string_equal(text, "kg/m³");
    unit_print("m^-12*s", sizeof text, text);
    assert_string_equal(text, "m⁻¹²·s");
    power_print(-3, sizeof text, text);
    assert_string_equal(text, "10⁻³");
}

static void a_unit_that_is_too_long_is_cut(void **state)
{
    (void)state;
    char text[6] = "xxxxx";
    unit_print("kg/m^3/s^2", sizeof text, text);
    assert_string_equal(text, "kg/m/");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tank_of_usual_size_has_usual_ticks),
        cmocka_unit_test(ticks_of_any_range_are_round_and_fill_it),
        cmocka_unit_test(labels_read_back_as_the_values),
        cmocka_unit_test(zero_has_no_sign),
        cmocka_unit_test(a_tiny_range_gets_a_power_of_ten),
        cmocka_unit_test(units_are_printed_as_in_books),
        cmocka_unit_test(a_unit_that_is_too_long_is_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
