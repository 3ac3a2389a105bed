/* SPDX-License-Identifier: BSD-3-Clause */
/* Of the velocity that a case gives a wall's surface, what is along the surface acts, at each of its points and whatever it is made of; what
 * would pump fluid through the wall does not, and is said. */
#include "sim/solid.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdio.h>
#include <string.h>

static const double U[3] = {0.5, 0.25, -0.125};

static void set_belt(MnsWall *wall, int dim)
{
    for (int d = 0; d < dim; d++) {
        char text[32];
        snprintf(text, sizeof text, "%g", U[d]);
        case_set_text(&wall->surface_velocity[d], text);
    }
    wall->no_slip = true;
}

/* A full tank of 2 x 1 (x 1) m. */
static MnsCase *tank(int dim, double resolution)
{
    MnsCase *c = case_blank(dim, resolution);
    c->max[0] = 2;
    case_add_fluid(c, "water", 1000, 20);
    c->fluids[0].viscosity = 10;
    case_add_wall(c, "tank");
    MnsPart *box = case_add_part(&c->walls[0].shape, MNS_BOX);
    box->outside = true;
    for (int d = 0; d < 3; d++) box->b[d] = c->max[d];
    c->walls[0].no_slip = true;
    return c;
}

static double belt_at(const MnsSim *sim, int d, size_t i)
{
    return sim->s.belt[d][i - particles_fluid(&sim->s)];
}

/* Make sure that particle i of a wall has u less its part along these normals. */
static void assert_along(const MnsSim *sim, size_t i, int n, double (*normal)[3])
{
    double u[3] = {0, 0, 0};
    for (int d = 0; d < sim->s.dim; d++) u[d] = U[d];
    for (int k = 0; k < n; k++) {
        double across = 0;
        for (int d = 0; d < sim->s.dim; d++) across += u[d] * normal[k][d];
        for (int d = 0; d < sim->s.dim; d++) u[d] -= across * normal[k][d];
    }
    for (int d = 0; d < sim->s.dim; d++)
        if (!(fabs(belt_at(sim, d, i) - u[d]) < 1e-6))
            fail_msg("at (%g, %g, %g): v%c is %g and should be %g", sim->s.x[0][i], sim->s.x[1][i],
                     sim->s.dim == 3 ? sim->s.x[2][i] : 0, "xyz"[d], belt_at(sim, d, i), u[d]);
}

/* At its sides what is along them, at its edges what is along these, at its corners nothing. */
static void sides_of_a_box_move_along_themselves(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim, 10);
        set_belt(&c->walls[0], dim);
        MnsSim *sim = sim_in_arrays(c);
        for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++) {
            double normal[3][3] = {{0}};
            int n = 0;
            for (int d = 0; d < dim; d++)
                if (sim->s.x[d][i] < c->min[d] || sim->s.x[d][i] > c->max[d]) normal[n++][d] = 1;
            assert_along(sim, i, n, normal);
        }
        sim_done(sim, c);
    }
}

static void round_walls_move_along_themselves(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int hollow = 0; hollow < 2; hollow++) {
            const double middle[3] = {1.01, 0.52, dim == 3 ? 0.49 : 0};
            MnsCase *c = tank(dim, 10);
            case_add_wall(c, "ball");
            MnsPart *ball = case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BALL, .radius = 0.3});
            memcpy(ball->a, middle, sizeof middle);
            ball->outside = hollow;
            set_belt(&c->walls[1], dim);
            MnsSim *sim = sim_in_arrays(c);
            size_t seen = 0;
            for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++) {
                double normal[1][3] = {{0}}, r = 0;
                bool outside = false; /* of the domain; there the nearest surface may be covered by the tank */
                for (int d = 0; d < dim; d++) {
                    normal[0][d] = sim->s.x[d][i] - middle[d];
                    r = hypot(r, normal[0][d]);
                    outside = outside || sim->s.x[d][i] < c->min[d] || sim->s.x[d][i] > c->max[d];
                }
                for (int d = 0; d < dim; d++) normal[0][d] /= r;
                if (sim->s.phase[i] == 2 && !outside && r > 0.1) assert_along(sim, i, 1, normal), seen++;
            }
            assert_true(seen > 15);
            sim_done(sim, c);
        }
}

