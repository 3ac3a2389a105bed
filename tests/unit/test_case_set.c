/* SPDX-License-Identifier: BSD-3-Clause */
/* Entries by their paths: read, overridden, steered. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/case/file.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char small[] = "dimensions: 2\n"
                            "resolution: 10\n"
                            "domain: {min: [0, 0], max: [1, 1]}\n"
                            "end_time: 1\n"
                            "fluids:\n"
                            "  - {name: water, density: 1000, sound_speed: 10}\n"
                            "  - {name: air, density: 1, sound_speed: 10}\n"
                            "walls:\n"
                            "  - name: tank\n"
                            "    shape: [{box: {min: [0, 0], max: [1, 1]}}]\n"
                            "    motion: {sine: {amplitude: [1, 0], frequency: 2}}\n";

static int setup(void **state)
{
    return case_file_parse("a.yaml", small, sizeof small - 1, (CaseFile **)state, NULL) != MNS_OK;
}

static int teardown(void **state)
{
    case_file_free(*state);
    return 0;
}

static void sets(CaseFile *file, const char *assignment)
{
    MnsError error = {0};
    if (case_file_set(file, assignment, &error)) fail_msg("%s: %s", assignment, error.text);
}

static void refuses(CaseFile *file, const char *assignment, const char *expected)
{
    MnsError error = {0};
    char *before = case_message_print(case_file_message(file));
    assert_int_not_equal(case_file_set(file, assignment, &error), MNS_OK);
    assert_string_equal(error.text, expected);
    char *after = case_message_print(case_file_message(file));
    assert_string_equal(before, after); /* a refused set changes nothing */
    free(before);
    free(after);
}

static void is(const CaseFile *file, const char *path, const char *expected)
{
    char *text = NULL;
    MnsError error = {0};
    if (case_message_get(case_file_message(file), path, &text, NULL, &error)) fail_msg("%s", error.text);
    assert_string_equal(text, expected);
    free(text);
}

static void values_are_got_with_their_unit(void **state)
{
    char *text;
    const char *unit;
    const Meniscus__Case *m = case_file_message(*state);
    assert_int_equal(case_message_get(m, "fluids[1].density", &text, &unit, NULL), MNS_OK);
    assert_string_equal(text, "1");
    assert_string_equal(unit, "kg/m^3");
    free(text);
    is(*state, "domain.max", "[1, 1]");
    is(*state, "domain.max[1]", "1");
    is(*state, "fluids[0]", "{name: water, density: 1000, sound_speed: 10}");
    is(*state, "walls[0].motion.sine.amplitude", "[1, 0]");
}

static void what_is_not_there_has_its_default(void **state)
{
    is(*state, "scheme.skin", "0.3");
    is(*state, "fluids[0].density_method", "automatic");
    is(*state, "scheme.riemann.guard", "0.25");
    is(*state, "output.walls", "true");
    is(*state, "fluids[0].pressure", "0");
    is(*state, "gravity", "[]");
    is(*state, "title", "null");
    is(*state, "output", "{}");
}

static void values_are_set_by_path(void **state)
{
    CaseFile *file = *state;
    sets(file, "resolution=40.5");
    is(file, "resolution", "40.5");
    sets(file, "fluids[1].density=2");
    is(file, "fluids[1].density", "2");
    sets(file, "gravity=[0, -9.81]");
    is(file, "gravity", "[0, -9.81]");
    sets(file, "gravity[1]=-sin(t) == 0 and 1 or 2");
    is(file, "gravity[1]", "-sin(t) == 0 and 1 or 2");
    sets(file, "scheme.riemann.limiter=2"); /* makes what is on the way */
    is(file, "scheme", "{riemann: {limiter: 2}}");
    sets(file, "title=\"a\\nb\"");
    is(file, "title", "\"a\\nb\"");
    sets(file, "domain.periodic=[x]");
    is(file, "domain", "{min: [0, 0], max: [1, 1], periodic: [x]}");
}

