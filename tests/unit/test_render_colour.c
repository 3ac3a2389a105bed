/* SPDX-License-Identifier: BSD-3-Clause */
/* Colour maps rank values by lightness; fluids are told apart. */
#include "client/cli/render_colour.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

enum { SAMPLES = 512 };

static double lightness(const ColourMap *map, double s)
{
    return colour_lightness(colour_at(map, s));
}

static void maps_for_amounts_become_steadily_lighter(void **state)
{
    (void)state;
    for (size_t k = 0; colour_map(k); k++) {
        if (colour_map_diverges(colour_map(k))) continue;
        for (int s = 0; s < SAMPLES; s++)
            assert_true(lightness(colour_map(k), (s + 1.0) / SAMPLES) > lightness(colour_map(k), (double)s / SAMPLES));
        assert_true(lightness(colour_map(k), 1) - lightness(colour_map(k), 0) > 60);
    }
}

/* Equal steps of the value look like equal steps: no half of the map holds more than 62 % of the change. */
static void maps_for_amounts_become_evenly_lighter(void **state)
{
    (void)state;
    for (size_t k = 0; colour_map(k); k++) {
        const ColourMap *map = colour_map(k);
        if (colour_map_diverges(map)) continue;
        const double share = (lightness(map, 0.5) - lightness(map, 0)) / (lightness(map, 1) - lightness(map, 0));
        assert_true(share > 0.38 && share < 0.62);
    }
}

static void a_diverging_map_is_lightest_in_its_middle(void **state)
{
    (void)state;
    const ColourMap *map = colour_map_find("coolwarm");
    assert_true(colour_map_diverges(map));
    for (int s = 0; s < SAMPLES / 2; s++) {
        assert_true(lightness(map, (s + 1.0) / SAMPLES) > lightness(map, (double)s / SAMPLES));
        assert_true(lightness(map, 1 - (s + 1.0) / SAMPLES) > lightness(map, 1 - (double)s / SAMPLES));
    }
    assert_true(fabs(lightness(map, 0) - lightness(map, 1)) < 5);
}

static void values_beyond_the_ends_get_the_colours_of_the_ends(void **state)
{
    (void)state;
    const ColourMap *map = colour_map_find("viridis");
    const Colour low = colour_at(map, -3), high = colour_at(map, 7);
    assert_int_equal(lround(255 * low.r), 0x44);
    assert_int_equal(lround(255 * low.b), 0x54);
    assert_int_equal(lround(255 * high.r), 0xfd);
    assert_int_equal(lround(255 * high.b), 0x25);
}

static void an_unknown_map_is_not_found(void **state)
{
    (void)state;
    assert_null(colour_map_find("rainbow"));
    assert_ptr_equal(colour_map_find("viridis"), colour_map(0));
}

static void water_is_blue_and_air_is_pale_in_any_order(void **state)
{
    (void)state;
    Colour c[2];
    colour_fluids(2, (const char *const[]){"hot_air", "Water-1"}, c);
    assert_true(colour_lightness(c[0]) > 90);
    assert_true(c[1].b > c[1].r + 0.4);
}

/* "air" within another word says nothing. */
static void only_whole_words_carry_a_colour(void **state)
{
    (void)state;
    Colour c[1];
    colour_fluids(1, (const char *const[]){"dairy"}, c);
    assert_true(colour_lightness(c[0]) < 80);
}

static void sixteen_fluids_have_sixteen_colours(void **state)
{
    (void)state;
    enum { N = 16 };
    char text[N][8];
    const char *names[N];
    Colour c[N];
    for (int k = 0; k < N; k++) {
        snprintf(text[k], sizeof text[k], k ? "%c" : "water", 'a' + k);
        names[k] = text[k];
    }
    colour_fluids(N, names, c);
    for (int a = 0; a < N; a++)
        for (int b = 0; b < a; b++)
            assert_true(fabs(c[a].r - c[b].r) + fabs(c[a].g - c[b].g) + fabs(c[a].b - c[b].b) > 0.1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maps_for_amounts_become_steadily_lighter),
        cmocka_unit_test(maps_for_amounts_become_evenly_lighter),
        cmocka_unit_test(a_diverging_map_is_lightest_in_its_middle),
        cmocka_unit_test(values_beyond_the_ends_get_the_colours_of_the_ends),
        cmocka_unit_test(an_unknown_map_is_not_found),
        cmocka_unit_test(water_is_blue_and_air_is_pale_in_any_order),
        cmocka_unit_test(only_whole_words_carry_a_colour),
        cmocka_unit_test(sixteen_fluids_have_sixteen_colours),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
