/* SPDX-License-Identifier: BSD-3-Clause */
/* Gravity that changes: whatever the steps are, a fluid gets the impulse that it is given; steps see it coming; what does not change has its own
 * bits. */
#include "sim/gravity.h"
#include "sim/limits.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdio.h>

static const char *const SCHEMES[] = {"riemann", "dissipation", "interfacial", "incompressible", "differences"};

/* Water that fills a periodic box, under this. */
static MnsCase *weighed(const char *scheme, const char *gravity)
{
    MnsCase *c = case_blank(2, 16);
    c->scheme.name = scheme;
    c->scheme.smoothing = strcmp(scheme, "interfacial") == 0 ? 1.6 : 1.2;
    c->scheme.incompressible.reference_speed = c->scheme.differences.reference_speed = 1;
    c->periodic[0] = c->periodic[1] = true;
    case_add_fluid(c, "water", 1000, 20);
    c->fluids[0].viscosity = 1;
    case_add_part(&c->fluids[0].shape, MNS_BOX);
    c->fluids[0].shape.parts[0].b[0] = c->fluids[0].shape.parts[0].b[1] = 1;
    case_set_text(&c->gravity[0], gravity);
    return c;
}

static double mean_velocity(const MnsSim *sim)
{
    double sum = 0;
    for (size_t i = 0; i < sim->s.n; i++) sum += sim->s.v[0][i * sim->s.v_step];
    return sum / (double)sim->s.n;
}

/* 1 m/s within so many seconds about t = 0.2. */
static void pulse(char text[], size_t size, double width)
{
    snprintf(text, size, "exp(-((t - 0.2)/%g)^2)/%g/sqrt(pi)", width, width);
}

/* In steps that are cut short now and then, with a restart in the midst of it. */
static void a_pulse_has_its_impulse_in_all_schemes(void **state)
{
    (void)state;
    for (size_t q = 0; q < sizeof SCHEMES / sizeof *SCHEMES; q++)
        for (int k = 0; k < 2; k++) {
            char text[100];
            pulse(text, sizeof text, k == 0 ? 0.02 : 0.001);
            MnsCase *c = weighed(SCHEMES[q], text);
            MnsSim *sim = sim_of(c);
            for (int n = 1; n <= 10; n++)
                while (mns_sim_progress(sim).t < 0.0317 * n)
                    assert_int_equal(mns_sim_step(sim, 0.0317 * n, NULL), MNS_OK);
            if (!(fabs(mean_velocity(sim) - 1) <= 1e-3))
                fail_msg("%s, pulse %d: %g m/s instead of 1", SCHEMES[q], k, mean_velocity(sim));
            sim_done(sim, c);
        }
}

/* Of which most other schemes' steps see only a part. */
static void a_push_that_begins_and_ends_at_once_has_its_impulse(void **state)
{
    (void)state;
    for (size_t q = 0; q < sizeof SCHEMES / sizeof *SCHEMES; q++) {
        MnsCase *c = weighed(SCHEMES[q], "t > 0.0123 and t < 0.0323 and 50 or 0");
        MnsSim *sim = sim_of(c);
        while (mns_sim_progress(sim).t < 0.06) assert_int_equal(mns_sim_step(sim, 0.06, NULL), MNS_OK);
        if (!(fabs(mean_velocity(sim) - 1) <= 1e-3))
            fail_msg("%s: %g m/s instead of 1", SCHEMES[q], mean_velocity(sim));
        sim_done(sim, c);
    }
}

static void restarts_within_a_pulse_go_on_to_the_same_bits(void **state)
{
    (void)state;
    for (size_t q = 0; q < sizeof SCHEMES / sizeof *SCHEMES; q++) {
        MnsCase *c = case_shaken_by(SCHEMES[q], 2, 1);
        case_set_text(&c->gravity[0], "30*sin(900*t)");
        MnsSim *sim = sim_of(c), *again = NULL;
        MnsCapture *capture = NULL;
        sim_steps(sim, 5);
        assert_int_equal(mns_sim_step(sim, mns_sim_progress(sim).t + 0.4 * mns_sim_progress(sim).dt, NULL), MNS_OK);
        assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
        assert_int_equal(mns_sim_resume(c, capture, &again, NULL), MNS_OK);
        mns_capture_free(capture);
        sim_steps(sim, 5);
        sim_steps(again, 5);
        if (mns_sim_hash(sim) != mns_sim_hash(again)) fail_msg("%s: other bits", SCHEMES[q]);
        mns_sim_free(again);
        sim_done(sim, c);
    }
}