static void the_index_after_the_last_appends(void **state)
{
    CaseFile *file = *state;
    sets(file, "fluids[2]={name: oil, density: 800, sound_speed: 10}");
    is(file, "fluids[2].name", "oil");
    sets(file, "probes[0]={name: e, kinetic_energy: {}}");
    is(file, "probes", "[{name: e, kinetic_energy: {}}]");
    sets(file, "output.fields[0]=pressure");
    is(file, "output.fields", "[pressure]");
    refuses(file, "fluids[4].density=1",
            "--set fluids[4].density=1: no such item, allowed: 0 to 3, where 3 appends one");
}

static void a_member_of_a_choice_replaces_the_other(void **state)
{
    sets(*state, "walls[0].motion.one_minus_cosine={amplitude: [2, 0], frequency: 3}");
    is(*state, "walls[0].motion", "{one_minus_cosine: {amplitude: [2, 0], frequency: 3}}");
    sets(*state, "walls[0].shape[0]={ball: {centre: [0, 0], radius: 1}}");
    is(*state, "walls[0].shape", "[{ball: {centre: [0, 0], radius: 1}}]");
    sets(*state, "scheme={smoothing: 1.4, riemann: {limiter: 2}}");
    sets(*state, "scheme.interfacial={}"); /* what is beside the choice stays */
    is(*state, "scheme", "{smoothing: 1.4, interfacial: {}}");
    sets(*state, "scheme={riemann: {}}");
    is(*state, "scheme", "{riemann: {}}");
    refuses(*state, "scheme.interfacial.delta=1", /* nobody changes the scheme by an option of it */
            "--set scheme.interfacial.delta=1: the case has \"riemann\", which excludes "
            "\"interfacial\": set \"interfacial\" as a whole to have it instead");
    sets(*state, "scheme.interfacial={delta: 1}");
    sets(*state, "scheme.interfacial.delta=2");
    is(*state, "scheme", "{interfacial: {delta: 2}}");
    sets(*state, "scheme={}");
    refuses(*state, "scheme.interfacial.delta=1", /* riemann is what no choice means */
            "--set scheme.interfacial.delta=1: the case has \"riemann\", which excludes "
            "\"interfacial\": set \"interfacial\" as a whole to have it instead");
    sets(*state, "scheme={riemann: {}}");
    refuses(
        *state, "scheme={riemann: {}, interfacial: {}}",
        "--set scheme={riemann: {}, interfacial: {}}: \"riemann\" and \"interfacial\" exclude each other: remove one");
}

static void wrong_assignments_are_refused(void **state)
{
    CaseFile *file = *state;
    refuses(file, "resolution", "--set resolution: write PATH=VALUE, as in resolution=40");
    refuses(file, "=1", "--set =1: write PATH=VALUE, as in resolution=40");
    refuses(file, "resolution=", "--set resolution=: there is nothing here");
    refuses(file, "resolution=fine", "--set resolution=fine: found \"fine\", which is not a number, allowed: [1, 1e6]");
    refuses(file, "fluids[1].density=-1", "--set fluids[1].density=-1: found \"-1\", allowed: [1e-9, 1e9] kg/m^3");
    refuses(file, "fluids[2]={name: oil, sound_speed: 10}",
            "--set fluids[2]={name: oil, sound_speed: 10}: fluids[2].density: missing, required: [1e-9, 1e9] kg/m^3");
    refuses(file, "domain.min=[0]", "--set domain.min=[0]: found a list of 1, allowed: a list of 2 to 3");
    refuses(file, "gravity=[0",
            "--set gravity=[0: this is not YAML: while parsing a flow sequence, did not find expected ',' or "
            "']'");
}

