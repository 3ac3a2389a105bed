/* SPDX-License-Identifier: BSD-3-Clause */
/* Distances from shapes are those to the nearest of many points of their surface, with the sign of what is inside. */
#include "sim/shape.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"

/* A box turned anyhow: middle, unit directions, half lengths. */
typedef struct Turned {
    double at[3], e[3][3], half[3];
} Turned;

static double distance_of(MnsPart part, int dim, const double x[3])
{
    Shape s;
    const MnsShape shape = {1, &part};
    assert_int_equal(shape_init(&s, &shape, dim, NULL, 0, "shape", NULL), MNS_OK);
    const double distance = shape_distance(&s, x);
    shape_done(&s);
    return distance;
}

static void random_point(int dim, uint64_t *seed, double x[3])
{
    for (int d = 0; d < 3; d++) x[d] = d < dim ? 0.5 + 1.2 * cloud_noise(seed) : 0;
}

static double apart(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/* Nearest of SAMPLES^(dim - 1) points on each face, and how far from a sample a point of the surface can be. */
enum { SAMPLES = 121 };

static double nearest_of_turned(const Turned *t, int dim, const double x[3], double *ret_blur)
{
    double nearest = INFINITY, blur2 = 0;
    for (int face = 0; face < dim; face++)
        for (int side = -1; side <= 1; side += 2)
            for (int k = 0; k < SAMPLES; k++)
                for (int q = 0; q < (dim == 3 ? SAMPLES : 1); q++) {
                    const double u[2] = {2.0 * k / (SAMPLES - 1) - 1, 2.0 * q / (SAMPLES - 1) - 1};
                    double local[3] = {0, 0, 0}, point[3];
                    for (int d = 0, n = 0; d < dim; d++) local[d] = t->half[d] * (d == face ? side : u[n++]);
                    for (int d = 0; d < 3; d++)
                        point[d] = t->at[d] + local[0] * t->e[0][d] + local[1] * t->e[1][d] + local[2] * t->e[2][d];
                    nearest = fmin(nearest, apart(x, point));
                }
    for (int d = 0; d < dim; d++) blur2 += pow(t->half[d] / (SAMPLES - 1), 2);
    *ret_blur = sqrt(blur2);
    return nearest;
}

static bool in_turned(const Turned *t, int dim, const double x[3])
{
    bool inside = true;
    for (int k = 0; k < dim; k++) {
        double along = 0;
        for (int d = 0; d < 3; d++) along += (x[d] - t->at[d]) * t->e[k][d];
        inside = inside && along > -t->half[k] && along < t->half[k];
    }
    return inside;
}

/* Compare a part with a turned box at random points on both sides of its surface. */
static void assert_is_turned(MnsPart part, const Turned *t, int dim)
{
    uint64_t seed = 11;
    int inside = 0;
    for (int k = 0; k < 100; k++) {
        double x[3], blur = 0;
        random_point(dim, &seed, x);
        if (k % 3 == 0)
            for (int d = 0; d < dim; d++) x[d] = t->at[d] + 0.2 * (x[d] - t->at[d]);
        const bool in = in_turned(t, dim, x);
        const double nearest = nearest_of_turned(t, dim, x, &blur);
        inside += in;
        assert_close(distance_of(part, dim, x), in ? -nearest : nearest, blur);
    }
    assert_in_range(inside, 10, 60);
}

static void box_is_as_far_as_its_nearest_face(void **state)
{
    (void)state;
    const MnsPart part = {.primitive = MNS_BOX, .a = {0.1, -0.2, 0.3}, .b = {0.9, 0.5, 1.4}};
    const Turned t = {{0.5, 0.15, 0.85}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0.4, 0.35, 0.55}};
    assert_is_turned(part, &t, 3);
    const Turned flat = {{0.5, 0.15, 0}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0.4, 0.35, 0}};
    assert_is_turned(part, &flat, 2);
}

