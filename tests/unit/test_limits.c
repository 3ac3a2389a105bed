/* SPDX-License-Identifier: BSD-3-Clause */
/* The time step is the smallest that the papers ask for, and names its reason. */
#include "sim/limits.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"

/* dt of the first step for a box of fluid with these numbers. */
static double first_dt(double resolution, double c0, const char *gravity, double mu, const char *speed,
                       const Limit *expected)
{
    MnsCase *c = case_blank(2, resolution);
    c->periodic[0] = c->periodic[1] = true;
    case_add_fluid(c, "a", 3, c0);
    c->fluids[0].viscosity = mu;
    case_set_text(&c->fluids[0].velocity[1], speed);
    case_set_text(&c->gravity[0], gravity);
    MnsSim *sim = sim_of(c);
    const Limit *limit = NULL;
    const double dt = limits_dt(sim, &limit);
    if (limit != expected) fail_msg("the limit is \"%s\", not \"%s\"", limit->name, expected->name);
    sim_steps(sim, 1);
    assert_true(mns_sim_progress(sim).dt == dt);
    sim_done(sim, c);
    return dt;
}

static void time_step_is_that_of_the_papers(void **state)
{
    (void)state;
    const double h = 1.3 / 10, tiny = 1e-15;
    assert_close(first_dt(10, 20, "0", 0, "0", &acoustic_limit), 0.25 * h / 20, tiny);
    assert_close(first_dt(20, 20, "0", 0, "0", &acoustic_limit), 0.25 * 0.5 * h / 20, tiny);
    assert_close(first_dt(10, 20, "0", 0, "-5", &acoustic_limit), 0.25 * h / 25, tiny);
    assert_close(first_dt(10, 5, "-900", 0, "0", &body_force_limit), 0.25 * sqrt(h / 900), tiny);
    assert_close(first_dt(10, 20, "-4808", 0, "0", &body_force_limit), 0.25 * sqrt(h / 4808),
                 tiny); /* just below that of sound */
    assert_close(first_dt(40, 5, "3600", 0, "0", &body_force_limit), 0.25 * sqrt(h / 4 / 3600), tiny);
    assert_close(first_dt(10, 5, "0", 3, "0", &viscous_limit), 0.125 * h * h * 3 / 3, tiny);
    assert_close(first_dt(20, 5, "0", 6, "0", &viscous_limit), 0.125 * 0.25 * h * h * 3 / 6, tiny);
}

/* Between two fluids the harmonic mean of the viscosities acts on the lighter; the faster sound counts. */
static void time_step_follows_the_worst_pair_of_fluids(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    c->scheme.cfl = 0.5;
    c->fluids[1].sound_speed = 40;
    for (int k = 0; k < 2; k++)
        for (int d = 0; d < 3; d++) case_set_text(&c->fluids[k].velocity[d], "0");
    MnsSim *sim = sim_of(c);
    const Limit *limit = NULL;
    assert_close(limits_dt(sim, &limit), 0.5 * 0.13 / 40, 1e-15);
    mns_sim_free(sim);
    c->fluids[0].viscosity = 2; /* nu = 2, 2 * 2 * 1 / 3 / 0.1 = 13.3, 1 / 0.1 = 10 */
    c->fluids[1].viscosity = 1;
    sim = sim_of(c);
    assert_close(limits_dt(sim, &limit), 0.125 * 0.13 * 0.13 * 0.1 * 3 / 4, 1e-15);
    sim_done(sim, c);
}

