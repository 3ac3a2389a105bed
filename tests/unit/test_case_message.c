/* SPDX-License-Identifier: BSD-3-Clause */
/* Messages from elsewhere are held to the same bounds as files, and every shipped case survives being printed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cases/translate.h"
#include "common/case/file.h"
#include "tests/support/shipped.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char small[] = "dimensions: 2\nresolution: 10\nend_time: 1\ndomain: {min: [0, 0], max: [1, 1]}\n"
                            "fluids: [{name: water, density: 1000, sound_speed: 10}]\nscheme: {}\ngravity: [0, 1]\n";

/* The message of the small case for a test to spoil. */
static int setup(void **state)
{
    CaseFile *file = NULL;
    if (case_file_parse("a.yaml", small, sizeof small - 1, &file, NULL)) return 1;
    const MnsStatus status = case_message_set(case_file_message(file), "threads", "1", (Meniscus__Case **)state, NULL);
    case_file_free(file);
    return status != MNS_OK;
}

static int teardown(void **state)
{
    meniscus__case__free_unpacked(*state, NULL);
    return 0;
}

static void complains(const Meniscus__Case *m, const char *path, const char *expected)
{
    MnsError error = {0};
    assert_int_equal(case_message_check(m, &error), MNS_E_INVALID);
    assert_string_equal(error.path, path);
    assert_string_equal(error.text, expected);
}

static void a_good_message_passes(void **state)
{
    assert_int_equal(case_message_check(*state, NULL), MNS_OK);
}

static void an_empty_message_lacks_entries(void **state)
{
    (void)state;
    const Meniscus__Case empty = MENISCUS__CASE__INIT;
    complains(&empty, "dimensions", "dimensions: missing, required: whole number in [2, 3]");
}

static void numbers_that_are_none_are_refused(void **state)
{
    Meniscus__Case *m = *state;
    m->resolution = NAN;
    complains(m, "resolution", "resolution: found \".nan\", allowed: [1, 1e6]");
    m->resolution = 10;
    m->domain->max[1] = -INFINITY;
    complains(m, "domain.max[1]", "domain.max[1]: found \"-.inf\", allowed: any finite number m");
}

static void numbers_out_of_bounds_are_refused(void **state)
{
    Meniscus__Case *m = *state;
    m->fluids[0]->density = 0;
    complains(m, "fluids[0].density", "fluids[0].density: found \"0\", allowed: [1e-9, 1e9] kg/m^3");
    m->fluids[0]->density = 1;
    m->dimensions = 4;
    complains(m, "dimensions", "dimensions: found \"4\", allowed: whole number in [2, 3]");
}

static void unknown_words_are_refused(void **state)
{
    Meniscus__Case *m = *state;
    m->scheme->has_kernel = true;
    m->scheme->kernel = (Meniscus__Kernel)77;
    complains(m, "scheme.kernel",
              "scheme.kernel: found \"77\", allowed: wendland-c2, truncated-gaussian, quintic-spline");
}

static void texts_that_no_file_can_hold_are_refused(void **state)
{
    Meniscus__Case *m = *state;
    m->gravity[1][0] = '\x80';
    complains(m, "gravity[1]",
              "gravity[1]: found a text that is not UTF-8 or has control characters in it: remove them");
    m->gravity[1][0] = '\x1b';
    complains(m, "gravity[1]",
              "gravity[1]: found a text that is not UTF-8 or has control characters in it: remove them");
    free(m->gravity[1]);
    m->gravity[1] = strdup("\xc2\x9b"
                           "2J"); /* the same order to a terminal */
    complains(m, "gravity[1]",
              "gravity[1]: found a text that is not UTF-8 or has control characters in it: remove them");
}

static void missing_items_are_refused(void **state)
{
    Meniscus__Case *m = *state;
    m->domain->n_max = 1;
    complains(m, "domain.max", "domain.max: found a list of 1, allowed: a list of 2 to 3");
    m->domain->n_max = 2;
    m->fluids[0]->has_density = false;
    complains(m, "fluids[0].density", "fluids[0].density: missing, required: [1e-9, 1e9] kg/m^3");
}