static void plate_lies_along_its_length_and_across_its_normal(void **state)
{
    (void)state;
    const double c = cos(0.4), s = sin(0.4);
    /* In two dimensions `normal` does not count; in three only its part across `along` does. */
    const MnsPart flat = {.primitive = MNS_PLATE,
                          .a = {0.4, 0.6, 0},
                          .b = {3 * c, 3 * s, 0},
                          .c = {7, 7, 7},
                          .length = 1.2,
                          .width = 9,
                          .thickness = 0.5};
    const Turned t2 = {{0.4, 0.6, 0}, {{c, s, 0}, {-s, c, 0}, {0, 0, 1}}, {0.6, 0.25, 0}};
    assert_is_turned(flat, &t2, 2);
    const MnsPart solid = {.primitive = MNS_PLATE,
                           .a = {0.4, 0.6, 0.5},
                           .b = {3 * c, 3 * s, 0},
                           .c = {5 * c - s, 5 * s + c, 0},
                           .length = 1.2,
                           .width = 1.6,
                           .thickness = 0.7};
    const Turned t3 = {{0.4, 0.6, 0.5}, {{c, s, 0}, {-s, c, 0}, {0, 0, 1}}, {0.6, 0.35, 0.8}};
    assert_is_turned(solid, &t3, 3);
}

static void cylinder_in_two_dimensions_is_a_rectangle(void **state)
{
    (void)state;
    const double c = cos(-0.7), s = sin(-0.7);
    const MnsPart part = {
        .primitive = MNS_CYLINDER, .a = {0.2, 0.9, 0}, .b = {0.2 + 1.1 * c, 0.9 + 1.1 * s, 0}, .radius = 0.3};
    const Turned t = {{0.2 + 0.55 * c, 0.9 + 0.55 * s, 0}, {{c, s, 0}, {-s, c, 0}, {0, 0, 1}}, {0.55, 0.3, 0}};
    assert_is_turned(part, &t, 2);
}

/* Cylinder from (0.2, 0.1, 0.3) along an oblique axis: points are made from their place along, across and around it. */
static void cylinder_in_three_dimensions_has_a_mantle_and_two_lids(void **state)
{
    (void)state;
    const double e[3] = {2.0 / 3, 1.0 / 3, 2.0 / 3}, n[3] = {1 / sqrt(5), -2 / sqrt(5), 0}, length = 0.9, radius = 0.4;
    const double b[3] = {e[1] * n[2] - e[2] * n[1], e[2] * n[0] - e[0] * n[2], e[0] * n[1] - e[1] * n[0]};
    MnsPart part = {.primitive = MNS_CYLINDER, .a = {0.2, 0.1, 0.3}, .radius = radius};
    for (int d = 0; d < 3; d++) part.b[d] = part.a[d] + length * e[d];
    uint64_t seed = 3;
    for (int k = 0; k < 300; k++) {
        const double along = 0.45 + 0.9 * cloud_noise(&seed), across = 0.4 + 0.4 * cloud_noise(&seed),
                     turn = 4 * cloud_noise(&seed);
        double x[3];
        for (int d = 0; d < 3; d++) x[d] = part.a[d] + along * e[d] + across * (cos(turn) * n[d] + sin(turn) * b[d]);
        const double beyond = fmax(-along, along - length), off = across - radius;
        double expected = beyond > 0 && off > 0 ? hypot(beyond, off) : fmax(beyond, off);
        assert_close(distance_of(part, 3, x), expected, 1e-14); /* rounding */
    }
}

static void ball_is_round(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const MnsPart part = {.primitive = MNS_BALL, .a = {0.4, 0.7, dim == 3 ? 0.1 : 0}, .radius = 0.6};
        uint64_t seed = 5;
        for (int k = 0; k < 100; k++) {
            double x[3];
            random_point(dim, &seed, x);
            assert_close(distance_of(part, dim, x), apart(x, part.a) - 0.6, 1e-15); /* rounding */
        }
    }
}

static void half_space_lies_behind_its_normal(void **state)
{
    (void)state;
    const MnsPart part = {.primitive = MNS_HALF_SPACE, .a = {0.3, 0.2, -0.4}, .b = {2, -3, 6}};
    assert_close(distance_of(part, 3, (const double[]){0.3 + 2, 0.2 - 3, -0.4 + 6}), 7, 1e-14);
    assert_close(distance_of(part, 3, (const double[]){0.3 - 4, 0.2 + 6, -0.4 - 12}), -14, 1e-14);
    assert_close(distance_of(part, 3, (const double[]){0.3 + 3, 0.2 + 2, -0.4}), 0, 1e-15); /* along the plane */
}

static void outside_of_a_primitive_is_all_it_is_not(void **state)
{
    (void)state;
    static const MnsPrimitive all[] = {MNS_BOX, MNS_BALL, MNS_CYLINDER, MNS_HALF_SPACE};
    uint64_t seed = 9;
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        MnsPart part = {.primitive = all[k], .a = {0.1, 0.2, 0.3}, .b = {0.8, 1.1, 0.9}, .radius = 0.4};
        double x[3];
        random_point(3, &seed, x);
        const double distance = distance_of(part, 3, x);
        part.outside = true;
        assert_true(distance_of(part, 3, x) == -distance);
    }
}