/* A lid may be faster than all fluid; what lies on a shaken wall feels gravity less the wall's acceleration. */
static void time_step_minds_how_walls_move(void **state)
{
    (void)state;
    const double tiny = 1e-15;
    for (int fast = 0; fast < 2; fast++) {
        MnsCase *c = case_dam_break(2, 10); /* c = 20, g = (0, -1) */
        c->max[0] = c->walls[0].shape.parts[0].b[0] = 5.4;
        case_add_wall(c, "block");
        MnsPart *block = case_add_part(&c->walls[1].shape, MNS_BOX);
        block->a[0] = 4;
        block->b[0] = block->b[1] = 5;
        MnsSim *sim = sim_of(c);
        WallState *wall = &sim->model.wall[fast];
        const Limit *limit = NULL;
        wall->v[0] = 3;
        wall->v[1] = -4;
        assert_close(limits_dt(sim, &limit), 0.25 * 0.13 / (20 + 5), tiny);
        assert_ptr_equal(limit, &acoustic_limit);
        wall->a[0] = 6000;
        wall->a[1] = 7999; /* and the ground falls away under it: 8000 downwards are felt */
        assert_close(limits_dt(sim, &limit), 0.25 * sqrt(0.13 / 1e4), tiny);
        assert_ptr_equal(limit, &body_force_limit);
        wall->a[0] = 0;
        wall->a[1] = -1; /* free fall: the gravity of those who do not lie on it is left */
        assert_close(body_force_limit.of(sim), 0.25 * sqrt(0.13), tiny);
        sim_done(sim, c);
    }
}

/* Air and water with everything else out of the way. */
static MnsSim *two_fluids(MnsCase **ret_case, const char *scheme, MnsPairAverage average, double delta)
{
    MnsCase *c = *ret_case = case_periodic(2, 10); /* densities 1 and 0.1, c = 10 */
    c->scheme.name = scheme;
    c->scheme.dissipation.pair_average = c->scheme.interfacial.pair_average = average;
    c->scheme.dissipation.delta = c->scheme.interfacial.delta = delta;
    c->tension[0][1] = c->tension[1][0] = 0.6;
    c->fluids[0].viscosity = 2;
    c->fluids[1].viscosity = 1;
    return sim_of(c);
}

/* With arithmetic averages the light fluid is as stiff as the heavy one: h/(c_h sqrt(rho_h/rho_l)), twice with dissipation enough,
 * and with little of it little more. */
static void light_fluids_are_stiff_where_averages_are_arithmetic(void **state)
{
    (void)state;
    static const char *const schemes[] = {"dissipation", "interfacial"};
    for (size_t k = 0; k < 2; k++) {
        MnsCase *c;
        MnsSim *sim = two_fluids(&c, schemes[k], MNS_AVERAGE_ARITHMETIC, 0);
        assert_close(interface_limit.of(sim), 0.13 / (10 * sqrt(10)), 1e-15);
        sim->model.phase[0].c = 40; /* that of the heavy one counts */
        sim->model.phase[1].c = 90;
        assert_close(interface_limit.of(sim), 0.13 / (40 * sqrt(10)), 1e-15);
        sim_done(sim, c);
        sim = two_fluids(&c, schemes[k], MNS_AVERAGE_ARITHMETIC, 0.5);
        assert_close(interface_limit.of(sim), 2 * 0.13 / (10 * sqrt(10)), 1e-15);
        sim->model.delta = 0.05;
        assert_close(interface_limit.of(sim), 1.2 * 0.13 / (10 * sqrt(10)), 1e-15);
        sim->model.phase[1].rho0 = 1;
        assert_true(isinf(interface_limit.of(sim)));
        sim_done(sim, c);
        sim = two_fluids(&c, schemes[k], MNS_AVERAGE_DENSITY, 0);
        assert_true(isinf(interface_limit.of(sim)));
        sim_done(sim, c);
    }
}

/* The faster of two fluids bounds the time step of those that dissipate much: 0.55 h/(delta c). */
static void dissipation_bounds_the_time_step(void **state)
{
    (void)state;
    static const char *const schemes[] = {"dissipation", "interfacial"};
    for (size_t k = 0; k < 2; k++) {
        MnsCase *c;
        const Limit *limit = NULL;
        MnsSim *sim = two_fluids(&c, schemes[k], MNS_AVERAGE_DENSITY, 4);
        sim->model.c_max = 800; /* faster than friction and tension */
        sim->model.cfl = 0.4;
        assert_close(limits_dt(sim, &limit), 0.55 * 0.13 / (4 * 800), 1e-15);
        assert_ptr_equal(limit, &dissipation_limit);
        sim_done(sim, c);
        sim = two_fluids(&c, schemes[k], MNS_AVERAGE_DENSITY, 0);
        assert_true(isinf(dissipation_limit.of(sim)));
        sim_done(sim, c);
    }
}

