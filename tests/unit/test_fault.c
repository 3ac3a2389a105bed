/* SPDX-License-Identifier: BSD-3-Clause */
/* A run that cannot go on says which particle is to blame, where and by which term, and stays as it is until it is restored. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdio.h>
#include <string.h>

static void divergence_names_particle_place_and_term_and_stays(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_periodic(dim, 10);
        c->limits.density_max = 1.3;
        c->limits.time_step_floor = 1e-6;
        case_set_text(&c->fluids[0].velocity[0], "-400*(x - 0.2)"); /* all of it into one line */
        MnsSim *sim = sim_in_arrays(c);
        MnsError error = {0}, again = {0};
        MnsStatus status = MNS_OK;
        for (int k = 0; k < 100 && !status; k++) status = mns_sim_step(sim, INFINITY, &error);
        assert_int_equal(status, MNS_E_DIVERGED);
        assert_int_equal(error.status, MNS_E_DIVERGED);
        static const char *const words[] = {"particle", "of water", "at (", "bounds of density", "Riemann continuity"};
        for (size_t k = 0; k < sizeof words / sizeof *words; k++)
            if (!strstr(error.text, words[k])) fail_msg("\"%s\" does not say \"%s\"", error.text, words[k]);
        /* The state is that of the step that failed, and stays. */
        const MnsProgress progress = mns_sim_progress(sim);
        const uint64_t hash = mns_sim_hash(sim);
        assert_true(progress.step > 0 && progress.t > 0);
        assert_int_equal(mns_sim_step(sim, INFINITY, &again), MNS_E_DIVERGED);
        assert_string_equal(again.text, error.text);
        assert_int_equal(mns_sim_step(sim, INFINITY, NULL), MNS_E_DIVERGED);
        assert_true(mns_sim_hash(sim) == hash && mns_sim_progress(sim).step == progress.step);
        MnsCapture *capture = NULL;
        assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
        mns_capture_free(capture);
        sim_done(sim, c);
    }
}

/* Each bound by itself, and of each fluid its own reference. */
static void density_out_of_either_bound_is_a_divergence(void **state)
{
    (void)state;
    static const double factors[] = {0.5, 1.6};
    for (int fluid = 0; fluid < 2; fluid++)
        for (int k = 0; k < 2; k++) {
            MnsCase *c = case_still(2, 10, MNS_DENSITY_CONTINUITY);
            c->limits.density_min = 0.8;
            c->limits.density_max = 1.25;
            MnsSim *sim = sim_in_arrays(c);
            sim_steps(sim, 3);
            size_t i = 0;
            while (sim->s.phase[i] != fluid) i++;
            char particle[64];
            snprintf(particle, sizeof particle, "particle %u of %s", sim->s.id[i], c->fluids[fluid].name);
            sim->s.rho[i] = factors[k] * c->fluids[fluid].density;
            MnsError error = {0};
            assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_DIVERGED);
            if (!strstr(error.text, particle) || !strstr(error.text, "left the bounds of density"))
                fail_msg("\"%s\" does not say \"%s\"", error.text, particle);
            sim_done(sim, c);
        }
}

/* Where pressures in a gas fall far below zero a background pressure would hold it, in the schemes that have one in all pressures. */
static void a_fluid_torn_apart_is_offered_a_background_pressure(void **state)
{
    (void)state;
    static const char *const schemes[] = {"dissipation", "interfacial", "riemann"};
    for (int k = 0; k < 3; k++)
        for (int has = 0; has < 2; has++) {
            MnsCase *c = case_still(2, 10, MNS_DENSITY_CONTINUITY);
            c->scheme.name = schemes[k];
            c->scheme.dissipation.background_pressure = c->scheme.interfacial.background_pressure = 0.1 * has;
            MnsSim *sim = sim_in_arrays(c);
            sim_steps(sim, 3);
            sim->s.rho[0] *= 0.05;
            MnsError error = {0};
            assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_DIVERGED);
            const bool offered = strstr(error.text, "background_pressure of up to ") != NULL;
            if (offered != (k < 2 && !has)) fail_msg("%s, %d: %s", schemes[k], has, error.text);
            sim_done(sim, c);
        }
}