static void wrong_paths_are_refused_with_a_suggestion(void **state)
{
    CaseFile *file = *state;
    refuses(file, "fluids[1].densty=2",
            "--set fluids[1].densty=2: unknown entry \"densty\", did you mean \"density\"? Allowed: name, density, "
            "viscosity, "
            "sound_speed, shape, velocity, pressure, density_method, exponent");
    refuses(file, "cfl=0.2", "--set cfl=0.2: unknown entry \"cfl\", did you mean \"scheme.cfl\"?");
    refuses(file, "guard=1", /* of several schemes */
            "--set guard=1: unknown entry \"guard\", allowed: title, dimensions, reference_length, resolution, domain, "
            "constants, gravity, fluids, walls, scheme, end_time, threads, probes, output, limits, interfaces");
    refuses(file, "fluids.density=2", "--set fluids.density=2: \"fluids\" is a list, name one of its items: fluids[0]");
    refuses(file, "resolution[0]=2", "--set resolution[0]=2: \"resolution\" is not a list, leave out the index");
    refuses(file, "resolution.x=2",
            "--set resolution.x=2: \"resolution\" is a single value, there are no entries in it");
    static const char *const malformed[] = {".a=1",
                                            "[0]=1",
                                            "fluids[=1",
                                            "fluids[-1]=1",
                                            "fluids[0]name=1",
                                            "fluids[0]..name=1",
                                            "fluids[99999999999999999999]=1",
                                            "fluids.=1"};
    for (size_t k = 0; k < sizeof malformed / sizeof *malformed; k++) {
        MnsError error = {0};
        assert_int_equal(case_file_set(file, malformed[k], &error), MNS_E_NOT_FOUND);
        assert_non_null(strstr(error.text, "is not a path: write names joined by dots"));
    }
}

/* As the rest of a complaint has to find room too. */
static void long_values_are_cut_in_complaints(void **state)
{
    MnsError error = {0};
    assert_int_equal(case_file_set(*state, "fluids[1].density=1.00000000000000000000000000000000000000000000x", &error),
                     MNS_E_INVALID);
    assert_non_null(strstr(error.text, "--set fluids[1].density=1.00000000000000000000000000000000000000...: found"));
}

static void a_path_longer_than_any_entry_is_refused(void **state)
{
    char text[4000];
    MnsError error = {0};
    memset(text, 'a', sizeof text);
    memcpy(text + sizeof text - 3, "=1", 3);
    assert_int_equal(case_file_set(*state, text, &error), MNS_E_NOT_FOUND);
    assert_non_null(strstr(error.text, "unknown entry \"aaaa"));
}

static void later_complaints_about_what_was_set_name_the_set(void **state)
{
    MnsError error;
    CaseFile *file = *state;
    sets(file, "fluids[1].density=3");
    sets(file, "fluids[0]={name: oil, density: 5, sound_speed: 1}");
    mns_fail_at(&error, MNS_E_INVALID, "fluids[1].density", "too light");
    case_file_locate(file, &error);
    assert_string_equal(error.text, "--set fluids[1].density=3: too light");
    mns_fail_at(&error, MNS_E_INVALID, "fluids[0].density", "too light");
    case_file_locate(file, &error);
    assert_string_equal(error.text,
                        "--set fluids[0]={name: oil, density: 5, sound_speed: 1}: fluids[0].density: too light");
    sets(file, "fluids[1].density=4"); /* the newest counts */
    mns_fail_at(&error, MNS_E_INVALID, "fluids[1].density", "too light");
    case_file_locate(file, &error);
    assert_string_equal(error.text, "--set fluids[1].density=4: too light");
    mns_fail_at(&error, MNS_E_INVALID, "fluids[1].name", "too long");
    case_file_locate(file, &error);
    assert_string_equal(error.text, "a.yaml:7:12: fluids[1].name: too long");
    mns_fail_at(&error, MNS_E_INVALID, "fluids", "too many");
    case_file_locate(file, &error);
    assert_string_equal(error.text, "a.yaml:6:3: fluids: too many");
}

static Meniscus__Case *changed(const CaseFile *file, const char *path, const char *yaml)
{
    Meniscus__Case *ret = NULL;
    MnsError error = {0};
    if (case_message_set(case_file_message(file), path, yaml, &ret, &error)) fail_msg("%s", error.text);
    return ret;
}

/* What came from a socket has no room to spare: with the address sanitizer, or in a list of three. */
static void lists_of_unpacked_messages_grow_as_well(void **state)
{
    CaseFile *file = *state;
    sets(file, "gravity=[0, -1]");
    Meniscus__Case *m = changed(file, "gravity[2]", "3");
    for (int k = 0; k < 40; k++) {
        char path[32], value[64];
        snprintf(path, sizeof path, "probes[%d]", k);
        snprintf(value, sizeof value, "{name: p%d, kinetic_energy: {}}", k);
        Meniscus__Case *more = NULL;
        assert_int_equal(case_message_set(m, path, value, &more, NULL), MNS_OK);
        meniscus__case__free_unpacked(m, NULL);
        m = more;
    }
    assert_int_equal(m->n_probes, 40);
    assert_string_equal(m->probes[39]->name, "p39");
    assert_string_equal(m->gravity[2], "3");
    meniscus__case__free_unpacked(m, NULL);
}

