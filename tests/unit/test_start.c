/* SPDX-License-Identifier: BSD-3-Clause */
/* Fluids at rest start at rest: under their own weight in layers, wherever walls are in between; drops and bubbles under that of
 * the fluid around and the tension of their surface. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdlib.h>
#include <string.h>

static const double RHO[3] = {13, 5, 2}, G = 4;

/* A box of a wall, from a to b along each direction. */
static void add_box(MnsShape *shape, int dim, const double a[3], const double b[3])
{
    MnsPart *part = case_add_part(shape, MNS_BOX);
    for (int d = 0; d < dim; d++) {
        part->a[d] = a[d];
        part->b[d] = b[d];
    }
}

/* A tank 1 x 1.2 (x 0.9) from a corner that is not the origin. */
static MnsCase *tank(int dim)
{
    MnsCase *c = case_blank(dim, 10);
    const double corner[3] = {0.3, -0.7, 0.2}, size[3] = {1, 1.2, 0.9};
    for (int d = 0; d < dim; d++) {
        c->min[d] = corner[d];
        c->max[d] = corner[d] + size[d];
    }
    case_add_wall(c, "tank");
    add_box(&c->walls[0].shape, dim, c->min, c->max);
    c->walls[0].shape.parts[0].outside = true;
    return c;
}

/* Three layers of 0.3, 0.2 and 0.1 under a free surface; gravity along an axis, up or down. Returns the height of the surface. */
static double add_layers(MnsCase *c, int axis, bool down)
{
    static const double THICK[3] = {0.3, 0.2, 0.1};
    double height = 0;
    case_set_text(&c->gravity[axis], down ? "-4" : "4");
    for (int k = 0; k < 3; k++) {
        static const char *const NAMES[] = {"brine", "water", "oil"};
        double a[3], b[3];
        case_add_fluid(c, NAMES[k], RHO[k], 40);
        memcpy(a, c->min, sizeof a);
        memcpy(b, c->max, sizeof b);
        a[axis] = down ? c->min[axis] + height : c->max[axis] - height - THICK[k];
        b[axis] = a[axis] + THICK[k];
        height += THICK[k];
        add_box(&c->fluids[k].shape, c->dim, a, b);
        case_set_text(&c->fluids[k].pressure, "hydrostatic");
    }
    return height;
}

/* The weight of all layers above a height over the floor. */
static double weight_above(double height)
{
    const double oil = fmin(0.1, 0.6 - height), water = fmin(0.2, fmax(0.5 - height, 0)), brine = fmax(0.3 - height, 0);
    return G * (RHO[2] * oil + RHO[1] * water + RHO[0] * brine);
}

static void assert_layers(const MnsSim *sim, int axis, bool down)
{
    const MnsCase *c = mns_sim_case(sim);
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        const double x = sim->s.x[axis][i], height = down ? x - c->min[axis] : c->max[axis] - x;
        assert_close(sim->s.p[i], weight_above(height), 1e-11); /* rounding of c^2 rho */
    }
}

static void layers_under_a_free_surface_bear_the_sum_of_those_above(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 2 * dim; k++) {
            MnsCase *c = tank(dim);
            add_layers(c, k / 2, k % 2);
            MnsSim *sim = sim_in_arrays(c);
            assert_layers(sim, k / 2, k % 2);
            sim_done(sim, c);
        }
}

/* A block that reaches through all layers but the highest and another that is in the lowest two, with a gap to the sides: below them
 * the pressure is that of the height. Across a periodic seam too. */
