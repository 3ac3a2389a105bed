/* SPDX-License-Identifier: BSD-3-Clause */
/* Reading case files: what is wrong is named with its place, what was found and what is allowed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/case/file.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A whole case but for what `more` adds at its end, which begins at line 5. */
#define HEAD                                                                                                           \
    "dimensions: 2\n"                                                                                                  \
    "resolution: 10\n"                                                                                                 \
    "domain: {min: [0, 0], max: [1, 1]}\n"                                                                             \
    "end_time: 1\n"
#define FLUIDS "fluids: [{name: water, density: 1, sound_speed: 10}]\n"

static MnsStatus parse(const char *text, MnsError *error)
{
    CaseFile *file = NULL;
    const MnsStatus status = case_file_parse("a.yaml", text, strlen(text), &file, error);
    if (!status) case_file_free(file);
    return status;
}

static void complains(const char *text, const char *expected)
{
    MnsError error = {0};
    assert_int_equal(parse(text, &error), MNS_E_INVALID);
    assert_string_equal(error.text, expected);
    assert_int_equal(error.status, MNS_E_INVALID);
}

static void complains_with(const char *text, const char *part)
{
    MnsError error = {0};
    assert_int_equal(parse(text, &error), MNS_E_INVALID);
    assert_memory_equal(error.text, "a.yaml:", 7);
    if (!strstr(error.text, part)) fail_msg("\"%s\" is not in \"%s\"", part, error.text);
}

static void a_small_case_is_read(void **state)
{
    (void)state;
    static const char text[] =
        HEAD FLUIDS "gravity: [0, -9.81]\nscheme: {kernel: quintic-spline}\nthreads: 3\n"
                    "walls: [{name: w, shape: [{outside: true, half_space: {point: [0, 0], normal: "
                    "[0, 1]}}]}]\n";
    CaseFile *file = NULL;
    assert_int_equal(case_file_parse("a.yaml", text, sizeof text - 1, &file, NULL), MNS_OK);
    const Meniscus__Case *m = case_file_message(file);
    assert_int_equal(m->dimensions, 2);
    assert_true(m->fluids[0]->density == 1);
    assert_string_equal(m->gravity[1], "-9.81");
    assert_int_equal(m->scheme->kernel, MENISCUS__KERNEL__QUINTIC_SPLINE);
    assert_int_equal(m->threads, 3);
    assert_true(m->walls[0]->shape[0]->outside);
    assert_int_equal(m->walls[0]->shape[0]->primitive_case, MENISCUS__PART__PRIMITIVE_HALF_SPACE);
    assert_string_equal(m->fluids[0]->pressure, "0"); /* a default */
    case_file_free(file);
}

static void a_choice_by_its_name_alone_has_all_its_defaults(void **state)
{
    (void)state;
    CaseFile *file = NULL;
    static const char text[] = HEAD FLUIDS "scheme: interfacial\n";
    assert_int_equal(case_file_parse("a.yaml", text, sizeof text - 1, &file, NULL), MNS_OK);
    const Meniscus__Scheme *scheme = case_file_message(file)->scheme;
    assert_int_equal(scheme->method_case, MENISCUS__SCHEME__METHOD_INTERFACIAL);
    assert_false(scheme->has_kernel);
    case_file_free(file);
    complains_with(HEAD FLUIDS "scheme: kernel\n",
                   "6:9: scheme: found \"kernel\", allowed: a mapping"); /* is no choice */
}

static void a_value_out_of_bounds_is_named_with_what_is_allowed(void **state)
{
    (void)state;
    complains(HEAD "fluids:\n  - {name: water, density: 1, sound_speed: 10}\n  - name: air\n    density: -1\n"
                   "    sound_speed: 10\n",
              "a.yaml:8:14: fluids[1].density: found \"-1\", allowed: [1e-9, 1e9] kg/m^3");
    complains(HEAD "fluids: [{name: a, density: 0, sound_speed: 1}]\n",
              "a.yaml:5:29: fluids[0].density: found \"0\", allowed: [1e-9, 1e9] kg/m^3");
    complains(HEAD FLUIDS "threads: 1025\n",
              "a.yaml:6:10: threads: found \"1025\", allowed: whole number in [0, 1024]");
}

