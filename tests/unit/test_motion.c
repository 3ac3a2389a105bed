/* SPDX-License-Identifier: BSD-3-Clause */
/* Motions of walls: velocity and acceleration are the derivatives of the displacement, which is what the case asks
 * for. */
#include "sim/motion.h"
#include "tests/support/check.h"

static const double PI = 3.14159265358979323846;

/* A cubic that differs in each direction. */
static double cubic(int d, double t, int derivative)
{
    const double c[4] = {0.3 - d, 0.7 + d, -1.1 * (d + 1), 0.4 + 0.3 * d};
    if (derivative == 0) return c[0] + t * (c[1] + t * (c[2] + t * c[3]));
    return derivative == 1 ? c[1] + t * (2 * c[2] + t * 3 * c[3]) : 2 * c[2] + 6 * c[3] * t;
}

static MnsMotion table_of_cubic(MnsMotionPoint points[4])
{
    const double times[4] = {0.2, 0.5, 1.4, 1.9};
    for (int k = 0; k < 4; k++) {
        points[k].t = times[k];
        for (int d = 0; d < 3; d++) {
            points[k].x[d] = cubic(d, times[k], 0);
            points[k].v[d] = cubic(d, times[k], 1);
        }
    }
    return (MnsMotion){.kind = MNS_TABLE, .n = 4, .points = points};
}

static void velocity_and_acceleration_are_derivatives(void **state)
{
    (void)state;
    MnsMotionPoint points[4];
    const MnsMotion motions[] = {
        {.kind = MNS_STILL, .amplitude = {1, 1, 1}, .frequency = 3},
        {.kind = MNS_SINE, .amplitude = {0.1, -0.2, 0.05}, .frequency = 0.6, .phase = 0.8},
        {.kind = MNS_ONE_MINUS_COSINE, .amplitude = {0.1, -0.2, 0.05}, .frequency = 0.6, .phase = 0.8},
        table_of_cubic(points),
    };
    const double e = 1e-4;
    for (size_t k = 0; k < sizeof motions / sizeof *motions; k++)
        for (double t = 0.23; t < 2.5; t += 0.137) {
            double x[3], v[3], a[3], low_x[3], low_v[3], high_x[3], high_v[3], unused[3];
            motion_at(&motions[k], t, x, v, a);
            motion_at(&motions[k], t - e, low_x, low_v, unused);
            motion_at(&motions[k], t + e, high_x, high_v, unused);
            for (int d = 0; d < 3; d++) {
                /* e^2 / 6 of third and fourth derivatives of up to 40. */
                assert_close(v[d], (high_x[d] - low_x[d]) / (2 * e), 1e-7);
                assert_close(a[d], (high_v[d] - low_v[d]) / (2 * e), 1e-7);
            }
        }
}

static void sine_swings_by_its_amplitude_from_where_it_starts(void **state)
{
    (void)state;
    const MnsMotion m = {.kind = MNS_SINE, .amplitude = {0.1, -0.2, 0.05}, .frequency = 2, .phase = PI / 6};
    double x[3], v[3], a[3];
    motion_at(&m, 0, x, v, a);
    for (int d = 0; d < 3; d++) {
        assert_true(x[d] == 0);
        assert_close(v[d], m.amplitude[d] * 4 * PI * cos(PI / 6), 1e-14);
    }
    /* A third of a right angle is left to the crest, a sixth of a period: sin = 1 there, 1/2 at the start. */
    motion_at(&m, 1.0 / 12, x, v, a);
    for (int d = 0; d < 3; d++) {
        assert_close(x[d], m.amplitude[d] * 0.5, 1e-15);
        assert_close(v[d], 0, 1e-14);
        assert_close(a[d], -m.amplitude[d] * 16 * PI * PI, 1e-12);
    }
}

static void one_minus_cosine_starts_at_rest_and_swings_by_twice_its_amplitude(void **state)
{
    (void)state;
    const MnsMotion m = {.kind = MNS_ONE_MINUS_COSINE, .amplitude = {0.1, -0.2, 0.05}, .frequency = 2};
    double x[3], v[3], a[3];
    motion_at(&m, 0, x, v, a);
    for (int d = 0; d < 3; d++) {
        assert_true(x[d] == 0);
        assert_true(v[d] == 0);
        assert_close(a[d], m.amplitude[d] * 16 * PI * PI, 1e-12);
    }
    motion_at(&m, 0.25, x, v, a);
    for (int d = 0; d < 3; d++) assert_close(x[d], 2 * m.amplitude[d], 1e-15);
}

static void table_goes_through_its_points_and_is_cubic_between(void **state)
{
    (void)state;
    MnsMotionPoint points[4];
    const MnsMotion m = table_of_cubic(points);
    for (double t = 0.2 + 1e-9; t < 1.9; t += 0.01 * 1.7 - 1e-10) {
        double x[3], v[3], a[3];
        motion_at(&m, t, x, v, a);
        for (int d = 0; d < 3; d++) {
            assert_close(x[d], cubic(d, t, 0) - points[0].x[d], 1e-13); /* rounding, of values up to 10 */
            assert_close(v[d], cubic(d, t, 1), 1e-12);
            assert_close(a[d], cubic(d, t, 2), 1e-11);
        }
    }
    for (int k = 0; k < 4; k++) {
        double x[3], v[3], a[3];
        motion_at(&m, points[k].t, x, v, a);
        for (int d = 0; d < 3; d++) assert_close(x[d], points[k].x[d] - points[0].x[d], 1e-15);
    }
}

static void table_is_at_rest_before_and_after(void **state)
{
    (void)state;
    MnsMotionPoint points[4];
    const MnsMotion m = table_of_cubic(points);
    const double times[] = {-5, 0, 0.19, 1.91, 7};
    for (int k = 0; k < 5; k++) {
        double x[3], v[3], a[3];
        motion_at(&m, times[k], x, v, a);
        for (int d = 0; d < 3; d++) {
            assert_true(x[d] == points[k < 3 ? 0 : 3].x[d] - points[0].x[d]); /* from where the case puts it */
            assert_true(v[d] == 0 && a[d] == 0);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(velocity_and_acceleration_are_derivatives),
        cmocka_unit_test(sine_swings_by_its_amplitude_from_where_it_starts),
        cmocka_unit_test(one_minus_cosine_starts_at_rest_and_swings_by_twice_its_amplitude),
        cmocka_unit_test(table_goes_through_its_points_and_is_cubic_between),
        cmocka_unit_test(table_is_at_rest_before_and_after),
    };
    return cmocka_run_group_tests_name("motion", tests, NULL, NULL);
}
