/* SPDX-License-Identifier: BSD-3-Clause */
/* Formulas compute what they say, know nothing but mathematics, and cannot hang or exhaust the program. */
#include "sim/formula.h"
#include "tests/support/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const XYT[] = {"x", "y", "t", NULL};
static const double AT[] = {2.5, -0.75, 3};

static double value_of(const char *text, const MnsConstant *constants, size_t n)
{
    Formula *f = NULL;
    MnsError error = {0};
    if (formula_new(text, XYT, constants, n, &f, &error)) fail_msg("%s: %s", text, error.text);
    const double value = formula_eval(f, AT);
    formula_free(f);
    return value;
}

/* The sentence with which a text is refused. */
static void assert_refused(const char *text, const char *because)
{
    Formula *f = NULL;
    MnsError error = {0};
    assert_int_equal(formula_new(text, XYT, NULL, 0, &f, &error), MNS_E_INVALID);
    assert_null(f);
    assert_int_equal(error.status, MNS_E_INVALID);
    if (!strstr(error.text, because)) fail_msg("%s: \"%s\" does not say \"%s\"", text, error.text, because);
}

static void arithmetic_is_that_of_doubles(void **state)
{
    (void)state;
    assert_true(value_of("x + y*t", NULL, 0) == 2.5 - 0.75 * 3);
    assert_true(value_of("(x - y)/t", NULL, 0) == (2.5 + 0.75) / 3);
    assert_true(value_of("2^10 - 1", NULL, 0) == 1023);
    assert_true(value_of("-y", NULL, 0) == 0.75);
    assert_true(value_of("7 % 4", NULL, 0) == 3);
    assert_true(value_of("1/3", NULL, 0) == 1.0 / 3);
    assert_true(value_of("1e-3", NULL, 0) == 1e-3);
    assert_true(value_of("  4  ", NULL, 0) == 4);
}

static void functions_are_those_of_mathematics(void **state)
{
    (void)state;
    assert_true(value_of("0.1*sin(2*pi*x)", NULL, 0) == 0.1 * sin(2 * acos(-1) * 2.5));
    assert_true(value_of("cos(x) + tan(y)", NULL, 0) == cos(2.5) + tan(-0.75));
    assert_true(value_of("exp(x)*log(t)", NULL, 0) == exp(2.5) * log(3));
    assert_true(value_of("sqrt(abs(y))", NULL, 0) == sqrt(0.75));
    assert_true(value_of("max(x, y, t) - min(x, y, t)", NULL, 0) == 3.75);
    assert_true(value_of("floor(x) + ceil(x)", NULL, 0) == 5);
    assert_true(value_of("acos(0.3) + asin(0.3) + atan(0.3)", NULL, 0) == acos(0.3) + asin(0.3) + atan(0.3));
    assert_true(value_of("atan(y, x)", NULL, 0) == atan2(-0.75, 2.5));
    assert_true(value_of("fmod(x, 1)", NULL, 0) == 0.5);
    assert_close(value_of("deg(pi) + rad(180)", NULL, 0), 180 + acos(-1), 1e-13); /* rounding */
}

static void truth_is_one_and_zero(void **state)
{
    (void)state;
    assert_true(value_of("x > 2 and y < 0", NULL, 0) == 1);
    assert_true(value_of("x > 2 and y > 0", NULL, 0) == 0);
    assert_true(value_of("not (x == 2.5) or t ~= 3", NULL, 0) == 0);
    assert_true(value_of("t > 2 and x or y", NULL, 0) == 2.5);
    assert_true(value_of("t > 4 and x or y", NULL, 0) == -0.75);
}

static void constants_may_use_those_before_them(void **state)
{
    (void)state;
    char names[3][4] = {"H", "g", "U"}, values[3][16] = {"0.3", "9.81", "2*sqrt(g*H)"};
    const MnsConstant list[] = {{names[0], values[0]}, {names[1], values[1]}, {names[2], values[2]}};
    assert_true(value_of("U + x", list, 3) == 2 * sqrt(9.81 * 0.3) + 2.5);
    const MnsConstant backwards[] = {list[2], list[1], list[0]};
    Formula *f = NULL;
    MnsError error = {0};
    assert_int_equal(formula_new("U", XYT, backwards, 3, &f, &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "unknown name"));
}

