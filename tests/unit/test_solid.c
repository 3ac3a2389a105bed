/* SPDX-License-Identifier: BSD-3-Clause */
/* A wall through which fluids on its two sides would push each other is refused, however it is told; edges, tips and walls with fluid on one side
 * are not. The kernel's support is 0.26 m, the spacing 0.1 m. */
#include "sim/solid.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <math.h>
#include <string.h>

/* A tank of 2 x 1 (x 1) m, full of water, and a wall in it that has no shape as yet. */
static MnsCase *tank(int dim)
{
    MnsCase *c = case_blank(dim, 10);
    c->max[0] = 2;
    case_add_fluid(c, "water", 1, 10);
    case_add_wall(c, "tank");
    MnsPart *box = case_add_part(&c->walls[0].shape, MNS_BOX);
    box->outside = true;
    for (int d = 0; d < 3; d++) box->b[d] = c->max[d];
    case_add_wall(c, "dam");
    return c;
}

/* A box from x = low to high across the tank. */
static void add_box(MnsShape *shape, double low, double high)
{
    case_put_part(3, shape, (MnsPart){.primitive = MNS_BOX, .a = {low, -1, -1}, .b = {high, 2, 2}});
}

static void box(MnsCase *c, double thickness)
{
    add_box(&c->walls[1].shape, 1, 1 + thickness);
}
static void plate(MnsCase *c, double thickness)
{
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_PLATE,
                            .a = {1, 0.5, 0.5},
                            .b = {0.5, 1, 0},
                            .c = {2, -1, 0},
                            .length = 0.7,
                            .width = 2,
                            .thickness = thickness});
}
static void cylinder(MnsCase *c, double thickness) /* a slab in two dimensions, a post in three */
{
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_CYLINDER, .a = {1, -1, 0.5}, .b = {1, 2, 0.5}, .radius = 0.5 * thickness});
}
static void ball(MnsCase *c, double thickness)
{
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_BALL, .a = {1.02, 0.5, 0.51}, .radius = 0.5 * thickness});
}
static void ring(MnsCase *c, double thickness)
{
    case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BALL, .a = {1, 0.5, 0.5}, .radius = 0.45});
    case_put_part(
        c->dim, &c->walls[1].shape,
        (MnsPart){.operation = MNS_SUBTRACT, .primitive = MNS_BALL, .a = {1, 0.5, 0.5}, .radius = 0.45 - thickness});
}
static void difference(MnsCase *c, double thickness)
{
    add_box(&c->walls[1].shape, 0.63, 1.5);
    add_box(&c->walls[1].shape, 0.63 + thickness, 1.6);
    c->walls[1].shape.parts[1].operation = MNS_SUBTRACT;
}
static void layers(MnsCase *c, double thickness) /* of three walls that touch or share what is between */
{
    add_box(&c->walls[1].shape, 1, 1 + 0.4 * thickness);
    case_add_wall(c, "layer");
    add_box(&c->walls[2].shape, 1 + 0.4 * thickness, 1 + 0.7 * thickness);
    case_add_wall(c, "other layer");
    add_box(&c->walls[3].shape, 1 + 0.5 * thickness, 1 + thickness);
}
static void periodic(MnsCase *c, double thickness) /* half of it on each side of the domain */
{
    c->periodic[0] = true;
    c->walls[0].shape.parts[0].a[0] = -1;
    c->walls[0].shape.parts[0].b[0] = 3;
    add_box(&c->walls[1].shape, -0.4 * thickness, 0.6 * thickness);
}

/* Of a wall, or two, of the k-th shape and this thickness or distance: as too thin, with place and remedy, or not at all. */
static void check_refused(MnsCase *c, bool refused, size_t k, double size)
{
    MnsSim *sim = NULL;
    MnsError error = {0};
    const MnsStatus status = mns_sim_new(c, &sim, &error);
    const bool too_thin = status == MNS_E_INVALID && strncmp(error.path, "walls[", 6) == 0 &&
                          strstr(error.text, "m thick near (") && strstr(error.text, "support, 0.26 m");
    if (refused ? !too_thin : status != MNS_OK)
        fail_msg("%d, shape %zu, %g: %s, %s, %s", c->dim, k, size, mns_status_name(status), error.path, error.text);
    mns_sim_free(sim);
    mns_case_free(c);
}

