/* SPDX-License-Identifier: BSD-3-Clause */
/* The elementary functions are the nearest doubles to what they are functions of, in C and in formulas: compared with MPFR. */
#include "sim/formula.h"
#include "tests/support/check.h"
#include <mpfr.h>
#include <stdio.h>

enum { TRIALS = 5000 };

typedef struct Function {
    const char *name, *formula; /* NULL: none has it */
    double (*ours)(double);
    int (*theirs)(mpfr_t, const mpfr_t, mpfr_rnd_t);
    double from, to;
} Function;

static const Function FUNCTIONS[] = {
    {"sin", "sin(x)", sin, mpfr_sin, -1e3, 1e3},    {"cos", "cos(x)", cos, mpfr_cos, -1e3, 1e3},
    {"tan", "tan(x)", tan, mpfr_tan, -1e2, 1e2},    {"asin", "asin(x)", asin, mpfr_asin, -1, 1},
    {"acos", "acos(x)", acos, mpfr_acos, -1, 1},    {"atan", "atan(x)", atan, mpfr_atan, -50, 50},
    {"exp", "exp(x)", exp, mpfr_exp, -700, 700},    {"log", "log(x)", log, mpfr_log, 0, 1e6},
    {"log2", "log(x, 2)", log2, mpfr_log2, 0, 1e6}, {"log10", "log(x, 10)", log10, mpfr_log10, 0, 1e6},
    {"cbrt", NULL, cbrt, mpfr_cbrt, -1e3, 1e3},
};
enum { N_FUNCTIONS = sizeof FUNCTIONS / sizeof *FUNCTIONS };

static double argument(int k, double from, double to)
{
    return from + (to - from) * fmod(0.5 + k * 0.6180339887498949, 1);
}

static double nearest(const Function *f, double x)
{
    MPFR_DECL_INIT(value, 53);
    mpfr_set_d(value, x, MPFR_RNDN);
    f->theirs(value, value, MPFR_RNDN);
    return mpfr_get_d(value, MPFR_RNDN);
}

static double nearest_power(double x, double y)
{
    MPFR_DECL_INIT(value, 53);
    MPFR_DECL_INIT(exponent, 53);
    mpfr_set_d(value, x, MPFR_RNDN);
    mpfr_set_d(exponent, y, MPFR_RNDN);
    mpfr_pow(value, value, exponent, MPFR_RNDN);
    return mpfr_get_d(value, MPFR_RNDN);
}

static Formula *formula_from(const char *text)
{
    static const char *const x[] = {"x", NULL};
    Formula *f = NULL;
    MnsError error = {0};
    if (formula_new(text, x, NULL, 0, &f, &error)) fail_msg("%s: %s", text, error.text);
    return f;
}

static void they_are_the_nearest_doubles(void **state)
{
    (void)state;
    for (const Function *f = FUNCTIONS; f < FUNCTIONS + N_FUNCTIONS; f++)
        for (int k = 0; k < TRIALS; k++) {
            const double x = argument(k, f->from, f->to), value = f->ours(x);
            if (value != nearest(f, x)) fail_msg("%s(%a): %a, not %a", f->name, x, value, nearest(f, x));
        }
}

static void those_of_two_arguments_are_too(void **state)
{
    (void)state;
    for (int k = 0; k < TRIALS; k++) {
        const double x = argument(k, 1e-3, 30), y = argument(7 * k + 3, -20, 20);
        if (pow(x, y) != nearest_power(x, y)) fail_msg("pow(%a, %a): %a", x, y, pow(x, y));
        MPFR_DECL_INIT(value, 53);
        MPFR_DECL_INIT(other, 53);
        mpfr_set_d(value, y, MPFR_RNDN);
        mpfr_set_d(other, x, MPFR_RNDN);
        mpfr_atan2(value, value, other, MPFR_RNDN);
        if (atan2(y, x) != mpfr_get_d(value, MPFR_RNDN)) fail_msg("atan2(%a, %a): %a", y, x, atan2(y, x));
    }
}

static void a_sine_and_a_cosine_at_once_are_no_others(void **state)
{
    (void)state;
    for (int k = 0; k < TRIALS; k++) {
        const double x = argument(k, -1e3, 1e3);
        double sine, cosine;
        sincos(x, &sine, &cosine);
        assert_true(sine == sin(x) && cosine == cos(x));
    }
}

/* The C library's powers are not the nearest ones at some eighty in a hundred thousand of such arguments, which Lua would find. */
static void formulas_call_them(void **state)
{
    (void)state;
    for (const Function *f = FUNCTIONS; f < FUNCTIONS + N_FUNCTIONS; f++) {
        if (!f->formula) continue;
        Formula *formula = formula_from(f->formula);
        for (int k = 0; k < TRIALS; k++) {
            const double x = argument(k, f->from, f->to), value = formula_eval(formula, &x);
            if (value != nearest(f, x)) fail_msg("%s at %a: %a, not %a", f->formula, x, value, nearest(f, x));
        }
        formula_free(formula);
    }
    Formula *power = formula_from("x^2.5");
    for (int k = 1; k < 2 * TRIALS; k++) {
        const double x = k * 1e-3;
        if (formula_eval(power, &x) != nearest_power(x, 2.5)) fail_msg("%a^2.5: %a", x, formula_eval(power, &x));
    }
    formula_free(power);
}

static void what_is_no_number_or_has_no_end_stays_so(void **state)
{
    (void)state;
    const double infinite = INFINITY, none = NAN;
    assert_true(isnan(sin(infinite)) && isnan(log(-1)) && isnan(pow(-8, 1.0 / 3)) && isnan(exp(none)));
    assert_true(exp(infinite) == infinite && exp(-infinite) == 0 && exp(1000) == infinite && exp(-1000) == 0);
    assert_true(log(0) == -infinite && pow(0, -1) == infinite && pow(none, 0) == 1 && pow(1, none) == 1);
    assert_true(signbit(sin(-0.0)) && sin(-0.0) == 0 && cos(0) == 1 && cbrt(-27) == -3 && pow(-3, 3) == -27);
    assert_true(exp(-740) > 0 && exp(-740) < 0x1p-1066);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(they_are_the_nearest_doubles),
        cmocka_unit_test(those_of_two_arguments_are_too),
        cmocka_unit_test(a_sine_and_a_cosine_at_once_are_no_others),
        cmocka_unit_test(formulas_call_them),
        cmocka_unit_test(what_is_no_number_or_has_no_end_stays_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
