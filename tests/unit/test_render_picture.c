/* SPDX-License-Identifier: BSD-3-Clause */
/* The picture has the size, the colours and the whiteness it should, or there is none and a sentence says why. */
#include "client/cli/render_picture.h"
#include "tests/support/draw.h"
#include "tests/support/io_fixture.h"
#include "tests/support/render_fixture.h"
#include <cairo.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

typedef struct Picture {
    cairo_surface_t *surface;
    int width, height;
    Drawn drawn;
} Picture;

static RenderOptions options_for(const char *out)
{
    return (RenderOptions){
        .out = out, .field = "phase", .width = 640, .height = 480, .map = colour_map(0), .view.at = NAN};
}

static Picture drawn(const Frame *frame, RenderOptions o)
{
    Picture p;
    MnsError error = {0};
    assert_int_equal(picture_write(frame, &o, &p.drawn, &error), MNS_OK);
    p.surface = cairo_image_surface_create_from_png(o.out);
    assert_int_equal(cairo_surface_status(p.surface), CAIRO_STATUS_SUCCESS);
    p.width = cairo_image_surface_get_width(p.surface);
    p.height = cairo_image_surface_get_height(p.surface);
    return p;
}

static uint32_t pixel(const Picture *p, int x, int y)
{
    const unsigned char *row =
        cairo_image_surface_get_data(p->surface) + y * cairo_image_surface_get_stride(p->surface);
    uint32_t value;
    memcpy(&value, row + 4 * x, sizeof value);
    return value & 0xffffff;
}

/* The pixel at a place of the plot, in shares of its sides from the lower left. */
static uint32_t plot_pixel(const Picture *p, double u, double v)
{
    const double *plot = p->drawn.plot;
    return pixel(p, (int)(plot[0] + u * plot[2]), (int)(plot[1] + (1 - v) * plot[3]));
}

static Frame phases_only(int dim, int per_metre)
{
    Frame frame = tank_frame(dim, per_metre);
    free(frame.value);
    frame.value = NULL;
    return frame;
}

static void a_picture_of_phases_has_the_size_and_the_colours_of_the_fluids(void **state)
{
    char *out = path_in(*state, "a.png");
    Frame frame = phases_only(2, 20);
    Picture p = drawn(&frame, options_for(out));
    assert_int_equal(p.width, 640);
    assert_int_equal(p.height, 480);
    assert_int_equal(plot_pixel(&p, 0.3, 0.2), 0x1f78b4);
    assert_int_equal(plot_pixel(&p, 0.3, 0.8), 0xf1ece1);
    assert_int_equal(p.drawn.particles, 800);
    assert_false(holds(*state, ".part"));
    cairo_surface_destroy(p.surface);
    frame_done(&frame);
    free(out);
}

/* Lattices of many sizes against the pixels, each moved by a fraction of a spacing here and there. */
static void fields_have_neither_gaps_nor_stripes_at_any_resolution(void **state)
{
    char *out = path_in(*state, "a.png");
    uint64_t seed = 3;
    for (int per_metre = 4; per_metre < 500; per_metre = per_metre * 3 / 2 + 1) {
        Frame frame = phases_only(2, per_metre);
        for (size_t i = 0; i < frame.n_fluid; i++) {
            frame.phase[i] = 0;
            for (int d = 0; d < 2; d++) frame.x[i][d] += 0.3 * frame.spacing * (draw_share(&seed) - 0.5);
        }
        Picture p = drawn(&frame, options_for(out));
        const double *plot = p.drawn.plot;
        for (int y = 2; y < (int)plot[3] - 2; y++)
            for (int x = 2; x < (int)plot[2] - 2; x++)
                assert_int_equal(pixel(&p, (int)plot[0] + x, (int)plot[1] + y), 0x1f78b4);
        cairo_surface_destroy(p.surface);
        frame_done(&frame);
    }
    free(out);
}

static void the_plot_has_equal_scales_in_both_directions(void **state)
{
    char *out = path_in(*state, "a.png");
    Frame frame = phases_only(2, 20);
    Picture p = drawn(&frame, options_for(out));
    assert_true(fabs(p.drawn.plot[2] - 2 * p.drawn.plot[3]) <= 2);
    cairo_surface_destroy(p.surface);
    frame_done(&frame);
    free(out);
}