/* The most that a case may ask for, in two fluids that are stirred. */
static void the_most_dissipation_is_stable(void **state)
{
    (void)state;
    static const char *const schemes[] = {"dissipation", "interfacial"};
    for (size_t k = 0; k < 2; k++) {
        MnsCase *c = case_periodic(2, 20);
        c->scheme.name = schemes[k];
        c->scheme.dissipation.delta = c->scheme.interfacial.delta = 4;
        MnsSim *sim = sim_of(c);
        sim_steps(sim, 300);
        assert_less(sim->v_max, 2); /* 0.7 at first */
        sim_done(sim, c);
    }
}

/* Waves of an interface move both fluids: 0.25 sqrt(rho h^3/(2 pi sigma)) with the mean density. */
static void surface_tension_bounds_the_time_step_by_the_mean_density(void **state)
{
    (void)state;
    MnsCase *c;
    MnsSim *sim = two_fluids(&c, "dissipation", MNS_AVERAGE_DENSITY, 0.5);
    assert_close(tension_limit.of(sim), 0.25 * sqrt(0.55 * 0.13 * 0.13 * 0.13 / (2 * acos(-1) * 0.6)), 1e-15);
    sim->model.tension[0][1] = sim->model.tension[1][0] = 0;
    assert_true(isinf(tension_limit.of(sim)));
    sim_done(sim, c);
}

/* Less than the other form may have: along the line of a pair 0.085 of h^2 rho/mu in P2 and 0.065 in P1, and not 0.125, as its largest rates are twice as large. */
static void radial_viscosity_needs_a_smaller_time_step(void **state)
{
    (void)state;
    MnsCase *c;
    MnsSim *sim = two_fluids(&c, "interfacial", MNS_AVERAGE_DENSITY, 0.5);
    const Limit *limit = NULL;
    const double mixed = 0.13 * 0.13 * 0.1 / (2.0 * 2 * 1 / 3); /* the harmonic mean moves the lighter one */
    assert_close(radial_viscous_limit.of(sim), 0.085 * mixed, 1e-15);
    assert_close(limits_dt(sim, &limit), 0.085 * mixed, 1e-15);
    assert_ptr_equal(limit, &radial_viscous_limit);
    sim_done(sim, c);
    sim = two_fluids(&c, "dissipation", MNS_AVERAGE_DENSITY, 0.5);
    assert_close(limits_dt(sim, &limit), 0.065 * mixed, 1e-15);
    assert_ptr_equal(limit, &viscous_limit);
    sim->model.radial = false;
    assert_close(viscous_limit.of(sim), 0.125 * mixed, 1e-15);
    sim_done(sim, c);
}

/* Without sound: what the flow is expected to do comes on top of what it does, and is found from gravity where it is not given. */
static void flows_without_sound_go_by_the_speed_that_is_expected(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences"};
    for (int k = 0; k < 2; k++) {
        MnsCase *c;
        MnsSim *sim = two_fluids(&c, schemes[k], MNS_AVERAGE_DENSITY, 0);
        sim->v_max = 3;
        sim->model.projection.speed = 2;
        assert_close(flow_limit.of(sim), 0.25 * 0.13 / 5, 1e-15);
        sim->model.gravity[0] = -3;
        sim->model.gravity[1] = 6; /* in a box of 1 x 1: sqrt(3 + 6) */
        assert_close(flow_limit.of(sim), 0.25 * 0.13 / 5, 1e-15);
        sim->model.projection.speed = -1;
        assert_close(flow_limit.of(sim), 0.25 * 0.13 / 6, 1e-15);
        sim->model.max[1] = 7 / 6.0; /* sqrt(3 + 7) */
        sim->v_max = 0;
        assert_close(flow_limit.of(sim), 0.25 * 0.13 / sqrt(10), 1e-15);
        sim->model.projection.speed = 0;
        assert_true(isinf(flow_limit.of(sim)));
        sim_done(sim, c);
    }
}