/* And a formula of t that is constant nevertheless has them too. */
static void what_does_not_change_has_its_own_bits(void **state)
{
    (void)state;
    for (size_t q = 0; q < sizeof SCHEMES / sizeof *SCHEMES; q++) {
        MnsCase *c = case_shaken_by(SCHEMES[q], 2, 1), *same = case_shaken_by(SCHEMES[q], 2, 1);
        case_set_text(&c->gravity[1], "-0.1");
        case_set_text(&same->gravity[1], "-0.1 + 0*t");
        MnsSim *sim = sim_of(c), *twin = sim_of(same);
        sim_steps(sim, 5);
        sim_steps(twin, 5);
        assert_true(sim->model.gravity[1] == -0.1);
        if (mns_sim_hash(sim) != mns_sim_hash(twin)) fail_msg("%s: other bits", SCHEMES[q]);
        sim_done(twin, same);
        sim_done(sim, c);
    }
}

static void means_are_those_of_the_formula(void **state)
{
    (void)state;
    const struct {
        const char *text;
        double mean, tolerance; /* from 1 to 3 */
    } rows[] = {
        {"2 - t + 5*t^2 - 3*t^3", 2 - 2 + 65. / 3 - 30, 1e-13},
        {"exp(t)", 0.5 * (exp(3) - exp(1)), 1e-6},
        {"1/sqrt(t + 1e-9)", sqrt(3) - 1, 1e-6},
        {"t < 1.7321 and 1 or 0", 0.36605, 1e-3},
        {"-9.81 + 0*t", -9.81, 0},
        {"sqrt(2 - t)", NAN, 0},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *c = weighed("riemann", rows[k].text);
        MnsSim *sim = sim_of(c);
        double mean[3], when = 0;
        int d = -1;
        gravity_mean(sim, 1, 3, mean);
        if (isnan(rows[k].mean)) {
            assert_true(isnan(mean[0]));
            assert_true(gravity_failure(sim, 1, 3, &d, &when));
            assert_int_equal(d, 0);
            assert_close(when, 2.5, 0.5001);
        } else {
            assert_close(mean[0], rows[k].mean, rows[k].tolerance);
            assert_false(gravity_failure(sim, 1, 3, &d, &when));
        }
        assert_true(mean[1] == 0);
        sim_done(sim, c);
    }
}

/* What energies are measured against is that of the time, and what pushes is the mean. */
static void both_means_and_what_is_now_are_known(void **state)
{
    (void)state;
    MnsCase *c = weighed("riemann", "100*t");
    MnsSim *sim = sim_of(c);
    sim_steps(sim, 2);
    const MnsProgress progress = mns_sim_progress(sim);
    assert_close(sim->model.gravity_now[0], 100 * progress.t, 1e-12);
    assert_close(sim->model.gravity[0], 100 * (progress.t - 0.5 * progress.dt), 1e-12);
    sim_done(sim, c);
}

/* A pulse that comes within the step is seen, one that is over is not; slow changes and none leave steps as they are. */
static void steps_are_bounded_by_what_is_coming(void **state)
{
    (void)state;
    for (size_t q = 0; q < sizeof SCHEMES / sizeof *SCHEMES; q++) {
        const struct {
            const char *gravity;
            bool bounds;
        } rows[] = {{"-9.81", false},
                    {"-9.81 + sin(t)", false},
                    {"1e7*t", true},
                    {"t < 1e-5 and 0 or 1e5", true},
                    {"t < 0 and 1e9 or 1", false}};
        for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
            MnsCase *c = weighed(SCHEMES[q], rows[k].gravity);
            MnsSim *sim = sim_of(c);
            const Limit *limit = NULL;
            const double dt = limits_dt(sim, &limit);
            if (rows[k].bounds != (limit == &change_limit)) fail_msg("%s, %zu: %s", SCHEMES[q], k, limit->name);
            if (rows[k].bounds) {
                double others = INFINITY;
                for (int l = 0; sim->scheme->limits[l] != &change_limit; l++)
                    others = fmin(others, sim->scheme->limits[l]->of(sim));
                const double by = k == 2 ? 1e7 * others : 32 * 1e5;
                assert_close(dt, 0.25 * sqrt(sim->model.kernel.h / by), 1e-6 * dt);
            }
            sim_done(sim, c);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pulse_has_its_impulse_in_all_schemes),
        cmocka_unit_test(a_push_that_begins_and_ends_at_once_has_its_impulse),
        cmocka_unit_test(restarts_within_a_pulse_go_on_to_the_same_bits),
        cmocka_unit_test(what_does_not_change_has_its_own_bits),
        cmocka_unit_test(means_are_those_of_the_formula),
        cmocka_unit_test(both_means_and_what_is_now_are_known),
        cmocka_unit_test(steps_are_bounded_by_what_is_coming),
    };
    return cmocka_run_group_tests_name("gravity", tests, NULL, NULL);
}