static void an_infinite_number_is_out_of_bounds(void **state)
{
    (void)state;
    complains(HEAD FLUIDS "reference_length: .inf\n",
              "a.yaml:6:19: reference_length: found \".inf\", allowed: (0, inf) m");
    complains(HEAD FLUIDS "reference_length: 1e999\n",
              "a.yaml:6:19: reference_length: found \".inf\", allowed: (0, inf) m");
    complains("dimensions: 2\nresolution: 10\ndomain:\n  min: [0, -.inf]\n  max: [1, 1]\nend_time: 1\n" FLUIDS,
              "a.yaml:4:12: domain.min[1]: found \"-.inf\", allowed: any finite number m");
}

static void what_is_not_a_number_is_refused_whole(void **state)
{
    (void)state;
    static const char *const wrong[] = {"nan", ".nan", "0.1abc", "1,5", "0x10",  "1e",
                                        "e5",  "+",    ".",      "1 2", "1_000", "true"};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        char text[400], expected[200];
        snprintf(text, sizeof text, HEAD FLUIDS "reference_length: %s\n", wrong[k]);
        snprintf(expected, sizeof expected,
                 "a.yaml:6:19: reference_length: found \"%s\", which is not a number, allowed: (0, inf) m", wrong[k]);
        complains(text, expected);
    }
    complains(HEAD FLUIDS "reference_length: '1'\n",
              "a.yaml:6:19: reference_length: found \"1\" in quotes, which is not a number, allowed: (0, inf) m");
}

static void whole_numbers_neither_wrap_nor_round(void **state)
{
    (void)state;
    complains(HEAD FLUIDS "threads: 4294967297\n", "a.yaml:6:10: threads: found \"4294967297\", which is not a whole "
                                                   "number, allowed: whole number in [0, 1024]");
    complains(HEAD FLUIDS "threads: 1.5\n",
              "a.yaml:6:10: threads: found \"1.5\", which is not a whole number, allowed: whole number in [0, 1024]");
    complains(HEAD FLUIDS "threads: -1\n",
              "a.yaml:6:10: threads: found \"-1\", which is not a whole number, allowed: whole number in [0, 1024]");
}

static void only_true_and_false_are_truth_values(void **state)
{
    (void)state;
    complains(HEAD FLUIDS "output: {walls: yes}\n",
              "a.yaml:6:17: output.walls: found \"yes\", which is not a truth value, allowed: true, false");
}

static void an_unknown_word_gets_a_suggestion(void **state)
{
    (void)state;
    complains(HEAD FLUIDS "scheme: {kernel: wendland_c2}\n",
              "a.yaml:6:18: scheme.kernel: found \"wendland_c2\", did you mean \"wendland-c2\"? Allowed: wendland-c2, "
              "truncated-gaussian, quintic-spline");
}

static void an_unknown_entry_gets_a_suggestion_and_the_list(void **state)
{
    (void)state;
    complains(
        HEAD "fluids:\n  - name: water\n    densty: 1\n",
        "a.yaml:7:5: fluids[0]: unknown entry \"densty\", did you mean \"density\"? Allowed: name, density, viscosity, "
        "sound_speed, shape, velocity, pressure, density_method, exponent");
    complains(HEAD FLUIDS "output: {xyzzy: 1}\n",
              "a.yaml:6:10: output: unknown entry \"xyzzy\", allowed: probe_interval, snapshot_interval, "
              "checkpoint_interval, checkpoint_wall_interval, checkpoints_kept, fields, walls");
}

static void an_entry_may_be_there_once(void **state)
{
    (void)state;
    complains(HEAD FLUIDS "end_time: 2\n", "a.yaml:6:1: the entry \"end_time\" is there twice: remove one");
}

static void members_of_a_choice_exclude_each_other(void **state)
{
    (void)state;
    complains(HEAD "fluids:\n  - name: water\n    shape:\n      - box: {min: [0, 0], max: [1, 1]}\n"
                   "        ball: {centre: [0, 0], radius: 1}\n",
              "a.yaml:9:9: fluids[0].shape[0]: \"box\" and \"ball\" exclude each other: remove one");
}

static void a_missing_entry_is_named_where_it_should_be(void **state)
{
    (void)state;
    complains("# A comment first.\ndimensions: 2\n" FLUIDS "domain: {min: [0, 0], max: [1, 1]}\nend_time: 1\n",
              "a.yaml:2:1: resolution: missing, required: [1, 1e6]");
    complains(HEAD "fluids:\n  - density: 1\n    sound_speed: 2\n",
              "a.yaml:6:5: fluids[0].name: missing, required: a text");
    complains(HEAD "fluids: []\n", "a.yaml:5:9: fluids: missing, required: a list of at least one: a mapping");
    complains(HEAD FLUIDS "walls: [{name: w, shape: [{outside: true}]}]\n",
              "a.yaml:6:27: walls[0].shape[0]: one of box, ball, cylinder, plate, half_space, formula is required and "
              "none is "
              "there");
}