static void formula_knows_inside_and_outside_only(void **state)
{
    (void)state;
    char text[] = "y < 0.3 + 0.1*x and z < 2";
    MnsPart part = {.primitive = MNS_FORMULA, .formula = text};
    assert_true(distance_of(part, 3, (const double[]){1, 0.39, 1}) == -INFINITY);
    assert_true(distance_of(part, 3, (const double[]){1, 0.41, 1}) == INFINITY);
    part.outside = true;
    assert_true(distance_of(part, 3, (const double[]){1, 0.41, 1}) == -INFINITY);
}

static void formula_that_is_none_is_named_with_its_part(void **state)
{
    (void)state;
    char good[] = "y < 1", bad[] = "y <";
    MnsPart parts[] = {{.primitive = MNS_FORMULA, .formula = good}, {.primitive = MNS_FORMULA, .formula = bad}};
    const MnsShape shape = {2, parts};
    Shape s;
    MnsError error = {0};
    assert_int_equal(shape_init(&s, &shape, 2, NULL, 0, "fluids[3].shape", &error), MNS_E_INVALID);
    assert_string_equal(error.path, "fluids[3].shape[1].formula");
    shape_done(&s);
}

/* Parts of a shape in every combination of operations, against membership of the primitives. */
static void operations_are_those_of_sets_from_first_to_last(void **state)
{
    (void)state;
    MnsPart parts[3] = {{.primitive = MNS_BOX, .a = {0, 0, 0}, .b = {0.9, 0.8, 1}},
                        {.primitive = MNS_BALL, .a = {0.8, 0.5, 0.4}, .radius = 0.5},
                        {.primitive = MNS_HALF_SPACE, .a = {0.3, 0.4, 0.5}, .b = {1, 2, -1}}};
    for (int first = 0; first < 3; first++)
        for (int second = 0; second < 3; second++) {
            parts[1].operation = (MnsOperation)first;
            parts[2].operation = (MnsOperation)second;
            parts[2].outside = first == 1;
            const MnsShape shape = {3, parts};
            Shape s;
            assert_int_equal(shape_init(&s, &shape, 3, NULL, 0, "shape", NULL), MNS_OK);
            uint64_t seed = 17;
            int inside = 0;
            for (int k = 0; k < 400; k++) {
                double x[3];
                random_point(3, &seed, x);
                bool in = false;
                for (int p = 0; p < 3; p++) {
                    MnsPart alone = parts[p];
                    alone.operation = MNS_ADD;
                    const bool here = distance_of(alone, 3, x) < 0;
                    in = parts[p].operation == MNS_ADD        ? in || here
                         : parts[p].operation == MNS_SUBTRACT ? in && !here
                                                              : in && here;
                }
                inside += in;
                assert_int_equal(shape_distance(&s, x) < 0, in);
            }
            assert_in_range(inside, 1, 399);
            shape_done(&s);
        }
}

static void shape_of_no_parts_holds_nothing(void **state)
{
    (void)state;
    const MnsShape shape = {0, NULL};
    Shape s;
    assert_int_equal(shape_init(&s, &shape, 2, NULL, 0, "shape", NULL), MNS_OK);
    assert_true(shape_distance(&s, (const double[]){0, 0, 0}) == INFINITY);
    shape_done(&s);
}

/* Two points' distances differ by no more than the points: so it never promises more room than there is. */
static void distance_never_exceeds_the_way_to_the_surface(void **state)
{
    (void)state;
    MnsPart parts[3] = {{.primitive = MNS_BOX, .outside = true, .b = {1, 0.7, 0.9}},
                        {.primitive = MNS_PLATE,
                         .a = {0.5, 0.2, 0.4},
                         .b = {1, 2, 0},
                         .c = {-2, 1, 1},
                         .length = 0.6,
                         .width = 0.5,
                         .thickness = 0.2},
                        {.operation = MNS_SUBTRACT, .primitive = MNS_CYLINDER, .b = {1, 1, 1}, .radius = 0.1}};
    const MnsShape shape = {3, parts};
    Shape s;
    assert_int_equal(shape_init(&s, &shape, 3, NULL, 0, "shape", NULL), MNS_OK);
    uint64_t seed = 23;
    for (int k = 0; k < 3000; k++) {
        double x[3], y[3];
        random_point(3, &seed, x);
        random_point(3, &seed, y);
        for (int d = 0; k % 2 && d < 3; d++) y[d] = x[d] + 0.05 * (y[d] - x[d]);
        assert_true(fabs(shape_distance(&s, x) - shape_distance(&s, y)) <= apart(x, y) * (1 + 1e-12));
    }
    shape_done(&s);
}