static void fluid_under_a_block_has_the_pressure_of_its_height(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 4 * dim; k++) {
            const int axis = k / 4, other = (axis + 1) % dim;
            const bool down = k % 2, around = k / 2 % 2;
            MnsCase *c = tank(dim);
            c->scheme.smoothing = 0.8; /* of which blocks of 0.2 m are more than the reach */
            add_layers(c, axis, down);
            if (around) {
                c->periodic[other] = true;
                c->walls[0].shape.parts[0].a[other] = -9;
                c->walls[0].shape.parts[0].b[other] = 9;
            }
            case_add_wall(c, "blocks");
            double a[3], b[3];
            memcpy(a, c->min, sizeof a);
            memcpy(b, c->max, sizeof b);
            a[axis] = down ? c->min[axis] + 0.2 : c->max[axis] - 0.5;
            b[axis] = a[axis] + 0.3;
            if (around) b[other] = a[other] + 0.4; /* open beyond the seam only */
            else {
                a[other] += 0.2;
                b[other] = a[other] + 0.3;
            }
            add_box(&c->walls[1].shape, dim, a, b);
            a[axis] = down ? c->min[axis] + 0.1 : c->max[axis] - 0.3;
            b[axis] = a[axis] + 0.2;
            a[other] = c->min[other] + 0.6;
            b[other] = a[other] + 0.2;
            add_box(&c->walls[1].shape, dim, a, b);
            MnsSim *sim = sim_in_arrays(c);
            assert_layers(sim, axis, down);
            sim_done(sim, c);
        }
}

/* Two arms, joined at the floor; the right one is closed at half the height of the left: 1 over 0.5, and open between y = -0.7 and
 * -0.5. With a lid on the left one too, where that is highest the pressure is zero. */
static void closed_arm_of_a_siphon_is_under_the_pressure_of_the_other(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int lid = 0; lid < 2; lid++) {
            MnsCase *c = tank(dim);
            c->scheme.smoothing = 0.8; /* of which a wall of 0.2 m is more than the reach */
            const double a[3] = {0.7, -0.5, 0.2}, b[3] = {0.9, 0.5, 1.1}, e[3] = {0.9, -0.2, 0.2},
                         f[3] = {1.3, 0.5, 1.1};
            add_box(&c->walls[0].shape, dim, a, b);
            add_box(&c->walls[0].shape, dim, e, f);
            case_set_text(&c->gravity[1], "-4");
            case_add_fluid(c, "water", 5, 40);
            if (!lid) case_set_text(&case_add_part(&c->fluids[0].shape, MNS_FORMULA)->formula, "y < 0.3");
            case_set_text(&c->fluids[0].pressure, "hydrostatic");
            MnsSim *sim = sim_in_arrays(c);
            for (size_t i = 0; i < particles_fluid(&sim->s); i++)
                assert_close(sim->s.p[i], 5 * 4 * ((lid ? 0.5 : 0.3) - sim->s.x[1][i]), 1e-11);
            sim_done(sim, c);
        }
}

/* Nothing says what the pressure of the lower one is: zero where it is highest, as that of the upper. */
static void chambers_that_are_not_joined_begin_with_zero_each(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim);
        const double a[3] = {0.3, -0.3, 0.2}, b[3] = {1.3, 0.0, 1.1}, e[3] = {0.3, -0.5, 0.2}, f[3] = {0.8, -0.3, 1.1};
        add_box(&c->walls[0].shape, dim, a, b);
        add_box(&c->walls[0].shape, dim, e, f); /* so that the lower chamber is of two heights */
        case_set_text(&c->gravity[1], "-4");
        case_add_fluid(c, "water", 5, 40);
        case_set_text(&c->fluids[0].pressure, "hydrostatic");
        MnsSim *sim = sim_in_arrays(c);
        for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
            const double y = sim->s.x[1][i];
            assert_close(sim->s.p[i], 5 * 4 * ((y > 0 ? 0.5 : -0.3) - y), 1e-11);
        }
        sim_done(sim, c);
    }
}

/* A pool does not feel what falls onto it. */
static void what_is_not_joined_to_a_pool_is_not_weighed_by_it(void **state)
{
    (void)state;
    MnsCase *c = tank(2);
    case_set_text(&c->gravity[1], "-4");
    case_add_fluid(c, "water", 5, 40);
    case_set_text(&case_add_part(&c->fluids[0].shape, MNS_FORMULA)->formula,
                  "y < -0.3 or (y > 0.1 and y < 0.3 and x < 0.6)");
    case_set_text(&c->fluids[0].pressure, "hydrostatic");
    MnsSim *sim = sim_in_arrays(c);
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        const double y = sim->s.x[1][i];
        assert_close(sim->s.p[i], 5 * 4 * ((y > 0 ? 0.3 : -0.3) - y), 1e-11);
    }
    sim_done(sim, c);
}