static void a_list_of_the_wrong_length_is_refused(void **state)
{
    (void)state;
    complains("dimensions: 2\nresolution: 10\ndomain: {min: [0], max: [1, 1]}\nend_time: 1\n" FLUIDS,
              "a.yaml:3:15: domain.min: found a list of 1, allowed: a list of 2 to 3");
}

static void a_value_of_the_wrong_kind_is_refused(void **state)
{
    (void)state;
    complains(
        HEAD FLUIDS "gravity: -9.81\n",
        "a.yaml:6:10: gravity: found \"-9.81\", allowed: a list, as in [a, b] or lines that begin with \"- \", of a "
        "number or a formula of t");
    complains(HEAD FLUIDS "threads: [1]\n", "a.yaml:6:10: threads: found a list, allowed: whole number in [0, 1024]");
    complains(HEAD FLUIDS "title: {a: b}\n", "a.yaml:6:8: title: found a mapping, allowed: a text");
    complains(HEAD FLUIDS "limits: 3\n", "a.yaml:6:9: limits: found \"3\", allowed: a mapping ({} for an empty one) of "
                                         "entries time_step_floor, density_min, density_max");
    complains(HEAD FLUIDS "title:\n", "a.yaml:6:7: title: found nothing, allowed: a text");
    complains(HEAD FLUIDS "? [a]\n: 1\n", "a.yaml:6:3: found a list, allowed: the name of an entry");
}

static void text_that_is_no_case_is_refused(void **state)
{
    (void)state;
    complains("", "a.yaml:1:1: there is nothing here");
    complains("# nothing\n", "a.yaml:2:1: there is nothing here");
    complains("- a\n", "a.yaml:1:1: found a list, allowed: a mapping, with lines such as \"dimensions: 2\"");
    complains("just words",
              "a.yaml:1:1: found \"just words\", allowed: a mapping, with lines such as \"dimensions: 2\"");
    complains(HEAD FLUIDS "---\ndimensions: 2\n", "a.yaml:6:1: a second document begins here: a case is one document");
}

static void what_is_not_yaml_is_refused_with_its_place(void **state)
{
    (void)state;
    complains_with("dimensions: 2\ndomain: {min: [0, 0\n", "a.yaml:3:1: domain.min: this is not YAML: ");
    complains_with("dimensions: 2\n\tresolution: 3\n", "a.yaml:2:1: ");
    complains_with("title: a\ntitel\xff: 1\n", "a.yaml:2:6: this is not YAML: ");
    complains_with("title: a\ndomain:\n\tmin: [0, 0]\n",
                   "a.yaml:3:1: domain: there is a tab, and YAML allows none for indentation: write spaces");
    complains_with("title: 'never closed\n", "this is not YAML: ");
}

static void anchors_aliases_and_tags_are_refused(void **state)
{
    (void)state;
    complains("dimensions: &d 2\n",
              "a.yaml:1:13: dimensions: anchors (&), aliases (*) and tags (!) are not used in case "
              "files: write the value itself");
    complains_with("dimensions: *d\n", "a.yaml:1:13: dimensions: anchors");
    complains_with("dimensions: !!int 2\n", "a.yaml:1:13: dimensions: anchors");
    complains_with("domain: &d {min: [0, 0]}\n", "a.yaml:1:9: domain: anchors");
    complains_with("<<: *d\n", "a.yaml:1:1: unknown entry \"<<\"");
}

static void control_characters_are_refused(void **state)
{
    (void)state;
    complains(HEAD FLUIDS "title: \"a\\x01b\"\n",
              "a.yaml:6:8: title: found a text that is not UTF-8 or has control characters "
              "in it: remove them");
    complains(HEAD FLUIDS "title: \"a\\0b\"\n", "a.yaml:6:8: title: the text has a zero byte in it: remove it");
    complains_with(HEAD FLUIDS "\"end\\0_time\": 1\n", "unknown entry \"end\"");
    complains_with(HEAD FLUIDS "\"\\e[31m\": 1\n", "unknown entry \"?[31m\"");
}