static void normals_point_away_from_the_solid(void **state)
{
    (void)state;
    MnsPart parts[2] = {{.primitive = MNS_BOX, .outside = true, .b = {2, 1, 1.5}},
                        {.primitive = MNS_BALL, .a = {1, 0.4, 0.7}, .radius = 0.2}};
    static const struct {
        double x[3], normal[3];
    } rows[] = {
        {{0.9, 0.02, 0.6}, {0, 1, 0}},                             /* floor */
        {{0.9, -0.02, 0.6}, {0, 1, 0}},                            /* behind it */
        {{1.97, 0.5, 0.6}, {-1, 0, 0}},                            /* right side */
        {{0.9, 0.5, 1.53}, {0, 0, -1}},                            /* behind the far side */
        {{1 + 0.6 * 0.23, 0.4 - 0.8 * 0.23, 0.7}, {0.6, -0.8, 0}}, /* beside the ball */
    };
    for (int dim = 2; dim <= 3; dim++) {
        parts[1].a[2] = dim == 3 ? 0.7 : 0;
        const MnsShape shape = {2, parts};
        Shape s;
        assert_int_equal(shape_init(&s, &shape, dim, NULL, 0, "shape", NULL), MNS_OK);
        for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
            if (dim == 2 && rows[k].normal[2] != 0) continue;
            const double x[3] = {rows[k].x[0], rows[k].x[1], dim == 3 ? rows[k].x[2] : 0};
            double normal[3];
            shape_normal(&s, x, 1e-5, normal);
            /* Differences over 1e-5 beside a curvature of 5: off by 5^2 1e-10. */
            for (int d = 0; d < 3; d++) assert_close(normal[d], rows[k].normal[d], 1e-8);
        }
        shape_done(&s);
    }
}

/* Anyhow placed, across the seams; the last is longer than a period and oblique. */
static const MnsPart BOUNDED[] = {
    {.primitive = MNS_BOX, .a = {-0.3, 0.1, 0.2}, .b = {0.5, 0.6, 0.7}},
    {.primitive = MNS_BALL, .a = {1.9, -0.2, 0.4}, .radius = 0.35},
    {.primitive = MNS_CYLINDER, .a = {0.2, 0.9, -0.2}, .b = {0.9, 0.3, 0.3}, .radius = 0.2},
    {.primitive = MNS_PLATE,
     .a = {0.1, 0.95, 0},
     .b = {3, 1, 0},
     .c = {0, 1, 1},
     .length = 2.5,
     .width = 0.3,
     .thickness = 0.1},
};

static void what_repeats_itself_is_as_far_as_its_nearest_image(void **state)
{
    (void)state;
    static const double period[3] = {1.7, 0, 1.3};
    uint64_t seed = 5;
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < sizeof BOUNDED / sizeof *BOUNDED; k++) {
            Shape s;
            MnsPart part = BOUNDED[k];
            const MnsShape shape = {1, &part};
            assert_int_equal(shape_init(&s, &shape, dim, NULL, 0, "shape", NULL), MNS_OK);
            shape_repeat(&s, period);
            for (int n = 0; n < 300; n++) {
                double x[3], least = INFINITY;
                random_point(dim, &seed, x);
                for (int a = -3; a <= 3; a++)
                    for (int b = dim == 3 ? -3 : 0; b <= (dim == 3 ? 3 : 0); b++) {
                        const double y[3] = {x[0] + a * period[0], x[1], x[2] + b * period[2]};
                        least = fmin(least, distance_of(part, dim, y));
                    }
                assert_close(shape_distance(&s, x), least, 1e-12); /* rounding */
                part.outside = true;
                assert_close(shape_distance(&s, x), -least, 1e-12);
                part.outside = false;
            }
            shape_done(&s);
        }
}

