/* SPDX-License-Identifier: BSD-3-Clause */
/* The right particles are in view, within the right bounds, on the right scale. */
#include "client/cli/render_raster.h"
#include "client/cli/render_scale.h"
#include "tests/support/render_fixture.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#define assert_near(a, b) assert_true(fabs((a) - (b)) < 1e-9)

static const ViewOptions plain = {.at = NAN};

static View view_of(const Frame *frame, ViewOptions options)
{
    View view;
    MnsError error;
    assert_int_equal(view_make(frame, &options, &view, &error), MNS_OK);
    return view;
}

static void bounds_hold_the_whole_volume_of_the_fluid(void **state)
{
    (void)state;
    Frame frame = tank_frame(2, 10);
    View view = view_of(&frame, plain);
    assert_int_equal(view.n, 200);
    assert_near(view.lo[0], 0);
    assert_near(view.hi[0], 2);
    assert_near(view.lo[1], 0);
    assert_near(view.hi[1], 1);
    view_done(&view);
    frame_done(&frame);
}

/* Tiles are half a spacing wide, particles move, and some leave: pictures of one run have one frame all the same. */
static void bounds_are_those_of_the_domain_wherever_the_particles_are(void **state)
{
    (void)state;
    Frame frame = tank_frame(2, 10);
    for (size_t i = 0; i < frame.n_fluid; i++) frame.x[i][0] = 0.5 + 0.75 * frame.x[i][0];
    View view = view_of(&frame, plain);
    assert_near(view.lo[0], 0);
    assert_near(view.hi[0], 2);
    assert_near(view.clip_lo[0], 0);
    assert_near(view.clip_hi[1], 1);
    view_done(&view);
    frame.has_domain = false;
    view = view_of(&frame, plain);
    assert_near(view.hi[0], 0.5 + 0.75 * 1.95 + 0.05);
    assert_true(isinf(view.clip_hi[0]));
    view_done(&view);
    frame_done(&frame);
}

static void walls_are_in_view_only_if_asked_for(void **state)
{
    (void)state;
    Frame frame = tank_frame(2, 10);
    View view = view_of(&frame, (ViewOptions){.at = NAN, .walls = true});
    assert_int_equal(view.n, 220);
    assert_near(view.lo[1], -0.1);
    view_done(&view);
    frame_done(&frame);
}

static void particles_without_a_value_are_skipped_and_counted(void **state)
{
    (void)state;
    Frame frame = tank_frame(2, 10);
    frame.value[7] = NAN;
    frame.value[8] = INFINITY;
    frame.x[9][1] = NAN;
    View view = view_of(&frame, plain);
    assert_int_equal(view.skipped, 3);
    assert_int_equal(view.n, 197);
    view_done(&view);
    frame_done(&frame);
}

static void three_dimensions_are_cut_through_the_middle_of_the_thinnest(void **state)
{
    (void)state;
    Frame frame = tank_frame(3, 10);
    View view = view_of(&frame, plain);
    assert_int_equal(view.axis, 2);
    assert_near(view.at, 0.25);
    assert_int_equal(view.axis_u, 0);
    assert_int_equal(view.axis_v, 1);
    view_done(&view);
    frame_done(&frame);
}

static void a_slab_holds_the_particles_within_its_thickness(void **state)
{
    (void)state;
    Frame frame = tank_frame(3, 10);
    View view = view_of(&frame, (ViewOptions){.kind = VIEW_CUT, .axis = 0, .at = 1.0, .thickness = 0.21});
    assert_int_equal(view.n, 2 * 10 * 5);
    assert_int_equal(view.axis_u, 2);
    assert_int_equal(view.axis_v, 1);
    view_done(&view);
    frame_done(&frame);
}

static void a_projection_shows_the_heavy_fluid_from_above(void **state)
{
    (void)state;
    Frame frame = tank_frame(3, 10);
    View view = view_of(&frame, (ViewOptions){.kind = VIEW_PROJECTION, .axis = 1, .at = NAN});
    assert_int_equal(view.n, 500);
    assert_int_equal(view.fluids, 1);
    for (size_t k = 0; k < view.n; k++) {
        assert_near(view.dots[k].depth, frame.x[view.dots[k].particle][1]);
        assert_near(view.dots[k].v, -frame.x[view.dots[k].particle][2]);
    }
    assert_near(view.lo[1], -0.5);
    assert_near(view.hi[1], 0);
    view_done(&view);
    frame_done(&frame);
}