static void deep_nesting_and_huge_files_end_soon(void **state)
{
    (void)state;
    enum { SIZE = (16 << 20) + 1 };
    MnsError error = {0};
    CaseFile *file = NULL;
    char *text = malloc(SIZE);
    assert_non_null(text);
    memset(text, '[', SIZE);
    memcpy(text, "domain: ", 8);
    assert_int_equal(case_file_parse("a.yaml", text, 100000, &file, &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "a.yaml:1:9: domain: found a list"));
    memset(text, '#', SIZE);
    assert_int_equal(case_file_parse("a.yaml", text, SIZE, &file, &error), MNS_E_INVALID);
    assert_string_equal(error.text, "a.yaml:1:1: the text is 16777217 bytes long, allowed: 16777216");
    free(text);
}

static void a_missing_file_and_a_folder_are_named(void **state)
{
    (void)state;
    MnsError error = {0};
    CaseFile *file = NULL;
    assert_int_equal(case_file_read("/nowhere/a.yaml", &file, &error), MNS_E_NOT_FOUND);
    assert_string_equal(error.text,
                        "/nowhere/a.yaml: cannot open the case file: No such file or directory; check the path, each "
                        "directory of which must be there");
    assert_int_equal(case_file_read("/", &file, &error), MNS_E_INVALID);
    assert_string_equal(error.text, "/: a case is a file, and this is a directory");
    char pipe[64];
    snprintf(pipe, sizeof pipe, "/tmp/mns-pipe-%d", (int)getpid());
    assert_int_equal(mkfifo(pipe, 0600), 0);
    const MnsStatus status = case_file_read(pipe, &file, &error); /* and does not wait for a writer */
    unlink(pipe);
    assert_int_equal(status, MNS_E_INVALID);
    assert_non_null(strstr(error.text, pipe));
}

static void later_complaints_find_the_nearest_entry(void **state)
{
    (void)state;
    static const char text[] = HEAD "fluids:\n  - name: water\n    density: 1\n    sound_speed: 10\n";
    MnsError error;
    CaseFile *file = NULL;
    assert_int_equal(case_file_parse("a.yaml", text, sizeof text - 1, &file, NULL), MNS_OK);
    mns_fail_at(&error, MNS_E_INVALID, "fluids[0].density", "too light");
    case_file_locate(file, &error);
    assert_string_equal(error.text, "a.yaml:7:14: fluids[0].density: too light");
    case_file_locate(file, &error); /* a second time does nothing */
    assert_string_equal(error.text, "a.yaml:7:14: fluids[0].density: too light");
    mns_fail_at(&error, MNS_E_INVALID, "fluids[0].shape[3].box.min", "fluids[0].shape[3].box.min: odd");
    case_file_locate(file, &error);
    assert_string_equal(error.text, "a.yaml:6:5: fluids[0].shape[3].box.min: odd");
    mns_fail(&error, MNS_E_LIMIT, "too much");
    case_file_locate(file, &error);
    assert_string_equal(error.text, "a.yaml:1:1: too much");
    case_file_free(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_small_case_is_read),
        cmocka_unit_test(a_choice_by_its_name_alone_has_all_its_defaults),
        cmocka_unit_test(a_value_out_of_bounds_is_named_with_what_is_allowed),
        cmocka_unit_test(an_infinite_number_is_out_of_bounds),
        cmocka_unit_test(what_is_not_a_number_is_refused_whole),
        cmocka_unit_test(whole_numbers_neither_wrap_nor_round),
        cmocka_unit_test(only_true_and_false_are_truth_values),
        cmocka_unit_test(an_unknown_word_gets_a_suggestion),
        cmocka_unit_test(an_unknown_entry_gets_a_suggestion_and_the_list),
        cmocka_unit_test(an_entry_may_be_there_once),
        cmocka_unit_test(members_of_a_choice_exclude_each_other),
        cmocka_unit_test(a_missing_entry_is_named_where_it_should_be),
        cmocka_unit_test(a_list_of_the_wrong_length_is_refused),
        cmocka_unit_test(a_value_of_the_wrong_kind_is_refused),
        cmocka_unit_test(text_that_is_no_case_is_refused),
        cmocka_unit_test(what_is_not_yaml_is_refused_with_its_place),
        cmocka_unit_test(anchors_aliases_and_tags_are_refused),
        cmocka_unit_test(control_characters_are_refused),
        cmocka_unit_test(deep_nesting_and_huge_files_end_soon),
        cmocka_unit_test(a_missing_file_and_a_folder_are_named),
        cmocka_unit_test(later_complaints_find_the_nearest_entry),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
