/* SPDX-License-Identifier: BSD-3-Clause */
/* Metrics as text: names, heads, escapes and numbers as Prometheus and OpenMetrics read them. */
#include "http/exposition.h"
#include "tests/support/check.h"
#include <stdlib.h>
#include <string.h>

static const Family count = {"a_steps", "", METRIC_COUNTER, "Steps"};
static const Family cost = {"a_pass", "seconds", METRIC_COUNTER, "Time \\ by \"pass\""};
static const Family heat = {"a_heat", "kelvins", METRIC_GAUGE, "How warm\nit is"};
static const Family build = {"a_build", "", METRIC_INFO, "The program"};

/* Everything that is printed by `print`. */
static void assert_prints(void (*print)(Exposition *), bool open_metrics, const char *expected)
{
    Exposition exposition;
    size_t size = 0;
    assert_true(exposition_begin(&exposition, open_metrics));
    print(&exposition);
    char *text = exposition_end(&exposition, &size);
    assert_non_null(text);
    assert_string_equal(text, expected);
    assert_int_equal(size, strlen(expected));
    free(text);
}

static void print_all(Exposition *to)
{
    exposition_sample(to, &build, 1, 2, (Label[]){{"version", "1.0"}, {"commit", ""}});
    exposition_sample(to, &count, 7, 0, NULL);
    exposition_sample(to, &cost, 0.5, 1, &(Label){"pass", "forces"});
    exposition_sample(to, &cost, 0.25, 1, &(Label){"pass", "density"});
    exposition_sample(to, &heat, 300, 0, NULL);
}

static void names_and_heads_are_those_of_prometheus(void **state)
{
    (void)state;
    assert_prints(print_all, false,
                  "# HELP a_build_info The program.\n"
                  "# TYPE a_build_info gauge\n"
                  "a_build_info{version=\"1.0\",commit=\"\"} 1\n"
                  "# HELP a_steps_total Steps.\n"
                  "# TYPE a_steps_total counter\n"
                  "a_steps_total 7\n"
                  "# HELP a_pass_seconds_total Time \\\\ by \"pass\".\n"
                  "# TYPE a_pass_seconds_total counter\n"
                  "a_pass_seconds_total{pass=\"forces\"} 0.5\n"
                  "a_pass_seconds_total{pass=\"density\"} 0.25\n"
                  "# HELP a_heat_kelvins How warm\\nit is.\n"
                  "# TYPE a_heat_kelvins gauge\n"
                  "a_heat_kelvins 300\n");
}

static void names_and_heads_are_those_of_openmetrics(void **state)
{
    (void)state;
    assert_prints(print_all, true,
                  "# HELP a_build The program.\n"
                  "# TYPE a_build info\n"
                  "a_build_info{version=\"1.0\",commit=\"\"} 1\n"
                  "# HELP a_steps Steps.\n"
                  "# TYPE a_steps counter\n"
                  "a_steps_total 7\n"
                  "# HELP a_pass_seconds Time \\\\ by \\\"pass\\\".\n"
                  "# TYPE a_pass_seconds counter\n"
                  "# UNIT a_pass_seconds seconds\n"
                  "a_pass_seconds_total{pass=\"forces\"} 0.5\n"
                  "a_pass_seconds_total{pass=\"density\"} 0.25\n"
                  "# HELP a_heat_kelvins How warm\\nit is.\n"
                  "# TYPE a_heat_kelvins gauge\n"
                  "# UNIT a_heat_kelvins kelvins\n"
                  "a_heat_kelvins 300\n"
                  "# EOF\n");
}

static void print_odd_labels(Exposition *to)
{
    /* U+202E among them; in bytes, as it is taken for a trick where it is written in a text. */
    static const char odd[] = {'a', '\t', '\xe2', '\x80', '\xae', 'b', '\x1b', 0};
    exposition_sample(to, &count, 1, 3,
                      (Label[]){{"a", "C:\\DIR\n\"quoted\""}, {"b", "{x=\"\xc3\xa9\"} # 1"}, {"c", odd}});
}

static void labels_may_hold_anything(void **state)
{
    (void)state;
    assert_prints(print_odd_labels, false,
                  "# HELP a_steps_total Steps.\n"
                  "# TYPE a_steps_total counter\n"
                  "a_steps_total{a=\"C:\\\\DIR\\\\n\\\"quoted\\\"\",b=\"{x=\\\"\xc3\xa9\\\"} # "
                  "1\",c=\"a\\\\t\\\\u202eb\\\\u001b\"} 1\n");
}

static void print_odd_numbers(Exposition *to)
{
    const double values[] = {NAN,     -NAN,  INFINITY, -INFINITY,        -0.0,     0.1,
                             1.0 / 3, 1e300, 5e-324,   9007199254740991, 123456789};
    for (size_t k = 0; k < sizeof values / sizeof *values; k++) exposition_sample(to, &heat, values[k], 0, NULL);
}

static void numbers_are_whole_and_no_longer_than_that_takes(void **state)
{
    (void)state;
    assert_prints(print_odd_numbers, false,
                  "# HELP a_heat_kelvins How warm\\nit is.\n"
                  "# TYPE a_heat_kelvins gauge\n"
                  "a_heat_kelvins NaN\n"
                  "a_heat_kelvins NaN\n"
                  "a_heat_kelvins +Inf\n"
                  "a_heat_kelvins -Inf\n"
                  "a_heat_kelvins -0\n"
                  "a_heat_kelvins 0.1\n"
                  "a_heat_kelvins 0.3333333333333333\n"
                  "a_heat_kelvins 1e+300\n"
                  "a_heat_kelvins 4.94065645841247e-324\n"
                  "a_heat_kelvins 9007199254740991\n"
                  "a_heat_kelvins 123456789\n");
}

static void print_nothing(Exposition *to)
{
    (void)to;
}

static void families_without_samples_are_left_out(void **state)
{
    (void)state;
    assert_prints(print_nothing, false, "");
    assert_prints(print_nothing, true, "# EOF\n");
}

static void the_form_is_the_one_asked_for(void **state)
{
    (void)state;
    static const char *const open[] = {
        "application/openmetrics-text", "application/openmetrics-text; version=1.0.0; charset=utf-8",
        "text/plain;q=0.5, application/openmetrics-text;version=0.0.1;q=0.75",
        "application/openmetrics-text;version=1.0.0,text/plain;version=0.0.4;q=0.5,*/*;q=0.1"};
    static const char *const plain[] = {"",
                                        "*/*",
                                        "text/plain",
                                        "application/openmetrics-text;q=0",
                                        "application/openmetrics-textile",
                                        "application/openmetrics-text; q=0.3, text/plain;version=0.0.4;q=0.4",
                                        ",;,=,"};
    assert_false(exposition_accepts_open_metrics(NULL));
    for (size_t k = 0; k < sizeof open / sizeof *open; k++) assert_true(exposition_accepts_open_metrics(open[k]));
    for (size_t k = 0; k < sizeof plain / sizeof *plain; k++) assert_false(exposition_accepts_open_metrics(plain[k]));
    assert_non_null(strstr(exposition_type(true), "openmetrics-text; version=1.0.0"));
    assert_non_null(strstr(exposition_type(false), "text/plain; version=0.0.4"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_and_heads_are_those_of_prometheus),
        cmocka_unit_test(names_and_heads_are_those_of_openmetrics),
        cmocka_unit_test(labels_may_hold_anything),
        cmocka_unit_test(numbers_are_whole_and_no_longer_than_that_takes),
        cmocka_unit_test(families_without_samples_are_left_out),
        cmocka_unit_test(the_form_is_the_one_asked_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
