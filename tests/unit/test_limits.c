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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(time_step_is_that_of_the_papers),
        cmocka_unit_test(time_step_follows_the_worst_pair_of_fluids),
        cmocka_unit_test(time_step_minds_how_walls_move),
    };
    return cmocka_run_group_tests_name("limits", tests, NULL, NULL);
}
