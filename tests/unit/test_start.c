/* SPDX-License-Identifier: BSD-3-Clause */
/* Fluids at rest start at rest: under their own weight in layers, wherever walls are in between. */
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
            MnsSim *sim = sim_of(c);
            assert_layers(sim, k / 2, k % 2);
            sim_done(sim, c);
        }
}

/* A block that reaches through all layers but the highest and another that is wholly in one, with a gap to the sides: below them
 * the pressure is that of the height. Across a periodic seam too. */
static void fluid_under_a_block_has_the_pressure_of_its_height(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 4 * dim; k++) {
            const int axis = k / 4, other = (axis + 1) % dim;
            const bool down = k % 2, around = k / 2 % 2;
            MnsCase *c = tank(dim);
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
            a[axis] = down ? c->min[axis] + 0.1 : c->max[axis] - 0.2;
            b[axis] = a[axis] + 0.1;
            a[other] = c->min[other] + 0.6;
            b[other] = a[other] + 0.2;
            add_box(&c->walls[1].shape, dim, a, b);
            MnsSim *sim = sim_of(c);
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
            const double a[3] = {0.7, -0.5, 0.2}, b[3] = {0.9, 0.5, 1.1}, e[3] = {0.9, -0.2, 0.2},
                         f[3] = {1.3, 0.5, 1.1};
            add_box(&c->walls[0].shape, dim, a, b);
            add_box(&c->walls[0].shape, dim, e, f);
            case_set_text(&c->gravity[1], "-4");
            case_add_fluid(c, "water", 5, 40);
            if (!lid) case_set_text(&case_add_part(&c->fluids[0].shape, MNS_FORMULA)->formula, "y < 0.3");
            case_set_text(&c->fluids[0].pressure, "hydrostatic");
            MnsSim *sim = sim_of(c);
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
        MnsSim *sim = sim_of(c);
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
    MnsSim *sim = sim_of(c);
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        const double y = sim->s.x[1][i];
        assert_close(sim->s.p[i], 5 * 4 * ((y > 0 ? 0.3 : -0.3) - y), 1e-11);
    }
    sim_done(sim, c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layers_under_a_free_surface_bear_the_sum_of_those_above),
        cmocka_unit_test(fluid_under_a_block_has_the_pressure_of_its_height),
        cmocka_unit_test(closed_arm_of_a_siphon_is_under_the_pressure_of_the_other),
        cmocka_unit_test(chambers_that_are_not_joined_begin_with_zero_each),
        cmocka_unit_test(what_is_not_joined_to_a_pool_is_not_weighed_by_it),
    };
    return cmocka_run_group_tests_name("start", tests, NULL, NULL);
}