static void variables_win_over_constants_of_their_name(void **state)
{
    (void)state;
    char name[] = "x", value[] = "77";
    const MnsConstant list[] = {{name, value}};
    assert_true(value_of("x", list, 1) == 2.5);
}

static void unknown_names_are_named(void **state)
{
    (void)state;
    assert_refused("sinn(x)", "is not a formula: unknown name 'sinn'");
    assert_refused("x + velocity", "unknown name 'velocity'");
    assert_refused("z", "unknown name 'z'");
}

static void what_is_no_expression_is_refused(void **state)
{
    (void)state;
    static const char *const texts[] = {"", "x +", "(x", "x)", "x y", "1 = 1", "x = 2", "return 1", "if x then 1 end"};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) assert_refused(texts[k], "is not a formula");
    assert_refused("'text'", "neither a number");
    assert_refused("{}", "neither a number");
    assert_refused("nil", "neither a number");
    assert_refused("x < 'a'", "is not a formula");
}

/* The text is put into brackets: closing them must not open a way to statements. */
static void text_cannot_leave_its_brackets_to_loop(void **state)
{
    (void)state;
    Formula *f = NULL;
    const char *const texts[] = {"1) while true do end --", "(function() while true do end end)()",
                                 "(function() local function f() return f() end return f() end)()"};
    for (size_t k = 0; k < 3; k++) assert_int_equal(formula_new(texts[k], XYT, NULL, 0, &f, NULL), MNS_E_INVALID);
    assert_refused("(function() while true do end end)()", "too long");
}

static void bombs_end_with_an_error(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "(function() local s = 'a' while true do s = s .. s end end)()",
        "(function() local t = {} for k = 1, 1e9 do t[k] = k end return 1 end)()",
        "(function() local function f() return 1 + f() end return f() end)()",
        "#('x'):rep(1e9)",
    };
    Formula *f = NULL;
    MnsError error = {0};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        assert_int_not_equal(formula_new(texts[k], XYT, NULL, 0, &f, &error), MNS_OK);
        assert_null(f);
    }
}

/* A formula that only turns bad at some points ends there too, and is as good as new at the next. */
static void evaluation_that_fails_gives_no_number_and_does_no_harm(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "x > 2 and sinn(x) or x",
        "x > 2 and 'text' or x",
        "x > 2 and (function() while true do end end)() or x",
        "x > 2 and (function() local s = 'a' while true do s = s .. s end end)() or x",
    };
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        Formula *f = NULL;
        assert_int_equal(formula_new(texts[k], XYT, NULL, 0, &f, NULL), MNS_OK);
        for (int round = 0; round < 3; round++) {
            assert_true(isnan(formula_eval(f, (const double[]){2.5, 0, 0})));
            assert_true(formula_eval(f, (const double[]){1.25, 0, 0}) == 1.25);
        }
        formula_free(f);
    }
}

/* What it keeps from one point to the next fills its memory after 14,600 of them, so that there is none left to say with what it gave. */
static void evaluation_without_memory_gives_no_number(void **state)
{
    (void)state;
    Formula *f = NULL;
    MnsError error = {0};
    const char *text = "(function() if x == 7 then u = {u} return nil end u = {} return 1 end)()";
    if (formula_new(text, XYT, NULL, 0, &f, &error)) fail_msg("%s", error.text);
    for (int k = 0; k < 16000; k++) assert_true(isnan(formula_eval(f, (const double[]){7, 0, 0})));
    formula_free(f);
}