/* The shift goes with the speed, and keeps its square; what it does to a density is but how that changes from place to place. */
static void a_fast_particle_is_not_blamed_on_the_shift(void **state)
{
    (void)state;
    MnsCase *c = case_still(2, 10, MNS_DENSITY_AUTOMATIC);
    c->scheme.name = "interfacial";
    c->limits.density_max = 1.25;
    c->limits.time_step_floor = 1e-6;
    MnsSim *sim = sim_in_arrays(c);
    sim_steps(sim, 3);
    sim->s.rho[0] = 1.6 * c->fluids[sim->s.phase[0]].density;
    sim->s.v[0][0] = sim->v_max = 1000;
    MnsError error = {0};
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_DIVERGED);
    if (!strstr(error.text, "left the bounds of density") ||
        !strstr(error.text, "most is due to \"continuity of volumes\""))
        fail_msg("\"%s\"", error.text);
    sim_done(sim, c);
}

/* Gravity is no term, but what a falling drop must be blamed on. */
static void gravity_is_weighed_against_the_terms(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    c->limits.time_step_floor = 0.04; /* that to see it coming does not get under */
    case_set_text(&c->gravity[0], "t < 0.05 and 0 or 1e4");
    MnsSim *sim = sim_in_arrays(c);
    MnsError error = {0};
    MnsStatus status = MNS_OK;
    for (int k = 0; k < 1000 && !status; k++) status = mns_sim_step(sim, INFINITY, &error);
    assert_int_equal(status, MNS_E_DIVERGED);
    assert_non_null(strstr(error.text, "due to \"gravity\""));
    sim_done(sim, c);
}

static void velocity_that_is_no_number_is_found_at_once(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(2, 2);
    MnsSim *sim = sim_in_arrays(c);
    sim_steps(sim, 3);
    const size_t i = 40;
    /* Alone in the air, so that it is the only one: no neighbour takes it over in one step. */
    for (int d = 0; d < 2; d++) sim->s.v[d][i] = NAN;
    MnsError error = {0};
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_DIVERGED);
    assert_non_null(strstr(error.text, "no number"));
    assert_non_null(strstr(error.text, "step 4 "));
    sim_done(sim, c);
}

/* What is no number spreads from particle to particle, and says nothing of where it began. */
static void a_density_out_of_bounds_is_named_before_what_is_no_number(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(2, 2);
    c->limits.density_max = 2;
    MnsSim *sim = sim_in_arrays(c);
    sim_steps(sim, 3);
    const Particles *s = &sim->s;
    const size_t end = s->begin[GROUP_SUMMATION]; /* of those whose density follows continuity */
    size_t first = 0, far = 0;
    for (size_t i = 0; i < end; i++)
        if (s->id[i] < s->id[first]) first = i;
    for (size_t i = 0; i < end; i++)
        if (fabs(s->x[0][i] - s->x[0][first]) > fabs(s->x[0][far] - s->x[0][first])) far = i;
    assert_true(fabs(s->x[0][far] - s->x[0][first]) > 2 * sim->model.kernel.support); /* out of each other's reach */
    for (int d = 0; d < 2; d++) s->v[d][first] = NAN;
    s->rho[far] *= 4;
    char particle[64];
    snprintf(particle, sizeof particle, "particle %u of", s->id[far]);
    MnsError error = {0};
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_DIVERGED);
    if (!strstr(error.text, particle)) fail_msg("\"%s\" does not say \"%s\"", error.text, particle);
    sim_done(sim, c);
}

static void time_step_below_its_floor_is_a_divergence(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    c->limits.time_step_floor = 0.5;
    MnsSim *sim = sim_in_arrays(c);
    sim_steps(sim, 1);
    for (size_t i = 0; i < sim->s.n; i++) sim->s.v[0][i] += 30; /* with c = 10 */
    sim_steps(sim, 1);
    MnsError error = {0};
    const uint64_t hash = mns_sim_hash(sim);
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_DIVERGED);
    assert_non_null(strstr(error.text, "floor"));
    assert_non_null(strstr(error.text, "sound and flow"));
    assert_true(mns_sim_hash(sim) == hash); /* no step was made */
    sim_done(sim, c);
}

static void restore_takes_a_fault_away(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(2, 1);
    MnsSim *sim = sim_in_arrays(c);
    MnsCapture *capture = NULL;
    sim_steps(sim, 3);
    assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
    sim->s.v[0][9] = NAN;
    assert_int_equal(mns_sim_step(sim, INFINITY, NULL), MNS_E_DIVERGED);
    assert_int_equal(mns_sim_restore(sim, capture, NULL), MNS_OK);
    mns_capture_free(capture);
    sim_steps(sim, 10);
    sim_done(sim, c);
}