static void walls_thinner_than_the_support_are_refused_whatever_they_are_made_of(void **state)
{
    (void)state;
    static void (*const walls[])(MnsCase * c, double thickness) = {box,  plate,      cylinder, ball,
                                                                   ring, difference, layers,   periodic};
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < sizeof walls / sizeof *walls; k++)
            for (int q = 0; q < 5; q++) {
                static const double thickness[] = {0.06, 0.1, 0.2, 0.2595, 0.2605};
                if (q == 0 && (walls[k] == ball || (walls[k] == cylinder && dim == 3))) continue; /* no particle */
                MnsCase *c = tank(dim);
                walls[k](c, thickness[q]);
                check_refused(c, q < 4, k, thickness[q]);
            }
}

static void place_and_thickness_of_a_thin_wall_are_said(void **state)
{
    (void)state;
    MnsCase *c = tank(2);
    MnsSim *sim = NULL;
    MnsError error = {0};
    box(c, 0.13);
    assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
    assert_string_equal(error.path, "walls[1].shape");
    if (!strstr(error.text, "dam is 0.13 m thick near (1.065, 0.05, 0) m")) fail_msg("%s", error.text);
    mns_case_free(c);
}

/* Emptiness is room: what is there now may be elsewhere soon. */
static void room_counts_as_fluid(void **state)
{
    (void)state;
    MnsCase *c = tank(2);
    MnsSim *sim = NULL;
    box(c, 0.2);
    add_box(&c->fluids[0].shape, 0, 1);
    assert_int_equal(mns_sim_new(c, &sim, NULL), MNS_E_INVALID);
    mns_case_free(c);
}

static void on_the_floor(MnsCase *c) /* what is below it is the tank's */
{
    case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BOX, .a = {0.5, -0.1, -1}, .b = {1, 0.1, 2}});
}
static void floor_with_nothing_below(MnsCase *c)
{
    c->walls[0].shape.parts[0].a[1] = -1;
    case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BOX, .a = {-1, -0.2, -1}, .b = {3, 0, 2}});
}
static void plate_with_an_end(MnsCase *c)
{
    plate(c, 0.261);
}
static void step(MnsCase *c)
{
    case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BOX, .a = {0.93, -1, -1}, .b = {3, 0.4, 2}});
}
static void block(MnsCase *c) /* with edges that are free */
{
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_BOX, .a = {0.8, 0.3, 0.3}, .b = {1.1, 0.61, 0.72}});
}
static void bow(MnsCase *c) /* 45 degrees, its edge in the water */
{
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_HALF_SPACE, .a = {0.7, 0.5, 0}, .b = {-1, 2.41421356, 0}});
    case_put_part(
        c->dim, &c->walls[1].shape,
        (MnsPart){
            .operation = MNS_INTERSECT, .primitive = MNS_HALF_SPACE, .a = {0.7, 0.5, 0}, .b = {-1, -2.41421356, 0}});
}
static void lens(MnsCase *c)
{
    case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BALL, .a = {1, 0.2, 0.5}, .radius = 0.5});
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.operation = MNS_INTERSECT, .primitive = MNS_BALL, .a = {1, 0.8, 0.5}, .radius = 0.5});
}
static void gap(MnsCase *c) /* too narrow for particles, between two that are too thin only by themselves */
{
    add_box(&c->walls[1].shape, 1, 1.16);
    case_add_wall(c, "other");
    add_box(&c->walls[2].shape, 1.161, 1.3);
}
static void wall_of_a_channel_as_wide_as_a_particle(MnsCase *c)
{
    add_box(&c->walls[1].shape, 0.9, 1.2);
    add_box(&c->walls[1].shape, 1.3, 1.6);
}

