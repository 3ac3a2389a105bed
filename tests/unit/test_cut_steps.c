/* SPDX-License-Identifier: BSD-3-Clause */
/* Time steps that are cut short, in the schemes that project: the pressure does not depend on the cut. And a moving tank carries its fluid without a
 * delay of half a step. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <math.h>
#include <stdlib.h>

static const char *const SCHEMES[] = {"incompressible", "differences"};

typedef enum Place { PLACE_ENDLESS, PLACE_TANK, PLACE_GLIDING_TANK, PLACES } Place;

/* Water that turns in a box of 1. */
static MnsCase *stirred(const char *scheme, Place place)
{
    MnsCase *c = case_blank(2, 20);
    c->scheme.name = scheme;
    c->scheme.smoothing = 1.3;
    c->scheme.incompressible.reference_speed = c->scheme.differences.reference_speed = 1;
    case_add_fluid(c, "water", 1000, 20);
    c->fluids[0].viscosity = 1;
    case_put_part(2, &c->fluids[0].shape, (MnsPart){.primitive = MNS_BOX, .b = {1, 1}});
    case_set_text(&c->fluids[0].velocity[0], "0.5*sin(2*pi*x)*cos(2*pi*y)");
    case_set_text(&c->fluids[0].velocity[1], "-0.5*cos(2*pi*x)*sin(2*pi*y)");
    c->periodic[0] = c->periodic[1] = place == PLACE_ENDLESS;
    if (place == PLACE_ENDLESS) return c;
    case_add_wall(c, "tank");
    case_put_part(2, &c->walls[0].shape, (MnsPart){.primitive = MNS_BOX, .outside = true, .b = {1, 1}});
    if (place == PLACE_GLIDING_TANK) { /* at 0.1 pi m/s, hardly any slower by the end */
        c->walls[0].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {0.5}, .frequency = 0.1};
        case_set_text(&c->fluids[0].velocity[0], "0.1*pi + 0.5*sin(2*pi*x)*cos(2*pi*y)");
    }
    return c;
}

static double *pressures(const MnsSim *sim)
{
    double *p = calloc(sim->s.n, sizeof *p);
    assert_non_null(p);
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) p[sim->s.id[i]] = sim->s.p[i * sim->s.p_step];
    return p;
}

/* The largest change since then, over the largest pressure. */
static double change_since(const MnsSim *sim, const double *before)
{
    double *now = pressures(sim), change = 0, most = 0;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        change = fmax(change, fabs(now[i] - before[i]));
        most = fmax(most, fabs(before[i]));
    }
    free(now);
    return change / most;
}

static void step_until(MnsSim *sim, double t)
{
    assert_int_equal(mns_sim_step(sim, t, NULL), MNS_OK);
}

/* The next step is a whole one, and its pressure must fit too, within what the flow itself changes. In `incompressible` each projection leaves part of the
 * divergence to the next step. A short step leaves less, so the pressure after it is too low. */
static void the_pressure_of_a_step_cut_short_is_that_of_the_flow(void **state)
{
    (void)state;
    for (size_t q = 0; q < sizeof SCHEMES / sizeof *SCHEMES; q++)
        for (int place = 0; place < PLACES; place++)
            for (double share = 0.01; share < 1; share = share < 0.1 ? 0.1 : share + 0.2) {
                MnsCase *c = stirred(SCHEMES[q], (Place)place);
                MnsSim *sim = sim_of(c);
                sim_steps(sim, 5);
                double *before = pressures(sim);
                const double whole = mns_sim_progress(sim).dt;
                step_until(sim, mns_sim_progress(sim).t + share * whole);
                const double cut = change_since(sim, before);
                step_until(sim, INFINITY);
                const double after = change_since(sim, before);
                if (!(cut <= 0.06 && after <= (q == 0 ? 0.15 : 0.08)))
                    fail_msg(
                        "%s, place %d, a step of %g of a whole one: the pressure changes by %g, and by %g at the next",
                        SCHEMES[q], place, share, cut, after);
                free(before);
                sim_done(sim, c);
            }
}