/* A channel or a pipe along a periodic direction has no ends, from which a guard would push. */
static void what_is_as_long_as_a_period_has_no_ends(void **state)
{
    (void)state;
    static const double period[3] = {1.5, 0, 0};
    static const MnsPart parts[] = {
        {.primitive = MNS_BOX, .a = {0, -0.2, -0.2}, .b = {1.5, 0.2, 0.2}},
        {.primitive = MNS_CYLINDER, .a = {0, 0, 0}, .b = {1.5, 0, 0}, .radius = 0.2},
        {.primitive = MNS_PLATE,
         .a = {0.3, 0, 0},
         .b = {-2, 0, 0},
         .c = {0, 1, 0},
         .length = 2,
         .width = 0.4,
         .thickness = 0.4},
    };
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) {
            Shape s;
            MnsPart part = parts[k];
            const MnsShape shape = {1, &part};
            assert_int_equal(shape_init(&s, &shape, dim, NULL, 0, "shape", NULL), MNS_OK);
            shape_repeat(&s, period);
            for (int n = 0; n < 30; n++) {
                const double x[3] = {-0.7 + 0.1 * n, 0.05, 0};
                assert_close(shape_distance(&s, x), -0.15, 1e-12); /* rounding */
            }
            shape_done(&s);
        }
}

static void assert_face(const Face *face, const double point[3], const double normal[3])
{
    for (int d = 0; d < 3; d++) {
        assert_close(face->point[d], point[d], 1e-15);
        assert_close(face->normal[d], normal[d], 1e-15);
    }
}

/* A tank, a plate in it, a part cut off, and a ball, which has none. */
static void flat_faces_are_found_with_normals_away_from_the_solid(void **state)
{
    (void)state;
    MnsPart parts[] = {{.primitive = MNS_BOX, .outside = true, .a = {1, 2}, .b = {4, 3}},
                       {.primitive = MNS_PLATE, .a = {2, 2.5}, .b = {0, 2}, .length = 0.8, .thickness = 0.2},
                       {.primitive = MNS_HALF_SPACE, .operation = MNS_SUBTRACT, .a = {3, 9}, .b = {0, 5}},
                       {.primitive = MNS_BALL, .a = {3, 2.5}, .radius = 0.2}};
    const MnsShape shape = {4, parts};
    Shape s;
    Face faces[4 * FACES_MAX];
    assert_int_equal(shape_init(&s, &shape, 2, NULL, 0, "shape", NULL), MNS_OK);
    assert_int_equal(shape_faces(&s, faces), 9);
    assert_face(&faces[0], (const double[3]){1, 2.5, 0}, (const double[3]){1, 0, 0});
    assert_face(&faces[1], (const double[3]){4, 2.5, 0}, (const double[3]){-1, 0, 0});
    assert_face(&faces[2], (const double[3]){2.5, 2, 0}, (const double[3]){0, 1, 0});
    assert_face(&faces[3], (const double[3]){2.5, 3, 0}, (const double[3]){0, -1, 0});
    assert_face(&faces[4], (const double[3]){2, 2.1, 0}, (const double[3]){0, -1, 0});
    assert_face(&faces[5], (const double[3]){2, 2.9, 0}, (const double[3]){0, 1, 0});
    assert_face(&faces[6], (const double[3]){2.1, 2.5, 0}, (const double[3]){1, 0, 0});
    assert_face(&faces[7], (const double[3]){1.9, 2.5, 0}, (const double[3]){-1, 0, 0});
    assert_face(&faces[8], (const double[3]){3, 9, 0}, (const double[3]){0, -1, 0});
    shape_repeat(&s, (const double[3]){3, 0, 0}); /* the tank has no ends now */
    assert_int_equal(shape_faces(&s, faces), 7);
    shape_done(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(box_is_as_far_as_its_nearest_face),
        cmocka_unit_test(plate_lies_along_its_length_and_across_its_normal),
        cmocka_unit_test(cylinder_in_two_dimensions_is_a_rectangle),
        cmocka_unit_test(cylinder_in_three_dimensions_has_a_mantle_and_two_lids),
        cmocka_unit_test(ball_is_round),
        cmocka_unit_test(half_space_lies_behind_its_normal),
        cmocka_unit_test(outside_of_a_primitive_is_all_it_is_not),
        cmocka_unit_test(formula_knows_inside_and_outside_only),
        cmocka_unit_test(formula_that_is_none_is_named_with_its_part),
        cmocka_unit_test(operations_are_those_of_sets_from_first_to_last),
        cmocka_unit_test(shape_of_no_parts_holds_nothing),
        cmocka_unit_test(distance_never_exceeds_the_way_to_the_surface),
        cmocka_unit_test(normals_point_away_from_the_solid),
        cmocka_unit_test(what_repeats_itself_is_as_far_as_its_nearest_image),
        cmocka_unit_test(what_is_as_long_as_a_period_has_no_ends),
        cmocka_unit_test(flat_faces_are_found_with_normals_away_from_the_solid),
    };
    return cmocka_run_group_tests_name("shape", tests, NULL, NULL);
}