/* A case of water everywhere but in balls of gas, surface tension between them. */
static MnsCase *bubbles(int dim, const char *pressure)
{
    MnsCase *c = tank(dim);
    case_add_fluid(c, "gas", 2, 40);
    case_add_fluid(c, "water", 5, 40);
    case_set_text(&c->fluids[0].pressure, "laplace");
    case_set_text(&c->fluids[1].pressure, pressure);
    c->tension[0][1] = c->tension[1][0] = 0.7;
    c->scheme.name = "dissipation"; /* the Riemann scheme has no tension */
    return c;
}

static void add_bubble(MnsCase *c, double x, double y, double z, double radius)
{
    MnsPart *ball = case_add_part(&c->fluids[0].shape, MNS_BALL);
    const double at[3] = {x, y, z};
    for (int d = 0; d < c->dim; d++) ball->a[d] = at[d];
    ball->radius = radius;
}

/* As of one ball, without the other ones: its points and their middle, images near `about`. */
typedef struct Ball {
    double about[3], reach;
    size_t n;
    double centre[3], radius;
} Ball;

/* Where particle i is in the image that is nearest to the ball; false if it is not of the ball. */
static bool in_ball(const MnsSim *sim, const Ball *ball, size_t i, double x[3])
{
    double r2 = 0;
    for (int d = 0; d < 3; d++) x[d] = 0;
    for (int d = 0; d < sim->s.dim; d++) {
        const double dx = model_nearest(&sim->model, d, sim->s.x[d][i] - ball->about[d]);
        x[d] = ball->about[d] + dx;
        r2 += dx * dx;
    }
    return sim->s.phase[i] == 0 && r2 < ball->reach * ball->reach;
}

static Ball measure(const MnsSim *sim, double x, double y, double z, double reach)
{
    Ball ball = {.about = {x, y, z}, .reach = reach};
    double at[3], volume = 1;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++)
        if (in_ball(sim, &ball, i, at)) {
            ball.n++;
            for (int d = 0; d < 3; d++) ball.centre[d] += at[d];
        }
    for (int d = 0; d < 3; d++) ball.centre[d] /= (double)ball.n;
    for (int d = 0; d < sim->s.dim; d++) volume *= sim->model.cell[d];
    volume *= (double)ball.n;
    ball.radius = sim->s.dim == 2 ? sqrt(volume / acos(-1)) : cbrt(volume / (4 * acos(-1) / 3));
    return ball;
}

/* p = p_around + sigma (dim - 1)/R + rho g (x - centre) in all of a ball of n particles. */
static void assert_ball(const MnsSim *sim, const Ball *ball, double around)
{
    const double jump = 0.7 * (sim->s.dim - 1) / ball->radius;
    double x[3];
    assert_true(ball->n > 3);
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        double weight = 0;
        if (!in_ball(sim, ball, i, x)) continue;
        for (int d = 0; d < sim->s.dim; d++) weight += 2 * sim->model.gravity[d] * (x[d] - ball->centre[d]);
        assert_close(sim->s.p[i], around + jump + weight, 1e-11);
    }
}

/* sigma / R in two dimensions, 2 sigma / R in three: 88 and 304 points of 0.05 make R = 0.2646 and 0.2086. */
static void drop_without_weight_is_under_the_tension_of_its_surface(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = bubbles(dim, "3");
        c->resolution = 20;
        if (dim == 2) add_bubble(c, 0.8, -0.1, 0, 0.26);
        else add_bubble(c, 0.8, -0.1, 0.65, 0.21);
        MnsSim *sim = sim_in_arrays(c);
        const Ball ball = measure(sim, 0.8, -0.1, 0.65, 0.5);
        assert_int_equal(ball.n, dim == 2 ? 88 : 304);
        assert_close(ball.radius, dim == 2 ? sqrt(0.22 / acos(-1)) : cbrt(0.0285 / acos(-1)), 1e-14);
        assert_ball(sim, &ball, 3);
        for (size_t i = 0; i < particles_fluid(&sim->s); i++)
            if (sim->s.phase[i] == 1) assert_close(sim->s.p[i], 3, 1e-12);
        sim_done(sim, c);
    }
}