/* Water at rest in a full tank is carried by it. */
static void a_tank_carries_what_fills_it_without_delay(void **state)
{
    (void)state;
    for (size_t q = 0; q < sizeof SCHEMES / sizeof *SCHEMES; q++) {
        MnsCase *c = stirred(SCHEMES[q], PLACE_TANK);
        c->walls[0].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {0.05}, .frequency = 1};
        const double turn = 2 * M_PI;
        for (int d = 0; d < 2; d++) case_set_text(&c->fluids[0].velocity[d], d == 0 ? "0.1*pi" : "0");
        MnsSim *sim = sim_of(c);
        while (mns_sim_progress(sim).t < 0.3) {
            step_until(sim, 0.3);
            double mean = 0;
            for (size_t i = 0; i < particles_fluid(&sim->s); i++) mean += sim->s.v[0][i * sim->s.v_step];
            mean /= (double)particles_fluid(&sim->s);
            const double v = 0.05 * turn * cos(turn * mns_sim_progress(sim).t);
            if (!(fabs(mean - v) <= 0.01 * 0.05 * turn))
                fail_msg("%s, t = %g s: the tank has %g m/s and what fills it %g", SCHEMES[q], mns_sim_progress(sim).t,
                         v, mean);
        }
        sim_done(sim, c);
    }
}

/* Between the particles beside the floor and those beside the lid [Pa]. */
static double head(const MnsSim *sim)
{
    double low = 0, high = 0;
    size_t n = 0;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        const double y = sim->s.x[1][i * sim->s.x_step], p = sim->s.p[i * sim->s.p_step];
        n += y < 0.05;
        low += y < 0.05 ? p : 0;
        high += y > 0.95 ? p : 0;
    }
    return (low - high) / (double)n;
}

/* However soon the run is stopped again. And what shows it moves nothing. */
static void a_gravity_that_is_set_shows_in_a_step_cut_short(void **state)
{
    (void)state;
    for (size_t q = 0; q < sizeof SCHEMES / sizeof *SCHEMES; q++)
        for (double share = 1e-3; share <= 1; share *= 10) {
            MnsCase *c[2];
            for (int k = 0; k < 2; k++) {
                c[k] = stirred(SCHEMES[q], PLACE_TANK);
                for (int d = 0; d < 2; d++) case_set_text(&c[k]->fluids[0].velocity[d], "0");
                case_set_text(&c[k]->gravity[1], k ? "-3" : "-1");
            }
            MnsSim *sim = sim_of(c[0]);
            step_until(sim, 1e-5);
            assert_close(head(sim), 950, 10);
            sim_steps(sim, 5);
            assert_close(head(sim), 950, 10);
            double *x = malloc(sim->s.n * sizeof *x), *v = malloc(sim->s.n * sizeof *v);
            assert_true(x && v);
            for (size_t i = 0; i < sim->s.n; i++) {
                x[i] = sim->s.x[1][i * sim->s.x_step];
                v[i] = sim->s.v[1][i * sim->s.v_step];
            }
            assert_int_equal(mns_sim_steer(sim, c[1], NULL), MNS_OK);
            for (size_t i = 0; i < sim->s.n; i++)
                assert_true(sim->s.x[1][i * sim->s.x_step] == x[i] && sim->s.v[1][i * sim->s.v_step] == v[i]);
            step_until(sim, mns_sim_progress(sim).t + share * mns_sim_progress(sim).dt);
            const double now = head(sim);
            if (!(fabs(now - 2850) <= 30)) fail_msg("%s, a step of %g: %g Pa of 2850", SCHEMES[q], share, now);
            free(x);
            free(v);
            mns_sim_free(sim);
            for (int k = 0; k < 2; k++) mns_case_free(c[k]);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_pressure_of_a_step_cut_short_is_that_of_the_flow),
        cmocka_unit_test(a_tank_carries_what_fills_it_without_delay),
        cmocka_unit_test(a_gravity_that_is_set_shows_in_a_step_cut_short),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