static void edges_tips_and_walls_with_fluid_on_one_side_are_not_refused(void **state)
{
    (void)state;
    static void (*const walls[])(MnsCase * c) = {on_the_floor,
                                                 floor_with_nothing_below,
                                                 plate_with_an_end,
                                                 step,
                                                 block,
                                                 bow,
                                                 lens,
                                                 gap,
                                                 wall_of_a_channel_as_wide_as_a_particle};
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < sizeof walls / sizeof *walls; k++) {
            MnsCase *c = tank(dim);
            MnsSim *sim = NULL;
            MnsError error = {0};
            walls[k](c);
            if (mns_sim_new(c, &sim, &error)) fail_msg("%d, wall %zu: %s", dim, k, error.text);
            mns_sim_free(sim);
            mns_case_free(c);
        }
}

/* Two corners at (1, 0.5), as far apart as is said, or over each other by as much where that is negative. */
static void corners(MnsCase *c, double apart)
{
    const MnsPart left = {.primitive = MNS_BOX, .a = {0.3, -1, -1}, .b = {1 - apart, 0.5, 2}};
    const MnsPart right = {.primitive = MNS_BOX, .a = {1, 0.5, -1}, .b = {1.7, 2, 2}};
    case_put_part(c->dim, &c->walls[1].shape, left);
    case_put_part(c->dim, &c->walls[1].shape, right);
}
static void corners_of_two_walls_off_the_lattice(MnsCase *c, double apart)
{
    const MnsPart left = {.primitive = MNS_BOX, .a = {0.3, -1, -1}, .b = {1.033 - apart, 0.527, 2}};
    const MnsPart right = {.primitive = MNS_BOX, .a = {1.033, 0.527, -1}, .b = {1.7, 2, 2}};
    case_put_part(c->dim, &c->walls[1].shape, left);
    case_add_wall(c, "other");
    case_put_part(c->dim, &c->walls[2].shape, right);
}
static void corners_at_a_point_of_the_lattice(MnsCase *c, double apart)
{
    const MnsPart left = {.primitive = MNS_BOX, .a = {0.3, -1, -1}, .b = {1.05 - apart, 0.55, 2}};
    const MnsPart right = {.primitive = MNS_BOX, .a = {1.05, 0.55, -1}, .b = {1.7, 2, 2}};
    case_put_part(c->dim, &c->walls[1].shape, left);
    case_put_part(c->dim, &c->walls[1].shape, right);
}
static void corner_on_the_floor(MnsCase *c, double apart) /* of a square that stands on it */
{
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_PLATE,
                            .a = {1, 0.5 + apart, 0.5},
                            .b = {1, 1, 0},
                            .c = {1, -1, 0},
                            .length = 0.70710678,
                            .width = 5,
                            .thickness = 0.70710678});
}
static void rooms_that_meet(MnsCase *c, double apart) /* at their corners, in a solid */
{
    add_box(&c->walls[1].shape, -1, 3);
    const MnsPart left = {
        .operation = MNS_SUBTRACT, .primitive = MNS_BOX, .a = {0.3, 0.2, -1}, .b = {1 + apart, 0.5, 2}};
    const MnsPart right = {.operation = MNS_SUBTRACT, .primitive = MNS_BOX, .a = {1, 0.5, -1}, .b = {1.7, 0.8, 2}};
    case_put_part(c->dim, &c->walls[1].shape, left);
    case_put_part(c->dim, &c->walls[1].shape, right);
}
/* As thick as they must be, from side to side of a tank of 3 m, with points of the lattice above and below the neck. */
static void corners_of_walls_that_lean(MnsCase *c, double apart)
{
    const double t = 0.261, r = sqrt(0.5);
    MnsPart low = {.primitive = MNS_PLATE, .b = {1, 1, 0}, .c = {-1, 1, 0}, .length = 3, .width = 5, .thickness = t};
    MnsPart high = low;
    for (int d = 0; d < 2; d++) {
        const double neck = d ? 0.5 : 0.95, across = (d ? r : -r) * 0.5 * t;
        low.a[d] = neck - r * (1.5 + apart) + across;
        high.a[d] = neck + r * 1.5 - across;
    }
    c->min[1] = c->walls[0].shape.parts[0].a[1] = -1;
    c->max[1] = c->walls[0].shape.parts[0].b[1] = 2;
    case_put_part(c->dim, &c->walls[1].shape, low);
    case_put_part(c->dim, &c->walls[1].shape, high);
}

