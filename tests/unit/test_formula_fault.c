/* SPDX-License-Identifier: BSD-3-Clause */
/* A formula that gives a number here and a truth value there, or no number at all, ends the run with its entry, before the step that would
 * need it: it is not taken for 1 or 0, what comes of it is not blamed, and the run can go on with another. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <string.h>

/* A number where it is tried, at 0.5, and at 0; true between. */
static const char SWITCHING[] = "t > 0.02 and (t < 0.3) or -1";

/* Step up to t, beyond which the first step must fail, and change nothing. */
static void assert_fails_at(MnsSim *sim, double t, const char *path, const char *why)
{
    MnsError error = {0};
    MnsStatus status = MNS_OK;
    while (!status && mns_sim_progress(sim).t < 2 * t) status = mns_sim_step(sim, INFINITY, &error);
    assert_int_equal(status, MNS_E_INVALID);
    assert_string_equal(error.path, path);
    if (!strstr(error.text, why) || strncmp(error.text, path, strlen(path)) != 0) fail_msg("\"%s\"", error.text);
    const MnsProgress progress = mns_sim_progress(sim);
    const uint64_t hash = mns_sim_hash(sim);
    assert_less(progress.t, t + 1e-12);
    assert_less(t, progress.t + 2 * progress.dt);
    assert_int_equal(mns_sim_step(sim, INFINITY, NULL), MNS_E_INVALID); /* and so it stays */
    assert_true(mns_sim_hash(sim) == hash && mns_sim_progress(sim).step == progress.step);
}

static void gravity_that_turns_into_a_truth_ends_the_run(void **state)
{
    (void)state;
    MnsCase *c = case_dam_break(2, 10);
    c->max[0] = c->walls[0].shape.parts[0].b[0] = 5.4;
    case_set_text(&c->gravity[1], SWITCHING);
    MnsSim *sim = sim_of(c);
    assert_fails_at(sim, 0.02, "gravity[1]", "true or false there");
    mns_sim_free(sim);
    case_set_text(&c->gravity[1], "-1/(t < 0.02 and 1 or 0)");
    case_set_text(&c->gravity[0], "0");
    MnsError error = {0};
    assert_int_equal(mns_sim_new(c, &sim, &error), MNS_OK);
    assert_fails_at(sim, 0.02, "gravity[1]", "no finite number");
    mns_sim_free(sim);
    case_set_text(&c->gravity[1], "1/t");
    assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
    assert_string_equal(error.path, "gravity[1]");
    mns_case_free(c);
}

/* Nothing is viscous here, so that nobody would even look at the lid's velocity. */
static void surface_that_turns_into_a_truth_ends_the_run(void **state)
{
    (void)state;
    MnsCase *c = case_dam_break(2, 10);
    c->max[0] = c->walls[0].shape.parts[0].b[0] = 5.4;
    case_set_text(&c->walls[0].surface_velocity[0], SWITCHING);
    MnsSim *sim = sim_of(c);
    assert_fails_at(sim, 0.02, "walls[0].surface_velocity[0]", "true or false there");
    sim_done(sim, c);
}

/* The same bits as of a run that had the other formula from the beginning, as long as it gave the same. */
static void run_goes_on_with_another_gravity(const char *scheme)
{
    MnsError error = {0};
    MnsCase *c = case_periodic(2, 10), *other = case_periodic(2, 10), *all = case_periodic(2, 10);
    c->scheme.name = other->scheme.name = all->scheme.name = scheme;
    case_set_text(&c->gravity[1], "sqrt(0.02 - t)/0 > 1 and -1 or 0/0");
    case_set_text(&other->gravity[1], "-1");
    case_set_text(&all->gravity[1], "-1");
    MnsSim *sim = sim_of(c), *whole = sim_of(all);
    assert_fails_at(sim, 0.02, "gravity[1]", "no finite number there. Set another, and the run can go on");
    assert_int_equal(mns_sim_steer(sim, other, &error), MNS_OK);
    while (mns_sim_progress(sim).t < 0.04) assert_int_equal(mns_sim_step(sim, 0.04, &error), MNS_OK);
    while (mns_sim_progress(whole).t < 0.04) assert_int_equal(mns_sim_step(whole, 0.04, &error), MNS_OK);
    assert_true(mns_sim_progress(sim).step == mns_sim_progress(whole).step);
    assert_true(mns_sim_hash(sim) == mns_sim_hash(whole));
    sim_done(whole, all);
    sim_done(sim, other);
    mns_case_free(c);
}

static void run_goes_on_with_another_gravity_in_schemes_of_one_and_of_two_sets_of_rates(void **state)
{
    (void)state;
    run_goes_on_with_another_gravity("riemann");
    run_goes_on_with_another_gravity("dissipation");
}

/* A probe is read between steps: the next one says what was wrong. Set right again, the run goes on. */
static void probe_whose_formula_fails_is_said_by_the_next_step(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    case_set_text(&case_add_probe(c, MNS_PROBE_PRESSURE_DEVIATION)->formula, "x > 0.7 and (y < 2) or 0");
    c->threads = 3;
    MnsSim *sim = sim_of(c);
    MnsError error = {0};
    MnsCapture *capture = NULL;
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_OK);
    assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
    assert_true(isnan(mns_sim_probe(sim, 0)));
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_INVALID);
    assert_string_equal(error.path, "probes[0].pressure_deviation.from");
    assert_int_equal(mns_sim_restore(sim, capture, NULL), MNS_OK);
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_OK);
    mns_capture_free(capture);
    sim_done(sim, c);
}

static void gravity_of_no_number_is_not_steered_to(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10), *other = case_periodic(2, 10);
    MnsSim *sim = sim_of(c);
    MnsError error = {0};
    assert_int_equal(mns_sim_step(sim, 0.001, &error), MNS_OK);
    case_set_text(&other->gravity[1], "t < 0.01 and (t > 0) or 1");
    assert_int_equal(mns_sim_steer(sim, other, &error), MNS_E_INVALID);
    assert_string_equal(error.path, "gravity[1]");
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_OK);
    sim_done(sim, other);
    mns_case_free(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gravity_that_turns_into_a_truth_ends_the_run),
        cmocka_unit_test(surface_that_turns_into_a_truth_ends_the_run),
        cmocka_unit_test(run_goes_on_with_another_gravity_in_schemes_of_one_and_of_two_sets_of_rates),
        cmocka_unit_test(probe_whose_formula_fails_is_said_by_the_next_step),
        cmocka_unit_test(gravity_of_no_number_is_not_steered_to),
    };
    return cmocka_run_group_tests_name("formula_fault", tests, NULL, NULL);
}
