/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a run pauses: conditions know the case's constants and any of its probes, whatever they are called. */
#include "run/breakpoint.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Place {
    MnsCase *c;
    MnsSim *sim;
    Breakpoints *points;
} Place;

static int begin(void **state)
{
    static Place place;
    place = (Place){.c = case_dam_break(2, 8), .points = breakpoints_new()};
    *state = &place;
    return 0;
}

static int end(void **state)
{
    Place *place = *state;
    breakpoints_free(place->points);
    sim_done(place->sim, place->c);
    return 0;
}

/* A probe of the mass of a fluid, which no step changes: 2 for water, 0.008732 for air. */
static void add_probe(Place *place, const char *name, int fluid)
{
    MnsProbe *probe = case_add_probe(place->c, MNS_PROBE_MASS);
    case_set_text(&probe->name, name);
    probe->fluid = fluid;
}

static void add_constant(MnsCase *c, const char *name, const char *value)
{
    c->constants = realloc(c->constants, (c->n_constants + 1) * sizeof *c->constants);
    if (!c->constants) abort();
    MnsConstant *constant = &c->constants[c->n_constants++];
    *constant = (MnsConstant){NULL, NULL};
    case_set_text(&constant->name, name);
    case_set_text(&constant->value, value);
}

static MnsStatus set(const Place *place, const char *condition, MnsError *error)
{
    Breakpoint point = {.name = "here", .t = NAN};
    snprintf(point.condition, sizeof point.condition, "%s", condition);
    return breakpoints_set(place->points, place->c, &point, error);
}

/* Does the condition hold in the simulation, as it is? */
static bool holds(const Place *place, const char *condition)
{
    MnsError error = {.text = ""};
    if (set(place, condition, &error)) fail_msg("%s: %s", condition, error.text);
    return breakpoints_reached(place->points, place->sim, mns_sim_progress(place->sim)) != NULL;
}

static void a_condition_knows_dx_and_constants_made_of_it(void **state)
{
    Place *place = *state;
    add_constant(place->c, "layer", "3*dx");
    add_probe(place, "water", 0);
    place->sim = sim_of(place->c);
    assert_true(holds(place, "water > 1.9 and layer == 3/8 and dx == 1/8"));
    assert_false(holds(place, "water > 1.9 and layer > 0.4"));
}

static void each_variable_has_the_value_of_its_own_probe(void **state)
{
    Place *place = *state;
    add_probe(place, "unused", -1);
    add_probe(place, "mass-of.air", 1);
    add_probe(place, "water", 0);
    place->sim = sim_of(place->c);
    assert_true(holds(place, "water > 1.9 and mass_of_air < 0.1 and step == 0 and t == 0"));
    assert_false(holds(place, "water < 0.1 or mass_of_air > 1.9"));
}

static void probes_of_any_name_leave_conditions_alone(void **state)
{
    Place *place = *state;
    const char *const odd[] = {"1st", "end", "t", "-", ".5", "and"};
    for (size_t k = 0; k < sizeof odd / sizeof *odd; k++) add_probe(place, odd[k], 1);
    add_probe(place, "water", 0);
    place->sim = sim_of(place->c);
    assert_true(holds(place, "water > 1.9 and t == 0 and step == 0"));
}

static void a_probe_with_the_name_of_something_else_has_an_underscore(void **state)
{
    Place *place = *state;
    const char *const odd[] = {"2nd.x", "end", "t"};
    for (size_t k = 0; k < sizeof odd / sizeof *odd; k++) add_probe(place, odd[k], 0);
    place->sim = sim_of(place->c);
    assert_true(holds(place, "_2nd_x > 1.9 and _end > 1.9 and _t > 1.9"));
    assert_false(holds(place, "t > 1.9 or step > 1.9"));
}

static void a_word_that_could_be_two_probes_names_both(void **state)
{
    Place *place = *state;
    MnsError error = {.text = ""};
    add_probe(place, "gauge.1", 0);
    add_probe(place, "gauge-1", 1);
    add_probe(place, "water", 0);
    place->sim = sim_of(place->c);
    assert_int_equal(set(place, "gauge_1 > 1", &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "\"gauge.1\" and \"gauge-1\""));
    assert_true(holds(place, "water > 1.9"));
}

static void there_may_be_more_probes_than_lua_has_variables(void **state)
{
    Place *place = *state;
    char name[16];
    for (int k = 0; k < MNS_MAX_PROBES; k++) {
        snprintf(name, sizeof name, "P%d", k);
        add_probe(place, name, k % 2);
    }
    place->sim = sim_of(place->c);
    assert_true(holds(place, "P254 > 1.9 and P255 < 0.1"));
}

/* No condition has more words than one of single letters. */
static void a_condition_may_be_full_of_words(void **state)
{
    Place *place = *state;
    char condition[BREAKPOINT_TEXT] = "", name[2] = "";
    for (int c = 'A'; c <= 'Z'; c++) {
        name[0] = (char)c;
        add_probe(place, name, 0);
    }
    for (size_t k = 0; k + 1 < sizeof condition; k++) condition[k] = k % 2 ? '+' : (char)('A' + k / 2 % 26);
    memcpy(condition + sizeof condition - 3, ">0", 3);
    place->sim = sim_of(place->c);
    assert_true(holds(place, condition));
}

static void a_condition_is_reached_when_it_becomes_true(void **state)
{
    Place *place = *state;
    place->sim = sim_of(place->c);
    assert_true(holds(place, "t < 1"));
    assert_null(breakpoints_reached(place->points, place->sim, mns_sim_progress(place->sim)));
}

static void cleared_breakpoints_are_gone_and_new_ones_may_come(void **state)
{
    Place *place = *state;
    place->sim = sim_of(place->c);
    assert_true(holds(place, "t < 1"));
    breakpoints_clear(place->points);
    assert_int_equal(breakpoints_remove(place->points, "here", NULL), MNS_E_NOT_FOUND);
    assert_true(holds(place, "t < 1"));
}

static void an_unknown_word_is_refused(void **state)
{
    Place *place = *state;
    MnsError error = {.text = ""};
    assert_int_equal(set(place, "nobody > 1", &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "nobody"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_condition_knows_dx_and_constants_made_of_it, begin, end),
        cmocka_unit_test_setup_teardown(each_variable_has_the_value_of_its_own_probe, begin, end),
        cmocka_unit_test_setup_teardown(probes_of_any_name_leave_conditions_alone, begin, end),
        cmocka_unit_test_setup_teardown(a_probe_with_the_name_of_something_else_has_an_underscore, begin, end),
        cmocka_unit_test_setup_teardown(a_word_that_could_be_two_probes_names_both, begin, end),
        cmocka_unit_test_setup_teardown(there_may_be_more_probes_than_lua_has_variables, begin, end),
        cmocka_unit_test_setup_teardown(a_condition_may_be_full_of_words, begin, end),
        cmocka_unit_test_setup_teardown(a_condition_is_reached_when_it_becomes_true, begin, end),
        cmocka_unit_test_setup_teardown(cleared_breakpoints_are_gone_and_new_ones_may_come, begin, end),
        cmocka_unit_test_setup_teardown(an_unknown_word_is_refused, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