static void necks_between_corners_are_refused(void **state)
{
    (void)state;
    static void (*const necks[])(MnsCase * c, double apart) = {corners,
                                                               corners_of_two_walls_off_the_lattice,
                                                               corners_at_a_point_of_the_lattice,
                                                               corner_on_the_floor,
                                                               rooms_that_meet,
                                                               corners_of_walls_that_lean};
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < sizeof necks / sizeof *necks; k++)
            for (int q = 0; q < 6; q++) {
                static const double apart[] = {-0.05, -0.01, 0, 1e-6, 0.3, 0.015};
                if (dim == 3 && q % 2 && !check_at_length()) continue;
                MnsCase *c = tank(dim);
                necks[k](c, apart[q]);
                check_refused(c, apart[q] < 0.1, k, apart[q]);
            }
}

static void place_and_thickness_of_a_neck_are_said(void **state)
{
    (void)state;
    MnsCase *c = tank(2);
    MnsError error = {0};
    MnsSim *sim = NULL;
    corners(c, 0);
    assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
    assert_string_equal(error.path, "walls[1].shape");
    if (!strstr(error.text, "dam is 0 m thick near (1, 0.5, 0) m")) fail_msg("%s", error.text);
    mns_case_free(c);
}

static void letter_l(MnsCase *c)
{
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_BOX, .a = {0.6, 0.31, -1}, .b = {0.87, 0.8, 2}});
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_BOX, .a = {0.6, 0.31, -1}, .b = {1.4, 0.58, 2}});
}
static void letter_t_that_leans(MnsCase *c)
{
    const MnsPart bar = {.primitive = MNS_PLATE, .b = {2, 1, 0}, .c = {1, -2, 0}, .width = 5, .thickness = 0.27};
    MnsPart top = bar, foot = bar;
    for (int d = 0; d < 2; d++) {
        top.a[d] = d ? 0.6 : 1.2;
        foot.a[d] = d ? 0.4 : 1.3;
        foot.b[d] = bar.c[d];
        foot.c[d] = bar.b[d];
    }
    top.length = 0.6;
    foot.length = 0.4;
    case_put_part(c->dim, &c->walls[1].shape, top);
    case_put_part(c->dim, &c->walls[1].shape, foot);
}
static void cross(MnsCase *c) /* of four rooms */
{
    add_box(&c->walls[1].shape, 0.9, 1.1601);
    case_put_part(c->dim, &c->walls[1].shape, (MnsPart){.primitive = MNS_BOX, .a = {-1, 0.4, -1}, .b = {3, 0.6601, 2}});
}
static void fin(MnsCase *c) /* less than a support high, its tip in the water */
{
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_HALF_SPACE, .a = {1, 0.3, 0}, .b = {2.41421356, 1, 0}});
    case_put_part(
        c->dim, &c->walls[1].shape,
        (MnsPart){.operation = MNS_INTERSECT, .primitive = MNS_HALF_SPACE, .a = {1, 0.3, 0}, .b = {-2.41421356, 1, 0}});
}
static void roller(MnsCase *c) /* on the floor */
{
    if (c->dim == 2)
        case_put_part(2, &c->walls[1].shape, (MnsPart){.primitive = MNS_BALL, .a = {1, 0.4}, .radius = 0.4});
    else
        case_put_part(3, &c->walls[1].shape,
                      (MnsPart){.primitive = MNS_CYLINDER, .a = {1, 0.4, -1}, .b = {1, 0.4, 2}, .radius = 0.4});
}
static void neck_with_room_on_one_side(MnsCase *c)
{
    corners(c, 0);
    add_box(&c->walls[1].shape, 1, 3);
}
static void channel_that_leans(MnsCase *c) /* and has a bend, as wide as a particle */
{
    add_box(&c->walls[1].shape, -1, 3);
    for (int k = 0; k < 2; k++)
        case_put_part(c->dim, &c->walls[1].shape,
                      (MnsPart){.operation = MNS_SUBTRACT,
                                .primitive = MNS_PLATE,
                                .a = {k ? 1.24 : 0.76, 0.5, 0.5},
                                .b = {1, k ? -1 : 1, 0},
                                .c = {k ? 1 : -1, 1, 0},
                                .length = 0.8,
                                .width = 0.6,
                                .thickness = 0.11});
}

