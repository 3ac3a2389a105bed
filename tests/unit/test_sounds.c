/* SPDX-License-Identifier: BSD-3-Clause */
/* What is warned of speeds of sound and background pressures: by which parts of a fluid are drops, by what the scheme holds, all of it
 * together, and again after a change. What a warning advises runs without one. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static void put(MnsPart *part, double x, double y, double radius)
{
    part->a[0] = x;
    part->a[1] = y;
    part->radius = radius;
}

/* Water and air of tension, in a box of 1 x 1 with or without periodic sides, and a wall around it where it has none. */
static MnsCase *case_tense(const char *scheme, bool periodic_x, bool periodic_y)
{
    MnsCase *c = case_blank(2, 40);
    const bool plain = strcmp(scheme, "interfacial") == 0;
    c->scheme.name = scheme;
    c->scheme.kernel = plain ? MNS_WENDLAND_C2 : MNS_TRUNCATED_GAUSSIAN;
    c->scheme.smoothing = plain ? 1.6 : 1.1;
    c->scheme.dissipation.repulsion = 0;
    c->scheme.dissipation.pair_average = MNS_AVERAGE_DENSITY;
    c->periodic[0] = periodic_x;
    c->periodic[1] = periodic_y;
    case_add_fluid(c, "water", 1000, 20);
    case_add_fluid(c, "air", 1, 20);
    c->tension[0][1] = c->tension[1][0] = 1;
    if (periodic_x && periodic_y) return c;
    case_add_wall(c, "box");
    c->walls[0].no_slip = true;
    MnsPart *box = case_add_part(&c->walls[0].shape, MNS_BOX);
    box->outside = true;
    for (int d = 0; d < 2; d++) {
        box->a[d] = c->periodic[d] ? -1 : 0;
        box->b[d] = c->periodic[d] ? 2 : 1;
    }
    box->a[2] = -1;
    box->b[2] = 1;
    return c;
}

/* Half of rho c^2/1.4 of the air. */
static void sounds(MnsCase *c, double water, double air)
{
    c->fluids[0].sound_speed = water;
    c->fluids[1].sound_speed = air;
    c->scheme.interfacial.background_pressure =
        0.5 * fmin(c->fluids[1].density * air * air / 1.4, 1000 * water * water / 7);
}

static void assert_quiet(const MnsSim *sim)
{
    for (size_t k = 0; mns_sim_warning(sim, k); k++)
        if (strstr(mns_sim_warning(sim, k), "sound_speed") || strstr(mns_sim_warning(sim, k), "background_pressure"))
            fail_msg("%s", mns_sim_warning(sim, k));
}

/* The air is always less than the water, so that a count of particles would call it a bubble. */
static void a_layer_and_what_is_around_a_drop_are_no_bubbles(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        MnsCase *c = case_tense("interfacial", k != 1, k == 2);
        MnsPart *water = case_add_part(&c->fluids[0].shape, k == 2 ? MNS_BALL : MNS_BOX);
        water->b[0] = 1;
        water->b[1] = 0.8;
        if (k == 2) put(water, 0.5, 0.5, 0.42);
        if (k == 3) { /* under a free surface, from wall to wall in no direction */
            MnsPart *air = case_add_part(&c->fluids[1].shape, MNS_BOX);
            c->periodic[0] = false;
            c->walls[0].shape.parts[0].a[0] = 0;
            c->walls[0].shape.parts[0].b[0] = 1;
            water->b[1] = 0.3;
            air->a[1] = 0.3;
            air->b[0] = 0.2;
            air->b[1] = 0.5;
        }
        sounds(c, 1, 1);
        MnsSim *sim = sim_of(c);
        assert_false(sim->start[1].drops || sim->start[1].most.capillary > 0);
        assert_int_equal(sim->start[0].drops, k == 2);
        assert_false(sim_warns(sim, "fluids[1].sound_speed: ") && k != 2);
        sim_done(sim, c);
    }
}

/* The lattice's discs have the area of theirs within 1 %. */
static void a_drop_that_a_floor_or_a_corner_cuts_has_the_radius_of_the_whole(void **state)
{
    (void)state;
    static const double at[][2] = {{0.5, 0.5}, {0.5, 0}, {0, 0.5}, {0, 0}, {1, 1}};
    for (size_t k = 0; k < sizeof at / sizeof *at; k++)
        for (int inside = 0; inside < 2; inside++) {
            MnsCase *c = case_tense("interfacial", false, false);
            put(case_add_part(&c->fluids[inside].shape, MNS_BALL), at[k][0], at[k][1], 0.4);
            MnsSim *sim = sim_of(c);
            assert_true(sim->start[inside].drops && !sim->start[!inside].drops);
            assert_close(sim->start[inside].most.across, 0.8, 0.01);
            assert_close(sim->start[inside].in[!inside].capillary, 1 / 0.4, 0.03);
            assert_false(sim->start[inside].most.bound);
            sim_done(sim, c);
        }
}

