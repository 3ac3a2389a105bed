/* SPDX-License-Identifier: BSD-3-Clause */
/* What is picked out of many is, at every level of this machine and in the plain twin that all others have, what a loop that asks of
 * each by itself finds. */
#include "sim/select.h"
#include "tests/support/check.h"
#include "tests/support/draw.h"
#include <string.h>

enum { MANY = 41, ROUNDS = 300 };

static void distances_are_marked_where_they_are_in_reach(void **state)
{
    (void)state;
    for (Level level = 0; level <= level_in_use(); level++) {
        uint64_t seed = 5;
        for (int round = 0; round < ROUNDS; round++) {
            const size_t stride = 8 + draw_below(&seed, 5), blocks = draw_below(&seed, 5);
            double r[5 * 12];
            uint8_t marks[6];
            for (size_t k = 0; k < 60; k++) r[k] = draw_below(&seed, 4) ? draw_share(&seed) : 0.5;
            if (round % 7 == 0) r[draw_below(&seed, 60)] = NAN;
            memset(marks, 0xa5, sizeof marks);
            select_marks(level, r, stride, blocks, 0.5, marks);
            for (size_t b = 0; b < blocks; b++)
                for (size_t l = 0; l < 8; l++) assert_int_equal(marks[b] >> l & 1, r[b * stride + l] < 0.5);
            assert_int_equal(marks[blocks], 0xa5); /* nothing behind the last */
        }
    }
}

static void marked_entries_come_in_their_order(void **state)
{
    (void)state;
    for (Level level = 0; level <= level_in_use(); level++) {
        uint64_t seed = 6;
        for (int round = 0; round < ROUNDS; round++) {
            const size_t n = draw_below(&seed, MANY + 1);
            uint32_t list[MANY + SELECT_SLACK] = {0}, out[MANY + SELECT_SLACK];
            uint8_t bits[MANY / 8 + 1] = {0};
            size_t count = 0;
            for (size_t k = 0; k < n; k++) {
                list[k] = (uint32_t)draw_below(&seed, 1000000);
                if (draw_below(&seed, 2)) bits[k / 8] |= (uint8_t)(1u << k % 8);
            }
            const size_t found = select_marked(level, list, n, bits, out);
            for (size_t k = 0; k < n; k++)
                if (bits[k / 8] >> k % 8 & 1) assert_int_equal(out[count++], list[k]);
            assert_int_equal(found, count);
        }
    }
}

/* All or none of what is in a block too: eight marks of either kind. */
static void whole_blocks_are_taken_or_left(void **state)
{
    (void)state;
    static const uint8_t bits[] = {0xff, 0, 0xff};
    for (Level level = 0; level <= level_in_use(); level++) {
        uint32_t list[24 + SELECT_SLACK] = {0}, out[24 + SELECT_SLACK];
        for (uint32_t k = 0; k < 24; k++) list[k] = 100 + k;
        assert_int_equal(select_marked(level, list, 24, bits, out), 16);
        for (uint32_t k = 0; k < 8; k++) assert_true(out[k] == 100 + k && out[8 + k] == 116 + k);
    }
}

typedef struct Cloud {
    double x[3][MANY], at[3], period[3], frequency[3];
    Points points;
} Cloud;

/* In a box of length 1, open or not in each direction. */
static void make(Cloud *cloud, bool periodic, uint64_t *seed)
{
    for (int d = 0; d < 3; d++) {
        const bool repeats = periodic && draw_below(seed, 3);
        cloud->period[d] = cloud->frequency[d] = repeats ? 1 : 0;
        cloud->at[d] = draw_share(seed);
        for (size_t j = 0; j < MANY; j++) cloud->x[d][j] = draw_share(seed);
        cloud->points.x[d] = cloud->x[d];
    }
    cloud->points.period = cloud->period;
    cloud->points.frequency = cloud->frequency;
}

/* The squared distance to the nearest image, by trying them; and whether that image is another than the point. */
static double nearest2(const Cloud *cloud, size_t j, int dim, bool *ret_image)
{
    double r2 = 0;
    *ret_image = false;
    for (int d = 0; d < dim; d++) {
        const double plain = cloud->at[d] - cloud->x[d][j];
        double best = plain;
        for (int k = -1; k <= 1; k++)
            if (fabs(plain + k * cloud->period[d]) < fabs(best)) best = plain + k * cloud->period[d];
        *ret_image = *ret_image || best != plain;
        r2 += best * best;
    }
    return r2;
}

static void near_points_are_found_and_images_are_told(void **state)
{
    (void)state;
    for (Level level = 0; level <= level_in_use(); level++) {
        uint64_t seed = 7;
        size_t all = 0, with_images = 0;
        for (int round = 0; round < 4 * ROUNDS; round++) {
            const int dim = 2 + round % 2;
            const bool periodic = round / 2 % 2;
            const uint32_t last = (uint32_t)draw_below(&seed, MANY + 1), first = (uint32_t)draw_below(&seed, last + 1),
                           self = (uint32_t)draw_below(&seed, MANY);
            const double reach = 0.1 + 0.35 * draw_share(&seed);
            Cloud cloud;
            uint32_t out[MANY + SELECT_SLACK];
            bool images = false, expected = false;
            size_t count = 0;
            make(&cloud, periodic, &seed);
            for (int d = 0; d < 3; d++) cloud.at[d] = cloud.x[d][self];
            const size_t found = select_near(level, dim, periodic)(&cloud.points, first, last, cloud.at, reach * reach,
                                                                   self, out, &images);
            for (uint32_t j = first; j < last; j++) {
                bool image;
                if (nearest2(&cloud, j, dim, &image) >= reach * reach || j == self) continue;
                assert_true(count < found);
                assert_int_equal(out[count++], j);
                expected = expected || image;
            }
            assert_int_equal(found, count);
            assert_int_equal(images, expected);
            all += count;
            with_images += expected;
        }
        assert_true(all > 1000 && with_images > 100);
    }
}

/* Whoever asks about several ranges is not told less by the last of them. */
static void what_was_told_of_images_stays_told(void **state)
{
    (void)state;
    for (Level level = 0; level <= level_in_use(); level++) {
        Cloud cloud;
        uint64_t seed = 8;
        uint32_t out[MANY + SELECT_SLACK];
        bool images = true;
        make(&cloud, true, &seed);
        select_near(level, 3, true)(&cloud.points, 0, 0, cloud.at, 1, 0, out, &images);
        assert_true(images);
        select_near(level, 2, false)(&cloud.points, 0, MANY, cloud.at, 1, 0, out, &images);
        assert_true(images);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distances_are_marked_where_they_are_in_reach),
        cmocka_unit_test(marked_entries_come_in_their_order),
        cmocka_unit_test(whole_blocks_are_taken_or_left),
        cmocka_unit_test(near_points_are_found_and_images_are_told),
        cmocka_unit_test(what_was_told_of_images_stays_told),
    };
    return cmocka_run_group_tests_name("select", tests, NULL, NULL);
}