static void walls_that_meet_without_a_neck_are_not_refused(void **state)
{
    (void)state;
    static void (*const walls[])(MnsCase * c) = {
        letter_l, letter_t_that_leans, cross, fin, roller, neck_with_room_on_one_side, channel_that_leans};
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < sizeof walls / sizeof *walls; k++) {
            MnsCase *c = tank(dim);
            MnsSim *sim = NULL;
            MnsError error = {0};
            walls[k](c);
            if (mns_sim_new(c, &sim, &error)) fail_msg("%d, wall %zu: %s", dim, k, error.text);
            mns_sim_free(sim);
            mns_case_free(c);
        }
}

/* In space the fluid goes around a corner that touches another one at a point alone. */
static void corners_that_touch_at_a_point_in_space_are_not_refused(void **state)
{
    (void)state;
    MnsCase *c = tank(3);
    MnsSim *sim = NULL;
    MnsError error = {0};
    case_put_part(3, &c->walls[1].shape, (MnsPart){.primitive = MNS_BOX, .a = {0.3, -1, -1}, .b = {1, 0.5, 0.5}});
    case_put_part(3, &c->walls[1].shape, (MnsPart){.primitive = MNS_BOX, .a = {1, 0.5, 0.5}, .b = {1.7, 2, 2}});
    if (mns_sim_new(c, &sim, &error)) fail_msg("%s", error.text);
    mns_sim_free(sim);
    mns_case_free(c);
}

/* A channel with room for one row: midway, no side is nearer than the other, and both are looked at. */
static void thin_walls_of_a_narrow_channel_are_refused(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int right = 0; right < 2; right++) {
            MnsCase *c = tank(dim);
            MnsSim *sim = NULL;
            add_box(&c->walls[1].shape, right ? 0.8 : 1, 1.2);
            add_box(&c->walls[1].shape, 1.3, right ? 1.5 : 1.7);
            assert_int_equal(mns_sim_new(c, &sim, NULL), MNS_E_INVALID);
            mns_case_free(c);
        }
}

/* A floor of two walls side by side, which meet at x = 1: one of the tank itself, so that the seam is nearer than the water. */
static void seam_between_two_walls_is_no_surface(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim);
        double to[3];
        const MnsPart left = {.operation = MNS_SUBTRACT, .primitive = MNS_BOX, .a = {1, -9, -9}, .b = {9, 9, 9}},
                      right = {.operation = MNS_SUBTRACT, .primitive = MNS_BOX, .a = {-9, -9, -9}, .b = {1, 9, 9}};
        case_put_part(3, &c->walls[1].shape, c->walls[0].shape.parts[0]);
        case_put_part(3, &c->walls[1].shape, right);
        case_put_part(3, &c->walls[0].shape, left);
        MnsSim *sim = sim_in_arrays(c);
        for (size_t wall = 0; wall < 2; wall++) {
            const double x[3] = {wall == 0 ? 0.98 : 1.02, -0.05, dim == 3 ? 0.5 : 0};
            solid_to_surface(sim, x, wall, to);
            assert_close(to[0], 0, 1e-6);
            assert_close(to[1], 0.05, 1e-6);
            assert_close(to[2], 0, 1e-6);
        }
        sim_done(sim, c);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walls_thinner_than_the_support_are_refused_whatever_they_are_made_of),
        cmocka_unit_test(place_and_thickness_of_a_thin_wall_are_said),
        cmocka_unit_test(room_counts_as_fluid),
        cmocka_unit_test(edges_tips_and_walls_with_fluid_on_one_side_are_not_refused),
        cmocka_unit_test(necks_between_corners_are_refused),
        cmocka_unit_test(place_and_thickness_of_a_neck_are_said),
        cmocka_unit_test(walls_that_meet_without_a_neck_are_not_refused),
        cmocka_unit_test(corners_that_touch_at_a_point_in_space_are_not_refused),
        cmocka_unit_test(thin_walls_of_a_narrow_channel_are_refused),
        cmocka_unit_test(seam_between_two_walls_is_no_surface),
    };
    return cmocka_run_group_tests_name("solid", tests, NULL, NULL);
}