/* Up on the page is against gravity, wherever the fluids are at the moment. */
static void where_gravity_points_is_down(void **state)
{
    (void)state;
    Frame frame = tank_frame(3, 10);
    frame.gravity[1] = 0;
    frame.gravity[2] = -9.81;
    View view = view_of(&frame, (ViewOptions){.kind = VIEW_PROJECTION, .axis = 1, .at = NAN});
    assert_int_equal(view.axis_v, 2);
    assert_false(view.v_is_down);
    for (size_t k = 0; k < view.n; k++) assert_near(view.dots[k].depth, -frame.x[view.dots[k].particle][1]);
    view_done(&view);
    frame_done(&frame);
}

/* To the right, up and towards the eye are a right-handed system: a mirror image would be another flow. */
static void no_view_is_a_mirror_image(void **state)
{
    (void)state;
    for (int k = 0; k < 9; k++) {
        Frame frame = tank_frame(3, 10);
        frame.gravity[1] = k / 3 == 0 ? -1 : 0;
        frame.gravity[2] = k / 3 == 1 ? -1 : 0;
        View view = view_of(&frame, (ViewOptions){.kind = VIEW_PROJECTION, .axis = k % 3, .at = NAN});
        double right[3] = {0}, up[3] = {0}, eye[3];
        right[view.axis_u] = 1;
        up[view.axis_v] = view.v_is_down ? -1 : 1;
        for (int d = 0; d < 3; d++)
            eye[d] = right[(d + 1) % 3] * up[(d + 2) % 3] - right[(d + 2) % 3] * up[(d + 1) % 3];
        for (int d = 0; d < 3; d++) assert_near(eye[d], d != view.axis ? 0 : view.eye_is_low ? -1 : 1);
        view_done(&view);
        frame_done(&frame);
    }
}

static void a_vector_is_read_from_the_text_of_a_case(void **state)
{
    (void)state;
    double v[3] = {7, 7, 7};
    assert_int_equal(frame_vector("[0, -9.81]", v), 2);
    assert_true(v[0] == 0 && v[1] == -9.81 && v[2] == 7);
    assert_int_equal(frame_vector("[\"1e-3\", \"-2*sin(t)\", \"0\"]", v), 3);
    assert_true(v[0] == 1e-3 && v[1] == -2 && v[2] == 0);
    assert_int_equal(frame_vector("[]", v), 0);
    assert_int_equal(frame_vector(NULL, v), 0);
}

static void a_hidden_fluid_keeps_its_place_but_does_not_count(void **state)
{
    (void)state;
    Frame frame = tank_frame(2, 10);
    View view = view_of(&frame, (ViewOptions){.at = NAN, .fluids = "air"});
    assert_int_equal(view.n, 200);
    assert_int_equal(view.hidden, 100);
    for (size_t k = 0; k < view.n; k++) assert_int_equal(view.dots[k].hidden, frame.phase[view.dots[k].particle] == 0);
    view_done(&view);
    frame_done(&frame);
}

static void refuses(const Frame *frame, ViewOptions options, MnsStatus status, const char *says)
{
    View view;
    MnsError error = {0};
    assert_int_equal(view_make(frame, &options, &view, &error), status);
    assert_non_null(strstr(error.text, says));
}

static void options_that_do_not_fit_are_refused_with_what_there_is(void **state)
{
    (void)state;
    Frame flat = tank_frame(2, 10), deep = tank_frame(3, 10);
    refuses(&flat, (ViewOptions){.kind = VIEW_CUT, .axis = 2, .at = NAN}, MNS_E_INVALID, "two-dimensional");
    refuses(&deep, (ViewOptions){.kind = VIEW_CUT, .axis = 2, .at = 0.7}, MNS_E_INVALID, "between 0 m and 0.5 m");
    refuses(&flat, (ViewOptions){.at = NAN, .fluids = "water,oil"}, MNS_E_NOT_FOUND, "\"oil\"; there are: water, air");
    refuses(&flat, (ViewOptions){.at = NAN, .has_box = true, .box = {5, 5, 6, 6}}, MNS_E_NOT_FOUND, "nothing to draw");
    for (size_t i = 0; i < flat.n; i++) flat.x[i][0] = NAN;
    refuses(&flat, plain, MNS_E_NOT_FOUND, "finite position");
    frame_done(&flat);
    frame_done(&deep);
}

static void percentiles_interpolate_between_ranks(void **state)
{
    (void)state;
    double values[] = {5, 1, 3, 2, 4};
    assert_near(percentile(5, values, 0), 1);
    assert_near(percentile(5, values, 0.5), 3);
    assert_near(percentile(5, values, 0.625), 3.5);
    assert_near(percentile(5, values, 1), 5);
}