/* Each has a radius and a height of its own; the water is as if they were not there. Whichever way gravity points. */
static void bubbles_are_under_the_pressure_of_their_height_and_water_does_not_feel_them(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 2 * dim; k++) {
            const int axis = k / 2;
            const bool down = k % 2;
            MnsCase *c = bubbles(dim, "hydrostatic");
            c->resolution = 20;
            case_set_text(&c->gravity[axis], down ? "-4" : "4");
            add_bubble(c, 0.6, -0.4, 0.5, 0.15);
            add_bubble(c, 1.02, 0.13, 0.8, 0.23);
            MnsSim *sim = sim_in_arrays(c);
            const Ball small = measure(sim, 0.6, -0.4, 0.5, 0.2), large = measure(sim, 1.02, 0.13, 0.8, 0.28);
            const double top = down ? c->max[axis] : c->min[axis];
            assert_true(small.radius < 0.17 && large.radius > 0.21);
            assert_ball(sim, &small, 5 * G * fabs(top - small.centre[axis]));
            assert_ball(sim, &large, 5 * G * fabs(top - large.centre[axis]));
            for (size_t i = 0; i < particles_fluid(&sim->s); i++)
                if (sim->s.phase[i] == 1) assert_close(sim->s.p[i], 5 * G * fabs(top - sim->s.x[axis][i]), 1e-11);
            assert_true(sim->start[0].drops && !sim->start[1].drops);
            assert_close(sim->start[0].most.capillary, 0.7 / small.radius, 1e-12);
            assert_close(sim->start[0].most.across, 2 * small.radius, 1e-12);
            assert_close(sim->start[0].across, 2 * large.radius, 1e-12);
            sim_done(sim, c);
        }
}

/* In the middle of a side, of an edge, of a corner. */
static void bubble_across_periodic_seams_is_one(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int seams = 1; seams < 1 << dim; seams++) {
            MnsCase *c = bubbles(dim, "3 + (x > 0.3 and x < 1.3 and 1 or 0)"); /* 4 in the domain */
            double at[3] = {0.8, -0.1, 0.65};
            c->resolution = 20;
            for (int d = 0; d < dim; d++) {
                MnsPart *side = &c->walls[0].shape.parts[0];
                c->periodic[d] = seams >> d & 1;
                if (!c->periodic[d]) continue;
                at[d] = c->min[d] + 0.03;
                side->a[d] = -9;
                side->b[d] = 9;
            }
            if (seams == (1 << dim) - 1) { /* nothing is outside: a block then */
                c->walls[0].shape.parts[0].outside = false;
                for (int d = 0; d < dim; d++) {
                    c->walls[0].shape.parts[0].a[d] = at[d] + 0.4;
                    c->walls[0].shape.parts[0].b[d] = at[d] + 0.6;
                }
            }
            case_set_text(&c->gravity[0], "0.2");
            case_set_text(&c->gravity[1], "-0.3"); /* a drop has its own weight, wherever that acts */
            add_bubble(c, at[0], at[1], at[2], 0.2);
            MnsSim *sim = sim_in_arrays(c);
            const Ball ball = measure(sim, at[0], at[1], at[2], 0.25);
            assert_close(ball.radius, 0.2, 0.01);
            assert_ball(sim, &ball, 4);
            sim_done(sim, c);
        }
}

/* Heavy drops in a gas do not weigh on it, nor on the pool under it, and hang wherever they are. */
static void drop_in_a_gas_over_a_pool_weighs_on_neither(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim);
        c->resolution = 20;
        case_set_text(&c->gravity[1], "-4");
        case_add_fluid(c, "drop", 2, 40);
        case_add_fluid(c, "gas", 0.2, 40);
        case_add_fluid(c, "pool", 5, 40);
        for (int k = 0; k < 3; k++) case_set_text(&c->fluids[k].pressure, k ? "hydrostatic" : "laplace");
        case_set_text(&case_add_part(&c->fluids[2].shape, MNS_FORMULA)->formula, "y < -0.3");
        c->tension[0][1] = c->tension[1][0] = 0.7;
        c->scheme.name = "dissipation";           /* the Riemann scheme has no tension */
        c->tension[0][2] = c->tension[2][0] = 99; /* it does not touch */
        add_bubble(c, 0.77, 0.1, 0.6, 0.21);
        MnsSim *sim = sim_in_arrays(c);
        const Ball ball = measure(sim, 0.77, 0.1, 0.6, 0.3);
        assert_ball(sim, &ball, 0.2 * G * (0.5 - ball.centre[1]));
        for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
            const double y = sim->s.x[1][i];
            if (sim->s.phase[i] == 1) assert_close(sim->s.p[i], 0.2 * G * (0.5 - y), 1e-11);
            if (sim->s.phase[i] == 2) assert_close(sim->s.p[i], G * (0.2 * 0.8 + 5 * (-0.3 - y)), 1e-11);
        }
        sim_done(sim, c);
    }
}

