/* SPDX-License-Identifier: BSD-3-Clause */
/* No particle gets closer to a wall than the guard lets it, and none loses more than its velocity into the wall. */
#include "tests/support/check.h"
#include "tests/support/sims.h"

/* Nearest a fluid particle is to the tank's walls. */
static double nearest_to_wall(const MnsSim *sim)
{
    double nearest = INFINITY;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        double x[3] = {0, 0, 0};
        for (int d = 0; d < sim->s.dim; d++) x[d] = sim->s.x[d][i] - sim->model.wall[0].x[d];
        nearest = fmin(nearest, shape_distance(&sim->solid[0], x));
    }
    return nearest;
}

/* How many are no farther from them than the guard puts them. */
static size_t as_near_as_the_guard(const MnsSim *sim)
{
    size_t n = 0;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        double x[3] = {0, 0, 0};
        for (int d = 0; d < sim->s.dim; d++) x[d] = sim->s.x[d][i] - sim->model.wall[0].x[d];
        n += shape_distance(&sim->solid[0], x) < sim->model.guard * (1 + 1e-9);
    }
    return n;
}

/* Throw what is near the floor at it, with half the speed of sound. */
static void throw_down(MnsSim *sim)
{
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        if (sim->s.x[1][i] > 1.5 * sim->model.dx) continue;
        sim->s.v[0][i] = 1;
        sim->s.v[1][i] = -10;
    }
}

static void guard_keeps_what_is_thrown_at_a_wall_inside_and_counts(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int guarded = 1; guarded >= 0; guarded--) {
            MnsCase *c = case_shaken(dim, 2);
            if (!guarded) c->scheme.riemann.guard = 0;
            c->limits.density_max = 100;
            MnsSim *sim = sim_in_arrays(c);
            throw_down(sim);
            double nearest = INFINITY;
            for (int k = 0; k < 8; k++) {
                assert_int_equal(mns_sim_step(sim, INFINITY, NULL), MNS_OK);
                nearest = fmin(nearest, nearest_to_wall(sim));
            }
            const double distance = 0.25 * sim->model.dx;
            if (guarded) assert_true(nearest > distance * (1 - 1e-9)); /* rounding of the way back */
            else assert_true(nearest < distance);
            assert_int_equal(mns_sim_progress(sim).guarded > 0, guarded);
            sim_done(sim, c);
        }
}

/* Of such a wall the lists of particles have nothing (mirrors.h). */
static void guard_keeps_what_is_thrown_at_a_mirror_inside(void **state)
{
    (void)state;
    static const char *const schemes[] = {"riemann", "dissipation"};
    for (int k = 0; k < 4; k++) {
        MnsCase *c = case_shaken_by(schemes[k % 2], 2 + k / 2, 2);
        c->walls[0].motion = (MnsMotion){.kind = MNS_STILL};
        c->walls[0].no_slip = false;
        case_set_text(&c->gravity[0], "0");
        c->limits.density_max = 100;
        MnsSim *sim = sim_in_arrays(c);
        assert_true(sim->model.mirrors & 1);
        for (size_t i = 0; i < particles_fluid(&sim->s); i++)
            if (sim->s.x[0][i] < 1.5 * sim->model.dx) sim->s.v[0][i] = -8;
        for (int step = 0; step < 8; step++) assert_int_equal(mns_sim_step(sim, INFINITY, NULL), MNS_OK);
        assert_true(mns_sim_progress(sim).guarded > 0);
        assert_true(nearest_to_wall(sim) >
                    0.2 * sim->model.dx); /* the last half of a step may go on from the guard's distance */
        sim_done(sim, c);
    }
}

/* By a scheme that looks at the walls in the middle of its steps as well: each that ends as far from the wall as the guard puts it. */
static void guard_counts_a_particle_once_a_step(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_shaken_by("dissipation", dim, 2);
        c->limits.density_max = 100;
        MnsSim *sim = sim_in_arrays(c);
        throw_down(sim);
        uint64_t before = 0;
        for (int k = 0; k < 8; k++) {
            assert_int_equal(mns_sim_step(sim, INFINITY, NULL), MNS_OK);
            const uint64_t guarded = mns_sim_progress(sim).guarded - before;
            assert_in_range(guarded, 0, as_near_as_the_guard(sim));
            before += guarded;
        }
        assert_true(before > 10);
        sim_done(sim, c);
    }
}

/* Only the velocity into the wall goes, relative to the wall, and not that away from it. */
static void guard_takes_only_the_velocity_into_the_wall(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(3, 1);
    MnsSim *sim = sim_in_arrays(c);
    sim->model.wall[0] = (WallState){.x = {0.01, 0.02, -0.01}, .v = {0.1, -0.5, 0.2}, .no_slip = true};
    size_t floor[2] = {0}, n = 0;
    for (size_t i = 0; i < particles_fluid(&sim->s) && n < 2; i++)
        if (sim->s.x[1][i] < sim->model.dx && sim->s.x[0][i] > 1 && sim->s.x[2][i] > 0.3 && sim->s.x[2][i] < 0.7)
            floor[n++] = i;
    assert_int_equal(n, 2);
    const double speeds[2] = {-3, 2};
    for (size_t k = 0; k < 2; k++) {
        sim->s.x[1][floor[k]] = 0.02 - 0.4 * sim->model.dx; /* the floor is at 0.02 now */
        for (int d = 0; d < 3; d++) sim->s.v[d][floor[k]] = d == 1 ? speeds[k] : 0.7 + d;
    }
    const double x = sim->s.x[0][floor[0]];
    assert_int_equal(guard_walls(sim), 2);
    for (size_t k = 0; k < 2; k++) {
        assert_close(sim->s.x[1][floor[k]], 0.02 + 0.25 * sim->model.dx, 1e-12);
        assert_close(sim->s.v[0][floor[k]], 0.7, 1e-9); /* the normal is a difference quotient */
        assert_close(sim->s.v[2][floor[k]], 2.7, 1e-9);
        assert_close(sim->s.v[1][floor[k]], k == 0 ? -0.5 : 2, 1e-9);
    }
    assert_close(sim->s.x[0][floor[0]], x, 1e-12);
    sim_done(sim, c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(guard_keeps_what_is_thrown_at_a_wall_inside_and_counts),
        cmocka_unit_test(guard_keeps_what_is_thrown_at_a_mirror_inside),
        cmocka_unit_test(guard_counts_a_particle_once_a_step),
        cmocka_unit_test(guard_takes_only_the_velocity_into_the_wall),
    };
    return cmocka_run_group_tests_name("guard", tests, NULL, NULL);
}