/* `a and b or c` goes to c where b is false, so that a slip of the pen gives now a number, now a truth. */
static void number_that_turns_into_a_truth_is_a_failure_and_the_other_way_round(void **state)
{
    (void)state;
    static const char *const texts[] = {"x > 2 and (y < 1) or x", "x > 2 and y or x < 9"};
    static const char *const why[] = {"true or false there, and a number elsewhere",
                                      "a number there, and true or false"};
    for (size_t k = 0; k < 2; k++) {
        Formula *f = NULL;
        assert_int_equal(formula_new(texts[k], XYT, NULL, 0, &f, NULL), MNS_OK);
        assert_true(formula_eval(f, (const double[]){1.25, 0, 0}) == (k ? 1 : 1.25));
        assert_null(formula_failure(f));
        assert_true(isnan(formula_eval(f, AT)));
        assert_non_null(strstr(formula_failure(f), why[k]));
        formula_mix(f);
        assert_true(formula_eval(f, AT) == (k ? AT[1] : 1));
        formula_free(f);
    }
}

/* Each caller has its own; one formula is enough for all where there are no variables. */
static void team_has_a_formula_for_each_thread(void **state)
{
    (void)state;
    FormulaTeam team;
    assert_int_equal(formula_team_init(&team, 3, "x > 2 and sinn(x) or x", XYT, NULL, 0, NULL), MNS_OK);
    assert_int_equal(team.n, 3);
    assert_ptr_not_equal(formula_of(&team, 1), formula_of(&team, 2));
    assert_true(formula_eval(formula_of(&team, 0), (const double[]){1.5, 0, 0}) == 1.5);
    assert_null(formula_team_failure(&team));
    (void)formula_eval(formula_of(&team, 2), AT);
    assert_non_null(strstr(formula_team_failure(&team), "sinn"));
    formula_team_forget(&team);
    assert_null(formula_team_failure(&team));
    formula_team_done(&team);
    assert_int_equal(formula_team_init(&team, 3, "2*pi + max(1, 4)", XYT, NULL, 0, NULL), MNS_OK);
    assert_int_equal(team.n, 1);
    assert_true(formula_eval(formula_of(&team, 2), AT) == 2 * acos(-1) + 4);
    formula_team_done(&team);
    assert_int_equal(formula_team_init(&team, 3, "2*", XYT, NULL, 0, NULL), MNS_E_INVALID);
}

static void failing_often_does_not_exhaust_the_formula(void **state)
{
    (void)state;
    Formula *f = NULL;
    assert_int_equal(formula_new("x > 2 and sinn(x) or x", XYT, NULL, 0, &f, NULL), MNS_OK);
    for (int k = 0; k < 200000; k++) (void)formula_eval(f, AT);
    assert_true(formula_eval(f, (const double[]){1.25, 0, 0}) == 1.25);
    formula_free(f);
}

static void division_by_zero_is_infinite_not_an_error(void **state)
{
    (void)state;
    assert_true(value_of("1/(t - 3)", NULL, 0) == INFINITY);
    assert_true(isnan(value_of("(t - 3)/(t - 3)", NULL, 0)));
    assert_true(isnan(value_of("sqrt(y)", NULL, 0)));
}

static void nothing_but_mathematics_is_there(void **state)
{
    (void)state;
    static const char *const names[] = {"os",           "io",           "string", "load",     "loadfile",
                                        "dofile",       "require",      "_G",     "debug",    "collectgarbage",
                                        "setmetatable", "getmetatable", "rawset", "table",    "package",
                                        "coroutine",    "print",        "math",   "tostring", "pcall"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        char text[64], because[64];
        snprintf(text, sizeof text, "%s and 1", names[k]);
        snprintf(because, sizeof because, "unknown name '%s'", names[k]);
        assert_refused(text, because);
    }
    assert_refused("('a'):rep(3)", "is not a formula"); /* no methods of strings either */
}

/* Bytecode can do what source cannot. */
static void compiled_code_is_no_text(void **state)
{
    (void)state;
    assert_refused("\x1bLua", "is not a formula");
}