static void a_wild_particle_does_not_take_the_colours(void **state)
{
    (void)state;
    Frame frame = tank_frame(2, 20);
    frame.value[11] = 1e9;
    View view = view_of(&frame, plain);
    const Scale s = scale_make(&frame, &view, NULL, false);
    assert_true(s.lo <= 25 && s.lo >= -100 && s.hi >= 1950 && s.hi <= 2100);
    assert_true(s.above && !s.below);
    assert_near(s.beyond, 1.0 / 800);
    assert_string_equal(s.unit, "kPa");
    assert_string_equal(s.name, "Pressure");
    assert_near(s.factor, 1e-3);
    view_done(&view);
    frame_done(&frame);
}

/* A cut takes in particles a little before and behind the plane; those that others hide have no say in the colours. */
static void particles_that_nobody_sees_do_not_set_the_colours(void **state)
{
    (void)state;
    Frame frame = tank_frame(3, 20);
    for (size_t i = 0; i < frame.n; i++) frame.value[i] = frame.x[i][2] > 0.25 && frame.x[i][2] < 0.3 ? 10 : 1e6;
    View view = view_of(&frame, (ViewOptions){.kind = VIEW_CUT, .axis = 2, .at = 0.27});
    assert_int_equal(raster_see(&view, NULL), MNS_OK);
    size_t seen = 0;
    for (size_t k = 0; k < view.n; k++) seen += view.dots[k].seen;
    assert_int_equal(seen, 800);
    assert_true(view.n > 800);
    const Scale s = scale_make(&frame, &view, NULL, false);
    assert_true(s.hi < 20);
    view_done(&view);
    frame_done(&frame);
}

static void a_range_that_is_asked_for_is_kept(void **state)
{
    (void)state;
    Frame frame = tank_frame(2, 20);
    View view = view_of(&frame, plain);
    const Scale s = scale_make(&frame, &view, (const double[]){33.5, 5000}, false);
    assert_near(s.lo, 33.5);
    assert_near(s.hi, 5000);
    assert_true(s.below && !s.above);
    view_done(&view);
    frame_done(&frame);
}

static void a_diverging_scale_has_zero_in_its_middle(void **state)
{
    (void)state;
    Frame frame = tank_frame(2, 20);
    View view = view_of(&frame, plain);
    const Scale s = scale_make(&frame, &view, NULL, true);
    assert_near(s.lo, -s.hi);
    assert_true(s.hi >= 1975);
    view_done(&view);
    frame_done(&frame);
}

static void a_constant_field_still_has_a_scale(void **state)
{
    (void)state;
    Frame frame = tank_frame(2, 10);
    for (size_t i = 0; i < frame.n; i++) frame.value[i] = 1000;
    View view = view_of(&frame, plain);
    const Scale s = scale_make(&frame, &view, NULL, false);
    assert_true(s.lo < 1000 && s.hi > 1000);
    assert_false(s.below || s.above);
    view_done(&view);
    frame_done(&frame);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_hold_the_whole_volume_of_the_fluid),
        cmocka_unit_test(walls_are_in_view_only_if_asked_for),
        cmocka_unit_test(particles_without_a_value_are_skipped_and_counted),
        cmocka_unit_test(three_dimensions_are_cut_through_the_middle_of_the_thinnest),
        cmocka_unit_test(a_slab_holds_the_particles_within_its_thickness),
        cmocka_unit_test(a_projection_shows_the_heavy_fluid_from_above),
        cmocka_unit_test(bounds_are_those_of_the_domain_wherever_the_particles_are),
        cmocka_unit_test(where_gravity_points_is_down),
        cmocka_unit_test(no_view_is_a_mirror_image),
        cmocka_unit_test(a_vector_is_read_from_the_text_of_a_case),
        cmocka_unit_test(particles_that_nobody_sees_do_not_set_the_colours),
        cmocka_unit_test(a_hidden_fluid_keeps_its_place_but_does_not_count),
        cmocka_unit_test(options_that_do_not_fit_are_refused_with_what_there_is),
        cmocka_unit_test(percentiles_interpolate_between_ranks),
        cmocka_unit_test(a_wild_particle_does_not_take_the_colours),
        cmocka_unit_test(a_range_that_is_asked_for_is_kept),
        cmocka_unit_test(a_diverging_scale_has_zero_in_its_middle),
        cmocka_unit_test(a_constant_field_still_has_a_scale),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