static bool is_colour(uint32_t found, Colour wanted)
{
    return abs((int)(found >> 16 & 255) - (int)lround(255 * wanted.r)) <= 2 &&
           abs((int)(found >> 8 & 255) - (int)lround(255 * wanted.g)) <= 2 &&
           abs((int)(found & 255) - (int)lround(255 * wanted.b)) <= 2;
}

/* The field is 1000 x, constant within a particle: at the middle of one the colour is that of its own value. */
static void a_value_has_its_colour_of_the_map_and_outliers_that_of_the_end(void **state)
{
    char *out = path_in(*state, "a.png");
    Frame frame = tank_frame(2, 20);
    RenderOptions o = options_for(out);
    o.has_range = true;
    o.range[0] = 500;
    o.range[1] = 1500;
    Picture p = drawn(&frame, o);
    assert_true(is_colour(plot_pixel(&p, 0.1, 0.5125), colour_at(o.map, 0)));
    assert_true(is_colour(plot_pixel(&p, 0.5125, 0.525), colour_at(o.map, 0.525)));
    assert_true(is_colour(plot_pixel(&p, 0.6125, 0.525), colour_at(o.map, 0.725)));
    assert_true(is_colour(plot_pixel(&p, 0.9, 0.5125), colour_at(o.map, 1)));
    assert_true(p.drawn.range[0] == 500 && p.drawn.range[1] == 1500);
    cairo_surface_destroy(p.surface);
    frame_done(&frame);
    free(out);
}

/* Whatever the size and the texts, a band along the edges stays white: nothing is cut off. */
static void nothing_is_cut_off_at_any_size(void **state)
{
    static const int sizes[][2] = {{1600, 900}, {800, 450}, {400, 900}, {900, 300}, {240, 240}};
    char *out = path_in(*state, "a.png");
    for (size_t k = 0; k < 2 * sizeof sizes / sizeof *sizes; k++) {
        Frame frame = k % 2 ? phases_only(2, 20) : tank_frame(2, 20);
        RenderOptions o = options_for(out);
        o.title = "A title that is so long that no picture of a usual size has room for all of it, not even a wide one "
                  "like this one";
        o.width = sizes[k / 2][0];
        o.height = sizes[k / 2][1];
        o.view.walls = true;
        Picture p = drawn(&frame, o);
        for (int x = 0; x < p.width; x++) {
            assert_int_equal(pixel(&p, x, 0), 0xffffff);
            assert_int_equal(pixel(&p, x, p.height - 1), 0xffffff);
        }
        for (int y = 0; y < p.height; y++) {
            assert_int_equal(pixel(&p, 0, y), 0xffffff);
            assert_int_equal(pixel(&p, p.width - 1, y), 0xffffff);
        }
        cairo_surface_destroy(p.surface);
        frame_done(&frame);
    }
    free(out);
}

/* Tiles of the fluid end with the domain, whatever part of the plane is drawn. */
static void no_tile_hangs_over_the_domain(void **state)
{
    char *out = path_in(*state, "a.png");
    Frame frame = phases_only(2, 8);
    RenderOptions o = options_for(out);
    o.view.has_box = true;
    memcpy(o.view.box, (const double[]){-0.5, -0.5, 2.5, 1.5}, sizeof o.view.box);
    Picture p = drawn(&frame, o);
    static const double inside[][2] = {{0.01, 0.5}, {1.99, 0.5}, {1, 0.01}, {1, 0.99}};
    static const double outside[][2] = {{-0.01, 0.5}, {2.01, 0.5}, {1, -0.01}, {1, 1.01}};
    for (int k = 0; k < 4; k++) {
        assert_int_not_equal(plot_pixel(&p, (inside[k][0] + 0.5) / 3, (inside[k][1] + 0.5) / 2), 0xffffff);
        assert_int_equal(plot_pixel(&p, (outside[k][0] + 0.5) / 3, (outside[k][1] + 0.5) / 2), 0xffffff);
    }
    cairo_surface_destroy(p.surface);
    frame_done(&frame);
    free(out);
}

/* How many pixels of a column of the plot are not of the colour above and below the interface. */
static int line_pixels(const Picture *p, double u, double *ret_v)
{
    const uint32_t field = plot_pixel(p, u, 0.25);
    int n = 0;
    for (double v = 0.02; v < 0.98; v += 1 / p->drawn.plot[3])
        if (plot_pixel(p, u, v) != field) {
            n++;
            *ret_v = v;
        }
    return n;
}