/* Of every scheme, before its first step too, when nothing of a pressure system is laid out; and later nothing writes into that, whose rows
 * may be laid out for other lists. */
static void every_scheme_names_who_is_to_blame_at_any_time(void **state)
{
    (void)state;
    char text[1];
    const char *scheme;
    for (size_t k = 0; (scheme = mns_scheme_describe(k, text, sizeof text)); k++)
        for (int dim = 2; dim <= 3; dim++)
            for (int steps = 0; steps < 3; steps += 2) {
                MnsCase *c = case_shaken_by(scheme, dim, 2);
                MnsError error = {0};
                MnsSim *sim = sim_in_arrays(c);
                sim_steps(sim, steps);
                for (size_t i = 0; i < sim->system.matrix.n; i++) sim->system.matrix.blocks[i] = 77;
                sim->v_max = 1e12;
                sim->progress.dt_first = 1;
                assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_DIVERGED);
                if (!strstr(error.text, "m/s, most due to \"")) fail_msg("\"%s\" blames nobody", error.text);
                for (size_t i = 0; i < sim->system.matrix.n; i++) assert_int_equal(sim->system.matrix.blocks[i], 77);
                sim_done(sim, c);
            }
}

/* Densities that are no part of the equations have no term that moves them, and no speed of sound to be raised. */
static void without_compression_the_number_density_is_to_blame(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences"};
    for (int k = 0; k < 2; k++) {
        MnsCase *c = case_shaken_by(schemes[k], 2, 1);
        MnsError error = {0};
        c->limits.density_min = 0.9999;
        c->limits.density_max = 1.0001;
        MnsSim *sim = sim_in_arrays(c);
        MnsStatus status = MNS_OK;
        for (int n = 0; n < 50 && !status; n++) status = mns_sim_step(sim, INFINITY, &error);
        assert_int_equal(status, MNS_E_DIVERGED);
        if (!strstr(error.text, "most is due to \"number density\"") || strstr(error.text, "sound speed"))
            fail_msg("\"%s\"", error.text);
        sim_done(sim, c);
    }
}

/* What surrounds a particle without an equation of its own would take its old pressure as given. */
static void a_particle_without_a_pressure_is_to_blame(void **state)
{
    (void)state;
    MnsCase *c = case_shaken_by("differences", 2, 1);
    MnsError error = {0};
    MnsSim *sim = sim_in_arrays(c);
    sim_steps(sim, 2);
    sim->s.laplacian[40] = sim->s.laplacian[70] = 0;
    const size_t first = sim->s.id[40] < sim->s.id[70] ? 40 : 70;
    char particle[64];
    snprintf(particle, sizeof particle, "neighbours of 2 particles lie too much to one side");
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_DIVERGED);
    if (!strstr(error.text, particle)) fail_msg("\"%s\" does not say \"%s\"", error.text, particle);
    snprintf(particle, sizeof particle, "particle %u of %s", sim->s.id[first], c->fluids[sim->s.phase[first]].name);
    if (!strstr(error.text, particle)) fail_msg("\"%s\" does not say \"%s\"", error.text, particle);
    sim_done(sim, c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(divergence_names_particle_place_and_term_and_stays),
        cmocka_unit_test(density_out_of_either_bound_is_a_divergence),
        cmocka_unit_test(a_fluid_torn_apart_is_offered_a_background_pressure),
        cmocka_unit_test(a_fast_particle_is_not_blamed_on_the_shift),
        cmocka_unit_test(gravity_is_weighed_against_the_terms),
        cmocka_unit_test(velocity_that_is_no_number_is_found_at_once),
        cmocka_unit_test(a_density_out_of_bounds_is_named_before_what_is_no_number),
        cmocka_unit_test(time_step_below_its_floor_is_a_divergence),
        cmocka_unit_test(restore_takes_a_fault_away),
        cmocka_unit_test(every_scheme_names_who_is_to_blame_at_any_time),
        cmocka_unit_test(a_particle_without_a_pressure_is_to_blame),
        cmocka_unit_test(without_compression_the_number_density_is_to_blame),
    };
    return cmocka_run_group_tests_name("fault", tests, NULL, NULL);
}