/* A drum with ends. */
static void ends_and_round_sides_move_along_themselves(void **state)
{
    (void)state;
    MnsCase *c = tank(3, 10);
    case_add_wall(c, "drum");
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_CYLINDER, .a = {1, 0.5, 0.2}, .b = {1, 0.5, 0.8}, .radius = 0.3});
    set_belt(&c->walls[1], 3);
    MnsSim *sim = sim_in_arrays(c);
    size_t ends = 0, sides = 0;
    for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++) {
        const double x = sim->s.x[0][i] - 1, y = sim->s.x[1][i] - 0.5, z = fabs(sim->s.x[2][i] - 0.5);
        const double r = hypot(x, y), side = 0.3 - r, end = 0.3 - z;
        double normal[2][3] = {{x / r, y / r, 0}, {0, 0, 1}};
        if (sim->s.phase[i] != 2) continue;
        if (side < end - 0.01) assert_along(sim, i, 1, normal), sides++;
        if (end < side - 0.01) assert_along(sim, i, 1, normal + 1), ends++;
    }
    assert_true(ends > 10 && sides > 10);
    sim_done(sim, c);
}

static void oblique_walls_move_along_themselves(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim, 10);
        case_add_wall(c, "ramp");
        case_put_part(c->dim, &c->walls[1].shape,
                      (MnsPart){.primitive = MNS_PLATE,
                                .a = {1, 0.5, 0.5},
                                .b = {2, 1, 0},
                                .c = {-1, 2, 0},
                                .length = 0.8,
                                .width = 0.8,
                                .thickness = 0.3});
        set_belt(&c->walls[1], dim);
        MnsSim *sim = sim_in_arrays(c);
        size_t seen = 0;
        for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++) {
            const double x = sim->s.x[0][i] - 1, y = sim->s.x[1][i] - 0.5;
            const double along = fabs(2 * x + y) / sqrt(5), z = dim == 3 ? fabs(sim->s.x[2][i] - 0.5) : 0;
            double normal[1][3] = {{-1 / sqrt(5), 2 / sqrt(5), 0}};
            if (sim->s.phase[i] != 2 || !(along < 0.24 && z < 0.24)) continue;
            assert_along(sim, i, 1, normal); /* its middle too */
            seen++;
        }
        assert_true(seen > 10);
        sim_done(sim, c);
    }
}

/* A bowl cut out of a block. */
static void combined_walls_move_along_themselves(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim, 10);
        case_add_wall(c, "bowl");
        case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BOX, .a = {0, 0, 0}, .b = {2, 0.6, 1}});
        case_put_part(c->dim, &c->walls[1].shape,
                      (MnsPart){.operation = MNS_SUBTRACT, .primitive = MNS_BALL, .a = {1, 0.7, 0.5}, .radius = 0.35});
        set_belt(&c->walls[1], dim);
        MnsSim *sim = sim_in_arrays(c);
        size_t seen = 0;
        for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++) {
            double normal[1][3] = {{sim->s.x[0][i] - 1, sim->s.x[1][i] - 0.7, dim == 3 ? sim->s.x[2][i] - 0.5 : 0}};
            const double r =
                sqrt(normal[0][0] * normal[0][0] + normal[0][1] * normal[0][1] + normal[0][2] * normal[0][2]);
            for (int d = 0; d < 3; d++) normal[0][d] /= r;
            if (sim->s.phase[i] != 2 || !(r < 0.45 && sim->s.x[1][i] < 0.4)) continue;
            assert_along(sim, i, 1, normal);
            seen++;
        }
        assert_true(seen > 3);
        sim_done(sim, c);
    }
}