static void only_steerable_entries_may_differ(void **state)
{
    static const char *const free_to_change[][2] = {
        {"gravity", "[0, -1]"},           {"end_time", "3"},      {"threads", "2"},
        {"scheme.riemann.limiter", "1"},  {"scheme.cfl", "0.1"},  {"output.probe_interval", "1"},
        {"scheme.riemann", "{guard: 0}"}, {"scheme.skin", "0.3"}, /* as it is by default */
        {"fluids[0].pressure", "0"},
    };
    const Meniscus__Case *a = case_file_message(*state);
    for (size_t k = 0; k < sizeof free_to_change / sizeof *free_to_change; k++) {
        Meniscus__Case *b = changed(*state, free_to_change[k][0], free_to_change[k][1]);
        assert_int_equal(case_message_steerable(a, b, NULL), MNS_OK);
        assert_int_equal(case_message_steerable(b, a, NULL), MNS_OK);
        meniscus__case__free_unpacked(b, NULL);
    }
}

static void other_differences_are_named(void **state)
{
    static const char *const fixed[][3] = {
        {"resolution", "20", "resolution"},
        {"fluids[1].density", "2", "fluids[1].density"},
        {"fluids[1].pressure", "1", "fluids[1].pressure"},
        {"fluids[2]", "{name: oil, density: 800, sound_speed: 10}", "fluids"},
        {"domain.max[1]", "2", "domain.max[1]"},
        {"scheme.smoothing", "2", "scheme.smoothing"},
        {"walls[0].slip", "none", "walls[0].slip"},
        {"walls[0].motion.sine.phase", "1", "walls[0].motion.sine.phase"},
        {"walls[0].motion.one_minus_cosine", "{amplitude: [1, 0], frequency: 2}", "walls[0].motion.sine"},
        {"title", "words", "title"},
        {"output.walls", "false", "output.walls"},
    };
    const Meniscus__Case *a = case_file_message(*state);
    for (size_t k = 0; k < sizeof fixed / sizeof *fixed; k++) {
        MnsError error = {0};
        Meniscus__Case *b = changed(*state, fixed[k][0], fixed[k][1]);
        assert_int_equal(case_message_steerable(a, b, &error), MNS_E_INVALID);
        assert_string_equal(error.path, fixed[k][2]);
        assert_int_equal(case_message_steerable(b, a, NULL), MNS_E_INVALID);
        meniscus__case__free_unpacked(b, NULL);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(values_are_got_with_their_unit, setup, teardown),
        cmocka_unit_test_setup_teardown(what_is_not_there_has_its_default, setup, teardown),
        cmocka_unit_test_setup_teardown(values_are_set_by_path, setup, teardown),
        cmocka_unit_test_setup_teardown(the_index_after_the_last_appends, setup, teardown),
        cmocka_unit_test_setup_teardown(lists_of_unpacked_messages_grow_as_well, setup, teardown),
        cmocka_unit_test_setup_teardown(a_member_of_a_choice_replaces_the_other, setup, teardown),
        cmocka_unit_test_setup_teardown(wrong_assignments_are_refused, setup, teardown),
        cmocka_unit_test_setup_teardown(wrong_paths_are_refused_with_a_suggestion, setup, teardown),
        cmocka_unit_test_setup_teardown(long_values_are_cut_in_complaints, setup, teardown),
        cmocka_unit_test_setup_teardown(a_path_longer_than_any_entry_is_refused, setup, teardown),
        cmocka_unit_test_setup_teardown(later_complaints_about_what_was_set_name_the_set, setup, teardown),
        cmocka_unit_test_setup_teardown(only_steerable_entries_may_differ, setup, teardown),
        cmocka_unit_test_setup_teardown(other_differences_are_named, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