/* In space, from wall to wall or around a period in one direction. */
static void a_cylinder_in_space_has_its_own_radius(void **state)
{
    (void)state;
    for (int periodic = 0; periodic < 2; periodic++) {
        MnsCase *c = case_tense("interfacial", false, false);
        c->dim = 3;
        c->resolution = 16;
        c->max[2] = 0.5;
        c->periodic[2] = periodic;
        c->walls[0].shape.parts[0].a[2] = periodic ? -1 : 0;
        c->walls[0].shape.parts[0].b[2] = periodic ? 2 : 0.5;
        MnsPart *drop = case_add_part(&c->fluids[0].shape, MNS_CYLINDER);
        put(drop, 0.5, 0.5, 0.25);
        drop->a[2] = -1;
        drop->b[0] = drop->b[1] = 0.5;
        drop->b[2] = 2;
        MnsSim *sim = sim_of(c);
        assert_true(sim->start[0].drops);
        assert_close(sim->start[0].most.across, 0.5, 0.02);
        sim_done(sim, c);
    }
}

static void on_a_wall_that_is_not_flat_the_figure_is_said_to_be_a_bound(void **state)
{
    (void)state;
    MnsCase *c = case_tense("interfacial", false, false);
    MnsPart *slope = case_add_part(&c->walls[0].shape, MNS_HALF_SPACE);
    slope->a[0] = 0.5;
    slope->a[1] = 0.3;
    slope->b[0] = -0.5;
    slope->b[1] = 1;
    put(case_add_part(&c->fluids[0].shape, MNS_BALL), 0.5, 0.35, 0.2);
    sounds(c, 0.4, 20);
    MnsSim *sim = sim_of(c);
    assert_true(sim->start[0].most.bound);
    assert_true(sim_warns(sim, "m/s would be enough at most, as it lies on a wall that is not flat"));
    sim_done(sim, c);
}

/* Of a bubble of 4 mm, as a new user writes it. */
static MnsCase *case_bubble(const char *scheme, double water, double air)
{
    MnsCase *c = case_tense(scheme, false, false);
    c->resolution = 4e3;
    for (int d = 0; d < 2; d++) c->max[d] = c->walls[0].shape.parts[0].b[d] = 0.01;
    put(case_add_part(&c->fluids[1].shape, MNS_BALL), 0.005, 0.005, 0.002);
    c->tension[0][1] = c->tension[1][0] = 0.072;
    c->fluids[1].density = 1.2;
    c->end_time = 1e-3;
    case_set_text(&c->gravity[1], "-9.81");
    sounds(c, water, air);
    return c;
}

/* By less than a half of the air's, which the scheme dissipation refuses. */
static void sounds_that_depend_on_each_other_are_advised_together(void **state)
{
    (void)state;
    MnsCase *c = case_bubble("dissipation", 5, 10);
    MnsSim *sim = sim_of(c);
    assert_true(sim_warns(sim, "fluids[1].sound_speed: 10 m/s is less than ten times sqrt(sigma/(rho R)) of air, "));
    assert_true(sim_warns(sim, "; 55 m/s would be enough, together with fluids[0].sound_speed of 28 m/s, by what the "
                               "scheme dissipation holds"));
    assert_false(sim_warns(sim, "fluids[0].sound_speed: 5"));
    sim_done(sim, c);
    c = case_bubble("dissipation", 28, 55);
    sim = sim_of(c);
    assert_quiet(sim);
    sim_done(sim, c);
    c = case_bubble("interfacial", 5, 10); /* which holds any */
    sim = sim_of(c);
    assert_true(sim_warns(sim, "; 55 m/s would be enough"));
    assert_false(sim_warns(sim, "together"));
    sim_done(sim, c);
}

static MnsCase *case_drop(double water, double air, double background)
{
    MnsCase *c = case_bubble("interfacial", water, air);
    case_set_text(&c->gravity[1], "0");
    c->fluids[0].density = 1.2;
    c->fluids[1].density = 1000;
    c->scheme.interfacial.background_pressure = background;
    return c;
}