static void formulas_do_not_share_anything(void **state)
{
    (void)state;
    Formula *f = NULL, *g = NULL;
    assert_int_equal(formula_new("(function() k = x return k end)()", XYT, NULL, 0, &f, NULL), MNS_OK);
    assert_true(formula_eval(f, AT) == 2.5);
    assert_int_equal(formula_new("k", XYT, NULL, 0, &g, NULL), MNS_E_INVALID);
    formula_free(f);
}

static void long_texts_do_not_overflow_the_complaint(void **state)
{
    (void)state;
    char text[4000];
    memset(text, '(', sizeof text - 1);
    text[sizeof text - 1] = 0;
    assert_refused(text, "is not a formula");
}

enum { MANY = 150 };

/* More than a state of Lua has room for by itself. */
static void a_formula_may_have_many_variables(void **state)
{
    (void)state;
    char names[MANY][16], text[MANY * 8] = "";
    const char *variables[MANY + 1] = {NULL};
    double values[MANY], sum = 0;
    for (int k = 0; k < MANY; k++) {
        snprintf(names[k], sizeof names[k], "v%d", k);
        variables[k] = names[k];
        snprintf(text + strlen(text), sizeof text - strlen(text), k ? "+%s" : "%s", names[k]);
        sum += values[k] = k + 1;
    }
    Formula *f = NULL;
    MnsError error = {0};
    if (formula_new(text, variables, NULL, 0, &f, &error)) fail_msg("%s", error.text);
    assert_true(formula_eval(f, values) == sum);
    formula_free(f);
}

/* "1+1+1 ...", of n letters. */
static char *sum_of_ones(size_t n)
{
    char *text = malloc(n + 1);
    assert_non_null(text);
    for (size_t k = 0; k < n; k++) text[k] = k % 2 ? '+' : '1';
    text[n - (n % 2 ? 0 : 1)] = 0;
    return text;
}

static void a_formula_that_does_not_fit_is_refused(void **state)
{
    (void)state;
    for (size_t n = 10000; n <= 1000000; n *= 10) {
        char *text = sum_of_ones(n);
        const MnsConstant constant = {.name = "c", .value = text};
        Formula *f = NULL;
        MnsError error = {0};
        if (formula_new(text, XYT, NULL, 0, &f, &error)) assert_int_equal(error.status, MNS_E_INVALID);
        formula_free(f);
        f = NULL;
        if (formula_new("c", XYT, &constant, 1, &f, &error)) assert_int_equal(error.status, MNS_E_INVALID);
        formula_free(f);
        free(text);
    }
    char *text = sum_of_ones(1000000);
    assert_refused(text, "not enough memory");
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arithmetic_is_that_of_doubles),
        cmocka_unit_test(functions_are_those_of_mathematics),
        cmocka_unit_test(truth_is_one_and_zero),
        cmocka_unit_test(constants_may_use_those_before_them),
        cmocka_unit_test(variables_win_over_constants_of_their_name),
        cmocka_unit_test(unknown_names_are_named),
        cmocka_unit_test(what_is_no_expression_is_refused),
        cmocka_unit_test(text_cannot_leave_its_brackets_to_loop),
        cmocka_unit_test(bombs_end_with_an_error),
        cmocka_unit_test(evaluation_that_fails_gives_no_number_and_does_no_harm),
        cmocka_unit_test(evaluation_without_memory_gives_no_number),
        cmocka_unit_test(number_that_turns_into_a_truth_is_a_failure_and_the_other_way_round),
        cmocka_unit_test(team_has_a_formula_for_each_thread),
        cmocka_unit_test(failing_often_does_not_exhaust_the_formula),
        cmocka_unit_test(division_by_zero_is_infinite_not_an_error),
        cmocka_unit_test(nothing_but_mathematics_is_there),
        cmocka_unit_test(compiled_code_is_no_text),
        cmocka_unit_test(formulas_do_not_share_anything),
        cmocka_unit_test(long_texts_do_not_overflow_the_complaint),
        cmocka_unit_test(a_formula_may_have_many_variables),
        cmocka_unit_test(a_formula_that_does_not_fit_is_refused),
    };
    return cmocka_run_group_tests_name("formula", tests, NULL, NULL);
}