static void bubbles_are_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    uint64_t hash = 0;
    for (unsigned threads = 1; threads <= 7; threads += 2) {
        MnsCase *c = bubbles(3, "hydrostatic");
        c->resolution = 20;
        c->threads = threads;
        case_set_text(&c->gravity[2], "-4");
        add_bubble(c, 0.6, -0.4, 0.5, 0.15);
        add_bubble(c, 1.02, 0.13, 0.8, 0.23);
        MnsSim *sim = sim_in_arrays(c);
        if (threads == 1) hash = mns_sim_hash(sim);
        assert_true(mns_sim_hash(sim) == hash);
        sim_done(sim, c);
    }
}

static void assert_refused(MnsCase *c, const char *word)
{
    MnsSim *sim = NULL;
    MnsError error = {0};
    assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
    assert_null(sim);
    assert_string_equal(error.path, "fluids[0].pressure");
    if (!strstr(error.text, word)) fail_msg("\"%s\" does not say \"%s\"", error.text, word);
    mns_case_free(c);
}

static void what_is_no_drop_in_another_fluid_is_refused_with_its_place(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = bubbles(dim, "0");
        add_bubble(c, 0.8, -0.1, 0.65, 0.26);
        case_set_text(&case_add_part(&c->fluids[1].shape, MNS_FORMULA)->formula, "y < -0.5");
        assert_refused(c, dim == 2 ? "gas of 24 particles about (0.8, -0.1, 0" : "touches no other fluid");
        c = bubbles(dim, "0");
        c->periodic[0] = true;
        c->walls[0].shape.parts[0].a[0] = -9;
        c->walls[0].shape.parts[0].b[0] = 9;
        case_set_text(&case_add_part(&c->fluids[0].shape, MNS_FORMULA)->formula, "y < -0.5 + 0.4*abs(x - 0.8)");
        assert_refused(c, "reaches around the periodic direction x to itself");
        c = bubbles(dim, "laplace");
        add_bubble(c, 0.8, -0.1, 0.65, 0.26);
        assert_refused(c, "gas lies in water at (0.8, -0.1, 0");
        c = bubbles(dim, "1/0");
        add_bubble(c, 0.8, -0.1, 0.65, 0.26);
        assert_refused(c, "is not finite");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layers_under_a_free_surface_bear_the_sum_of_those_above),
        cmocka_unit_test(fluid_under_a_block_has_the_pressure_of_its_height),
        cmocka_unit_test(closed_arm_of_a_siphon_is_under_the_pressure_of_the_other),
        cmocka_unit_test(chambers_that_are_not_joined_begin_with_zero_each),
        cmocka_unit_test(what_is_not_joined_to_a_pool_is_not_weighed_by_it),
        cmocka_unit_test(drop_without_weight_is_under_the_tension_of_its_surface),
        cmocka_unit_test(bubbles_are_under_the_pressure_of_their_height_and_water_does_not_feel_them),
        cmocka_unit_test(bubble_across_periodic_seams_is_one),
        cmocka_unit_test(drop_in_a_gas_over_a_pool_weighs_on_neither),
        cmocka_unit_test(bubbles_are_the_same_for_any_number_of_threads),
        cmocka_unit_test(what_is_no_drop_in_another_fluid_is_refused_with_its_place),
    };
    return cmocka_run_group_tests_name("start", tests, NULL, NULL);
}
