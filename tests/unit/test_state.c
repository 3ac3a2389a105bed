/* SPDX-License-Identifier: BSD-3-Clause */
/* Powers are those of the C library to rounding, equations of state can be turned round, and begin with the speed of sound. */
#include "sim/state.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"

/* Over all that a density may be (limits.density_min, density_max) and exponents of liquids and gases and their inverses, and far beyond. */
static void powers_are_those_of_the_library(void **state)
{
    (void)state;
    static const double exponents[] = {7, 1.4, 1 / 7.0, 1 / 1.4, 1.0001, 3, -2.5, 0};
    uint64_t seed = 1;
    double worst = 0, far = 0;
    for (int k = 0; k < 200000; k++) {
        const double y = exponents[k % 8], x = exp(4.7 * cloud_noise(&seed)), exact = pow(x, y); /* 0.009 to 110 */
        worst = fmax(worst, fabs(state_power(x, y) / exact - 1));
        const double wide = exp(95 * cloud_noise(&seed)),
                     large = pow(wide, y); /* 1e-41 to 1e41, to any of the eight powers */
        far = fmax(far, fabs(state_power(wide, y) / large - 1));
    }
    assert_less(worst, 2e-14); /* measured: 8.0e-15 */
    assert_less(far, 4e-13);   /* measured: 1.9e-13; y ln x of up to 660 has an ulp of 1e-13 */
    for (int k = -40; k <= 40; k++) assert_close(state_power(ldexp(1, k), 7), ldexp(1, 7 * k), 1e-13 * ldexp(1, 7 * k));
    assert_true(state_power(1, 7) == 1 &&
                state_power(1, 1 / 1.4) == 1); /* so that the pressure at rest is 0, not nearly */
}

static void powers_of_what_has_none_are_no_numbers(void **state)
{
    (void)state;
    assert_true(state_power(0, 7) == 0);
    assert_true(isnan(state_power(-1e-9, 7)));
    assert_true(isnan(state_power(NAN, 7)));
    assert_true(state_power(INFINITY, 7) == INFINITY);
    assert_true(state_power(1e200, 7) == INFINITY);
    assert_true(state_power(1e-200, 7) == 0);
}

static const Phase PHASES[] = {{.rho0 = 1000, .c = 20, .exponent = 7, .background = 90},
                               {.rho0 = 1.2, .c = 50, .exponent = 1.4, .background = 90},
                               {.rho0 = 800, .c = 30, .exponent = 1},
                               {.rho0 = 3, .c = 2, .exponent = 0}}; /* what a case leaves open */

static void density_and_pressure_are_each_others_inverse(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof PHASES / sizeof *PHASES; k++) {
        const Phase *phase = &PHASES[k];
        for (double ratio = 0.3; ratio < 3; ratio *= 1.01) {
            const double rho = ratio * phase->rho0, p = state_pressure(phase, rho);
            /* In the root, an error of the power counts divided by its exponent, but 1 + p/B is near 0 where rho is small: of 0.3^7 =
             * 2e-4 rounding takes 1e-16. */
            assert_close(state_density(phase, p - phase->background), rho, 1e-12 * rho);
        }
        assert_true(state_pressure(phase, phase->rho0) == phase->background);
        assert_true(state_density(phase, 0) == phase->rho0);
    }
}

/* dp/d rho = c^2 at rest; beyond, a liquid stiffens as rho^(gamma - 1). */
static void sound_has_its_speed_at_the_reference_density(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof PHASES / sizeof *PHASES; k++) {
        const Phase *phase = &PHASES[k];
        const double exponent = fmax(1, phase->exponent), step = 1e-5 * phase->rho0;
        for (int q = 0; q < 3; q++) {
            const double ratio = 0.9 + 0.1 * q, rho = ratio * phase->rho0;
            const double slope = (state_pressure(phase, rho + step) - state_pressure(phase, rho - step)) / (2 * step);
            /* (gamma - 1)(gamma - 2)/6 of the step squared, 5e-10, and rounding of p over the step. */
            assert_close(slope / (phase->c * phase->c), pow(ratio, exponent - 1), 3e-9);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(powers_are_those_of_the_library),
        cmocka_unit_test(powers_of_what_has_none_are_no_numbers),
        cmocka_unit_test(density_and_pressure_are_each_others_inverse),
        cmocka_unit_test(sound_has_its_speed_at_the_reference_density),
    };
    return cmocka_run_group_tests_name("state", tests, NULL, NULL);
}