/* A lid that is told as a box: its ends are in the tank's sides, and its back is outside of the domain. */
static void lid_moves_as_a_whole_where_its_ends_are_covered(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim, 10);
        c->walls[0].shape.parts[0].b[1] = 2;
        case_add_wall(c, "lid");
        case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BOX, .a = {0, 1, 0}, .b = {2, 1.3, 1}});
        case_set_text(&c->walls[1].surface_velocity[0], "0.5");
        c->walls[1].no_slip = true;
        MnsSim *sim = sim_in_arrays(c);
        assert_null(mns_sim_warning(sim, 0));
        for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++)
            for (int d = 0; d < dim; d++) {
                assert_true(belt_at(sim, d, i) == (sim->s.phase[i] == 2 && d == 0 ? 0.5 : 0));
                assert_true(sim->s.v[d][i] == 0);
            }
        sim_done(sim, c);
    }
}

/* As its formula says, besides what the wall does, and in whatever order particles have come to be. */
static void belt_of_a_wall_that_moves_follows_time(void **state)
{
    (void)state;
    MnsCase *c = tank(2, 10);
    c->walls[0].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {0.1, 0.05, 0}, .frequency = 1};
    case_set_text(&c->walls[0].surface_velocity[0], "0.5 + t");
    case_set_text(&c->walls[0].surface_velocity[1], "0.25 - t");
    MnsSim *sim = sim_in_arrays(c);
    sim_steps(sim, 60);
    const WallState *wall = &sim->model.wall[0];
    const double t = sim->model.t;
    assert_true(t > 0.05 && fabs(wall->v[0]) > 0.1);
    for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++) {
        const double x = sim->s.x[0][i] - wall->x[0], y = sim->s.x[1][i] - wall->x[1];
        const bool side = x < 0 || x > 2, end = y < 0 || y > 1;
        assert_close(belt_at(sim, 0, i), side ? 0 : 0.5 + t, 1e-12);
        assert_close(belt_at(sim, 1, i), end ? 0 : 0.25 - t, 1e-12);
        for (int d = 0; d < 2; d++) assert_close(sim->s.v[d][i], wall->v[d], 1e-12);
    }
    sim_done(sim, c);
}

/* Of particles that are put into another order, and of a belt that does not change. */
static void belt_is_the_same_when_a_run_goes_on(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim, 10);
        MnsCapture *capture = NULL;
        set_belt(&c->walls[0], dim);
        MnsSim *sim = sim_of(c), *again = NULL;
        sim_steps(sim, 20);
        assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
        assert_int_equal(mns_sim_resume(c, capture, &again, NULL), MNS_OK);
        mns_capture_free(capture);
        assert_int_equal(again->s.n, sim->s.n);
        for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++) {
            assert_int_equal(again->s.id[i], sim->s.id[i]);
            for (int d = 0; d < dim; d++) assert_true(belt_at(again, d, i) == belt_at(sim, d, i));
        }
        sim_steps(sim, 20);
        sim_steps(again, 20);
        assert_true(mns_sim_hash(again) == mns_sim_hash(sim));
        mns_sim_free(again);
        sim_done(sim, c);
    }
}

static void velocity_that_is_nowhere_along_the_wall_is_refused(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 3; k++) {
            MnsCase *c = tank(dim, 10);
            MnsSim *sim = NULL;
            MnsError error = {0};
            case_add_wall(c, "lid");
            if (k == 0)
                case_put_part(c->dim, &c->walls[1].shape,
                              (MnsPart){.primitive = MNS_HALF_SPACE, .a = {0, 0.8, 0}, .b = {0, -1, 0}});
            else
                case_put_part(c->dim, &c->walls[1].shape,
                              (MnsPart){.primitive = MNS_BOX, .a = {-1, 0.7, -1}, .b = {3, 2, 2}});
            case_set_text(&c->walls[1].surface_velocity[1], k == 1 ? "sin(t)" : "0.1");
            assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
            assert_string_equal(error.path, "walls[1].surface_velocity");
            case_set_text(&c->walls[1].surface_velocity[0], k == 1 ? "sin(t)" : "0.001"); /* a little will do */
            mns_sim_free(sim_of(c));
            case_set_text(&c->walls[1].surface_velocity[0], "0");
            case_set_text(&c->walls[1].surface_velocity[1], "0*t"); /* and so does none */
            sim_done(sim_of(c), c);
        }
}