/* Fluid 0 is the air, which is around. */
static void a_background_pressure_is_advised_for_the_sounds_that_are_advised(void **state)
{
    (void)state;
    static const struct {
        double air, water, background;
        bool of_sound;
        const char *background_says; /* NULL: nothing */
    } rows[] = {
        {1, 1, 90, true, "90 Pa is more than rho c^2/exponent of water"},
        {1, 1, 4.8, true, NULL}, /* more than 0.86 Pa of now, and right after */
        {3.3, 1.9, 0, false, "0 Pa leaves water, the softest fluid, less than a tenth of rho c^2/(2 exponent), "},
        {3.3, 1.9, 0.3, false, "0.3 Pa leaves water"},
        {3.3, 1.9, 0.5, false, NULL},
        {3.3, 1.9, 4.6, false, NULL},
        {3.3, 1.9, 9.5, false, "9.5 Pa is more than"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *c = case_drop(rows[k].air, rows[k].water, rows[k].background);
        MnsSim *sim = sim_of(c);
        assert_int_equal(sim_warns(sim, "fluids[1].sound_speed: 1 m/s is less than ten times"), rows[k].of_sound);
        assert_int_equal(sim_warns(sim, "fluids[0].sound_speed: 1 m/s is less than 0.6 times"), rows[k].of_sound);
        if (rows[k].background_says && k > 0) assert_true(sim_warns(sim, rows[k].background_says));
        assert_int_equal(sim_warns(sim, "background_pressure: "), rows[k].background_says != NULL);
        if (rows[k].of_sound) {
            assert_true(sim_warns(sim, "; 1.9 m/s would be enough") && sim_warns(sim, "; 3.3 m/s would be enough"));
        }
        if (k == 0) assert_true(sim_warns(sim, "; 4.6 Pa would be enough"));
        sim_done(sim, c);
    }
}

/* Neither the scheme dissipation, whose gases feel no even pressure below zero, nor fluids without tension. */
static void no_background_pressure_is_asked_for_where_none_is_needed(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        MnsCase *c = case_bubble(k ? "interfacial" : "dissipation", 40, 55);
        if (k) c->tension[0][1] = c->tension[1][0] = 0;
        c->scheme.interfacial.background_pressure = 0;
        MnsSim *sim = sim_of(c);
        assert_quiet(sim);
        sim_done(sim, c);
    }
}

static MnsCase *case_heavy(const char *gravity)
{
    MnsCase *c = case_tense("interfacial", true, false);
    MnsPart *water = case_add_part(&c->fluids[0].shape, MNS_BOX);
    water->b[0] = 1;
    water->b[1] = 0.5;
    sounds(c, 20, 20);
    case_set_text(&c->gravity[1], gravity);
    return c;
}

static size_t count_warnings(const MnsSim *sim)
{
    size_t n = 0;
    while (mns_sim_warning(sim, n)) n++;
    return n;
}

/* And not once more for what was said, but for what has become worse. */
static void gravity_that_is_set_is_looked_at(void **state)
{
    (void)state;
    static const struct {
        const char *gravity;
        size_t said;
    } rows[] = {{"-1", 0}, {"-20", 2}, {"-20", 2}, {"-20.5", 2}, {"-1", 2}, {"-20", 2}, {"-40", 4}, {"20", 4}};
    MnsCase *last = case_heavy("0");
    MnsSim *sim = sim_of(last);
    assert_quiet(sim);
    const size_t before = count_warnings(sim);
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *next = case_heavy(rows[k].gravity);
        assert_int_equal(mns_sim_steer(sim, next, NULL), MNS_OK);
        mns_case_free(last);
        last = next;
        sim_steps(sim, 1);
        assert_int_equal(count_warnings(sim), before + rows[k].said);
    }
    assert_true(sim_warns(sim, "fluids[0].sound_speed: 20 m/s is less than ten times sqrt(g H) of water, 0.5 m high"));
    sim_done(sim, last);
}

/* As high as the fluids were at the start, wherever they are now. */
static void a_resumed_run_is_looked_at(void **state)
{
    (void)state;
    for (int heavy = 0; heavy < 2; heavy++) {
        MnsCase *c = case_heavy("-1"), *again = case_heavy(heavy ? "-20" : "-1");
        MnsSim *sim = sim_of(c), *resumed = NULL;
        MnsCapture *capture;
        sim_steps(sim, 2);
        assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
        assert_int_equal(mns_sim_resume(again, capture, &resumed, NULL), MNS_OK);
        if (heavy)
            assert_true(sim_warns(resumed, "of water, 0.5 m high: it may be compressed; 32 m/s would be enough"));
        else assert_quiet(resumed);
        mns_capture_free(capture);
        sim_done(sim, c);
        sim_done(resumed, again);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_layer_and_what_is_around_a_drop_are_no_bubbles),
        cmocka_unit_test(a_drop_that_a_floor_or_a_corner_cuts_has_the_radius_of_the_whole),
        cmocka_unit_test(a_cylinder_in_space_has_its_own_radius),
        cmocka_unit_test(on_a_wall_that_is_not_flat_the_figure_is_said_to_be_a_bound),
        cmocka_unit_test(sounds_that_depend_on_each_other_are_advised_together),
        cmocka_unit_test(a_background_pressure_is_advised_for_the_sounds_that_are_advised),
        cmocka_unit_test(no_background_pressure_is_asked_for_where_none_is_needed),
        cmocka_unit_test(gravity_that_is_set_is_looked_at),
        cmocka_unit_test(a_resumed_run_is_looked_at),
    };
    return cmocka_run_group_tests_name("sounds", tests, NULL, NULL);
}