/* P4 by pairs, of which the harmonic mean moves the lighter one, and a fluid is a pair of its own; P5 by mixtures, as thin as the fluid with
 * the most viscosity over density. */
static void viscosity_bounds_the_time_step_of_flows_without_sound(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences"};
    for (int k = 0; k < 2; k++) {
        MnsCase *c;
        const Limit *limit = NULL;
        MnsSim *sim = two_fluids(&c, schemes[k], MNS_AVERAGE_DENSITY, 0); /* 2 and 1 Pa s, 1 and 0.1 kg/m^3 */
        assert_close(incompressible_viscous_limit.of(sim), 0.25 * 0.0169 * 0.1 * 3 / 4, 1e-15);
        assert_close(mixture_viscous_limit.of(sim), 0.25 * 0.0169 * 0.1, 1e-15);
        assert_close(limits_dt(sim, &limit), 0.25 * 0.0169 * 0.1 * (k ? 1 : 0.75), 1e-15);
        assert_ptr_equal(limit, k ? &mixture_viscous_limit : &incompressible_viscous_limit);
        sim->model.phase[1].mu = 0; /* then the mean is 0 too, and the first fluid is left */
        assert_close(incompressible_viscous_limit.of(sim), 0.25 * 0.0169 / 2, 1e-15);
        assert_close(mixture_viscous_limit.of(sim), 0.25 * 0.0169 / 2, 1e-15);
        sim->model.phase[0].mu = 0;
        assert_true(isinf(incompressible_viscous_limit.of(sim)) && isinf(mixture_viscous_limit.of(sim)));
        sim_done(sim, c);
    }
}

/* P4 eq. 39 has the lighter of the two; the jump of the pressure moves both fluids, as waves do (schemes/incompressible.md). */
static void surface_tension_bounds_the_time_step_by_the_mean_where_there_is_no_sound_too(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences"};
    for (int k = 0; k < 2; k++) {
        MnsCase *c;
        const Limit *limit = NULL;
        MnsSim *sim = two_fluids(&c, schemes[k], MNS_AVERAGE_DENSITY, 0);
        const double exact = 0.25 * sqrt(0.55 * 0.13 * 0.13 * 0.13 / (2 * acos(-1) * 0.6));
        assert_close(tension_limit.of(sim), exact, 1e-15);
        sim->model.phase[0].mu = sim->model.phase[1].mu = 0;
        sim->model.tension[0][1] = sim->model.tension[1][0] = 16 * 0.6;
        assert_close(limits_dt(sim, &limit), exact / 4, 1e-15);
        assert_ptr_equal(limit, &tension_limit);
        sim_done(sim, c);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(time_step_is_that_of_the_papers),
        cmocka_unit_test(time_step_follows_the_worst_pair_of_fluids),
        cmocka_unit_test(time_step_minds_how_walls_move),
        cmocka_unit_test(light_fluids_are_stiff_where_averages_are_arithmetic),
        cmocka_unit_test(dissipation_bounds_the_time_step),
        cmocka_unit_test(the_most_dissipation_is_stable),
        cmocka_unit_test(surface_tension_bounds_the_time_step_by_the_mean_density),
        cmocka_unit_test(radial_viscosity_needs_a_smaller_time_step),
        cmocka_unit_test(flows_without_sound_go_by_the_speed_that_is_expected),
        cmocka_unit_test(viscosity_bounds_the_time_step_of_flows_without_sound),
        cmocka_unit_test(surface_tension_bounds_the_time_step_by_the_mean_where_there_is_no_sound_too),
    };
    return cmocka_run_group_tests_name("limits", tests, NULL, NULL);
}