static size_t pack(const Meniscus__Case *m, uint8_t **ret)
{
    const size_t size = meniscus__case__get_packed_size(m);
    *ret = malloc(size);
    assert_non_null(*ret);
    return meniscus__case__pack(m, *ret);
}

static void survives_printing(const Meniscus__Case *m)
{
    CaseFile *again = NULL;
    MnsError error = {0};
    uint8_t *before, *after;
    char *text = case_message_print(m);
    assert_non_null(text);
    if (case_file_parse("printed", text, strlen(text), &again, &error)) fail_msg("%s\n%s", error.text, text);
    const size_t size = pack(m, &before);
    assert_int_equal(pack(case_file_message(again), &after), size);
    assert_memory_equal(before, after, size);
    free(before);
    free(after);
    free(text);
    case_file_free(again);
}

static void print_and_compare(CaseFile *file)
{
    survives_printing(case_file_message(file));
}

static void every_shipped_case_survives_being_printed(void **state)
{
    (void)state;
    assert_true(shipped_each(print_and_compare) >= 7);
}

static void odd_values_survive_being_printed(void **state)
{
    static const char *const odd[][2] = {
        {"title", "\" \""},
        {"title", "\"\""},
        {"title", "'null'"},
        {"title", "'- a: #b'"},
        {"title", "\"a\\nb\\tc\""},
        {"title", "\"\\u00e4\\u20ac\\U0001F30A\""},
        {"title", "'''\"{}[]&*!|>%@`'"},
        {"end_time", "0.1"},
        {"end_time", "5e-324"},
        {"end_time", "1.7976931348623157e308"},
        {"end_time", "0.30000000000000004"},
        {"gravity", "['x, y', \"-0\"]"},
    };
    for (size_t k = 0; k < sizeof odd / sizeof *odd; k++) {
        Meniscus__Case *m = NULL;
        MnsError error = {0};
        if (case_message_set(*state, odd[k][0], odd[k][1], &m, &error)) fail_msg("%s", error.text);
        survives_printing(m);
        meniscus__case__free_unpacked(m, NULL);
    }
}

static void translate_and_check(CaseFile *file)
{
    MnsCase *c = NULL;
    MnsError error = {0};
    if (case_translate(case_file_message(file), &c, &error)) fail_msg("%s", error.text);
    if (mns_case_check(c, &error)) fail_msg("%s: %s", error.path, error.text);
    mns_case_free(c);
}

static void every_shipped_case_can_be_run(void **state)
{
    (void)state;
    shipped_each(translate_and_check);
}

static void translate_with_twice_the_particles(CaseFile *file)
{
    MnsError error = {0};
    char text[64];
    snprintf(text, sizeof text, "resolution=%g", 2 * case_file_message(file)->resolution);
    if (case_file_set(file, text, &error)) fail_msg("%s", error.text);
    translate_and_check(file);
}

static void resolution_is_the_one_number_to_change(void **state)
{
    (void)state;
    shipped_each(translate_with_twice_the_particles);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_good_message_passes, setup, teardown),
        cmocka_unit_test(an_empty_message_lacks_entries),
        cmocka_unit_test_setup_teardown(numbers_that_are_none_are_refused, setup, teardown),
        cmocka_unit_test_setup_teardown(numbers_out_of_bounds_are_refused, setup, teardown),
        cmocka_unit_test_setup_teardown(unknown_words_are_refused, setup, teardown),
        cmocka_unit_test_setup_teardown(texts_that_no_file_can_hold_are_refused, setup, teardown),
        cmocka_unit_test_setup_teardown(missing_items_are_refused, setup, teardown),
        cmocka_unit_test(every_shipped_case_survives_being_printed),
        cmocka_unit_test_setup_teardown(odd_values_survive_being_printed, setup, teardown),
        cmocka_unit_test(every_shipped_case_can_be_run),
        cmocka_unit_test(resolution_is_the_one_number_to_change),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