static int count_warnings(const MnsSim *sim, const char *word)
{
    int n = 0;
    const char *text;
    for (size_t k = 0; (text = mns_sim_warning(sim, k)); k++) n += strstr(text, word) != NULL;
    return n;
}

static void faces_that_lose_more_than_a_hundredth_are_warned_of(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim, 10);
        case_set_text(&c->walls[0].surface_velocity[0], "0.5");
        MnsSim *sim = sim_of(c);
        const char *middles[] = {dim == 2 ? "around (0, 0.5, 0) m" : "around (0, 0.5, 0.5) m",
                                 dim == 2 ? "around (2, 0.5, 0) m" : "around (2, 0.5, 0.5) m"};
        assert_int_equal(count_warnings(sim, "walls[0].surface_velocity: 100 % of it is lost on the flat face"), 2);
        for (int k = 0; k < 2; k++)
            if (count_warnings(sim, middles[k]) != 1) fail_msg("%s: %s", middles[k], mns_sim_warning(sim, 0));
        assert_null(mns_sim_warning(sim, 2));
        mns_sim_free(sim);
        case_set_text(&c->walls[0].surface_velocity[1], "0.06"); /* of which the floor loses 0.7 % */
        sim = sim_of(c);
        assert_int_equal(count_warnings(sim, "is lost on"), 2);
        mns_sim_free(sim);
        case_set_text(&c->walls[0].surface_velocity[1], "0.08"); /* 1.3 %, and the same of the top */
        sim = sim_of(c);
        assert_int_equal(count_warnings(sim, "1.26 % of it is lost on"), 2);
        assert_int_equal(count_warnings(sim, "is lost on"), 4);
        sim_done(sim, c);

        c = tank(dim, 10);
        case_add_wall(c, "ball");
        case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BALL, .a = {1, 0.5, 0.5}, .radius = 0.3});
        set_belt(&c->walls[1], dim);
        sim = sim_of(c);
        assert_int_equal(count_warnings(sim, "is lost on the round face of shape[0] of ball"), 1);
        sim_done(sim, c);
    }
}

/* Where each face loses velocity, by its message: `off` its surface at most, and with room before it. */
static void assert_places(MnsSim *sim, size_t wall, double off)
{
    const char *text;
    int n = 0;
    for (size_t k = 0; (text = mns_sim_warning(sim, k)); k++) {
        const char *around = strstr(text, "around (");
        double place[3];
        if (!around) continue;
        assert_int_equal(sscanf(around, "around (%lf, %lf, %lf)", &place[0], &place[1], &place[2]), 3);
        const double away = shape_distance(&sim->solid[wall], place);
        bool room = false;
        for (int q = 0; q < solid_ways(sim->model.dim); q++) {
            double way[3], before[3];
            solid_way(sim->model.dim, q, way);
            for (int d = 0; d < 3; d++) before[d] = place[d] + off * way[d];
            room = room || solid_leaves_room(sim, before);
        }
        if (fabs(away) > 0.5 * off || !room) fail_msg("%g m off, room: %d: %s", away, room, text);
        n++;
    }
    assert_in_range(n, 1, 6);
}

/* Half of a ball is outside of the domain; and the middle of a side is covered by another wall. */
static void places_of_what_is_lost_are_on_the_face(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim, 10);
        c->walls[0].shape.parts[0].a[0] = -1;
        case_add_wall(c, "ball");
        case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BALL, .a = {0, 0.5, 0.5}, .radius = 0.25});
        case_set_text(&c->walls[1].surface_velocity[1], "1");
        c->walls[1].no_slip = true;
        MnsSim *sim = sim_of(c);
        assert_places(sim, 1, 0.005);
        sim_done(sim, c);

        c = tank(dim, 10);
        case_set_text(&c->walls[0].surface_velocity[0], "0.5");
        case_add_wall(c, "shelf");
        case_put_part(c->dim, &c->walls[1].shape,
                      (MnsPart){.primitive = MNS_BOX, .a = {-1, 0.3, 0.3}, .b = {0.5, 0.7, 0.7}});
        sim = sim_of(c);
        assert_places(sim, 0, 0.005);
        sim_done(sim, c);
    }
}