/* The field is the same everywhere, so that all there is to see is the interface, at y = 0.5. */
static void the_interface_is_a_thin_line_over_a_field_and_only_there(void **state)
{
    char *out = path_in(*state, "a.png");
    Frame frame = tank_frame(2, 20);
    double v = 0;
    for (size_t i = 0; i < frame.n; i++) frame.value[i] = 3;
    Picture p = drawn(&frame, options_for(out));
    for (double u = 0.05; u < 1; u += 0.1) {
        const int n = line_pixels(&p, u, &v);
        assert_true(n >= 1 && n <= 6);
        assert_true(fabs(v - 0.5) < 0.03);
    }
    cairo_surface_destroy(p.surface);
    for (size_t i = 0; i < frame.n_fluid; i++) frame.phase[i] = 0;
    p = drawn(&frame, options_for(out));
    assert_int_equal(line_pixels(&p, 0.5, &v), 0);
    cairo_surface_destroy(p.surface);
    frame_done(&frame);
    free(out);
}

/* A height that is left to the plot leaves no white above and below it. */
static void a_page_can_be_as_high_as_its_plot(void **state)
{
    char *out = path_in(*state, "a.png");
    Frame frame = tank_frame(2, 20);
    RenderOptions o = options_for(out);
    o.width = 1600;
    o.height = 0;
    Picture p = drawn(&frame, o);
    assert_int_equal(p.height, p.drawn.height);
    assert_true(p.drawn.plot[2] > 0.8 * p.width && p.drawn.plot[3] > 0.8 * p.height);
    cairo_surface_destroy(p.surface);
    frame_done(&frame);
    free(out);
}

static void the_same_frame_gives_the_same_bytes(void **state)
{
    char *out[2] = {path_in(*state, "a.png"), path_in(*state, "b.png")};
    unsigned char *bytes[2];
    size_t size[2];
    for (int k = 0; k < 2; k++) {
        Frame frame = tank_frame(3, 20);
        RenderOptions o = options_for(out[k]);
        o.view.kind = VIEW_PROJECTION;
        o.view.axis = 1;
        Picture p = drawn(&frame, o);
        cairo_surface_destroy(p.surface);
        bytes[k] = bytes_of(out[k], &size[k]);
        frame_done(&frame);
    }
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    for (int k = 0; k < 2; k++) free(bytes[k]), free(out[k]);
}

static void refuses(const Frame *frame, RenderOptions o, MnsStatus status, const char *says)
{
    Drawn drawn;
    MnsError error = {0};
    assert_int_equal(picture_write(frame, &o, &drawn, &error), status);
    assert_non_null(strstr(error.text, says));
    assert_int_not_equal(access(o.out, F_OK), 0);
}

static void a_picture_that_cannot_be_written_leaves_nothing(void **state)
{
    char *lost = path_in(*state, "no/such/a.png"), *full = path_in(*state, "full.png");
    Frame frame = tank_frame(2, 20);
    refuses(&frame, options_for(lost), MNS_E_IO, "No such file or directory");
    limit_files(1000);
    refuses(&frame, options_for(full), MNS_E_NO_SPACE, "full.png");
    limit_files(SIZE_MAX);
    assert_false(holds(*state, ".part"));
    frame_done(&frame);
    free(lost);
    free(full);
}

static void a_page_without_room_is_refused(void **state)
{
    char *out = path_in(*state, "a.png");
    Frame frame = tank_frame(2, 20);
    RenderOptions o = options_for(out);
    o.width = o.height = 90;
    refuses(&frame, o, MNS_E_LIMIT, "make it larger");
    frame_done(&frame);
    free(out);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, scratch_begin, scratch_end)
    const struct CMUnitTest tests[] = {
        TEST(a_picture_of_phases_has_the_size_and_the_colours_of_the_fluids),
        TEST(fields_have_neither_gaps_nor_stripes_at_any_resolution),
        TEST(the_plot_has_equal_scales_in_both_directions),
        TEST(a_value_has_its_colour_of_the_map_and_outliers_that_of_the_end),
        TEST(nothing_is_cut_off_at_any_size),
        TEST(no_tile_hangs_over_the_domain),
        TEST(the_interface_is_a_thin_line_over_a_field_and_only_there),
        TEST(a_page_can_be_as_high_as_its_plot),
        TEST(the_same_frame_gives_the_same_bytes),
        TEST(a_picture_that_cannot_be_written_leaves_nothing),
        TEST(a_page_without_room_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