static void belt_on_a_wall_that_fluids_glide_along_is_warned_of(void **state)
{
    (void)state;
    MnsCase *c = tank(2, 10);
    case_add_wall(c, "lid");
    case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BOX, .a = {-1, 0.7, -1}, .b = {3, 2, 2}});
    case_set_text(&c->walls[1].surface_velocity[0], "1");
    MnsSim *sim = sim_of(c);
    assert_int_equal(count_warnings(sim, "walls[1].surface_velocity: nothing is moved by it"), 1);
    assert_null(mns_sim_warning(sim, 1));
    mns_sim_free(sim);
    c->walls[1].no_slip = true;
    sim = sim_of(c);
    assert_null(mns_sim_warning(sim, 0));
    sim_done(sim, c);
}

static double kinetic_energy(const MnsCase *c, double end)
{
    MnsSim *sim = sim_in_arrays(c);
    double sum = 0;
    while (mns_sim_progress(sim).t < end) assert_int_equal(mns_sim_step(sim, end, NULL), MNS_OK);
    for (size_t i = 0; i < particles_fluid(&sim->s); i++)
        for (int d = 0; d < sim->s.dim; d++) sum += 0.5 * sim->s.m[i] * sim->s.v[d][i] * sim->s.v[d][i];
    mns_sim_free(sim);
    return sum;
}

/* The same tank with sides that stand still moves its water as much. */
static void belt_pumps_nothing_through_the_sides_of_a_tank(void **state)
{
    (void)state;
    static const char *const schemes[] = {"riemann", "dissipation", "interfacial", "incompressible", "differences"};
    for (size_t k = 0; k < sizeof schemes / sizeof *schemes; k++) {
        double energy[2];
        for (int apart = 0; apart < 2; apart++) {
            MnsCase *c = tank(2, 16);
            c->scheme.name = schemes[k];
            c->scheme.incompressible.reference_speed = c->scheme.differences.reference_speed = 1;
            if (apart) { /* sides, and a floor and a top that reach below and above them */
                MnsPart *sides = c->walls[0].shape.parts;
                sides->a[1] = -1;
                sides->b[1] = 2;
                case_add_wall(c, "ends");
                case_put_part(c->dim, &c->walls[1].shape,
                              (MnsPart){.outside = true, .primitive = MNS_BOX, .a = {-9, 0, 0}, .b = {9, 1, 1}});
                c->walls[1].no_slip = true;
            }
            case_set_text(&c->walls[apart].surface_velocity[0], "0.5");
            energy[apart] = kinetic_energy(c, 0.2);
            mns_case_free(c);
        }
        if (!(fabs(energy[0] / energy[1] - 1) < 0.1))
            fail_msg("%s: %g J, and %g J with the sides apart", schemes[k], energy[0], energy[1]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sides_of_a_box_move_along_themselves),
        cmocka_unit_test(round_walls_move_along_themselves),
        cmocka_unit_test(ends_and_round_sides_move_along_themselves),
        cmocka_unit_test(oblique_walls_move_along_themselves),
        cmocka_unit_test(combined_walls_move_along_themselves),
        cmocka_unit_test(lid_moves_as_a_whole_where_its_ends_are_covered),
        cmocka_unit_test(belt_of_a_wall_that_moves_follows_time),
        cmocka_unit_test(belt_is_the_same_when_a_run_goes_on),
        cmocka_unit_test(velocity_that_is_nowhere_along_the_wall_is_refused),
        cmocka_unit_test(faces_that_lose_more_than_a_hundredth_are_warned_of),
        cmocka_unit_test(places_of_what_is_lost_are_on_the_face),
        cmocka_unit_test(belt_on_a_wall_that_fluids_glide_along_is_warned_of),
        cmocka_unit_test(belt_pumps_nothing_through_the_sides_of_a_tank),
    };
    return cmocka_run_group_tests_name("belts", tests, NULL, NULL);
}
