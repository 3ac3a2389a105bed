/* SPDX-License-Identifier: BSD-3-Clause */
/* Arrays for the wire: what is unpacked is what was packed, or nearer than was asked; and what comes damaged is refused by a sentence. */
#include "common/wire/frame.h"
#include "common/wire/packing.h"
#include "tests/support/check.h"
#include "tests/support/draw.h"
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

enum { LARGEST = 5000, CODECS = 3 };

static PackingArray doubles(const double *x, size_t n, size_t components)
{
    return (PackingArray){.name = "velocity",
                          .unit = "m/s",
                          .type = "<f8",
                          .n_dims = components > 1 ? 2 : 1,
                          .shape = {n / components, components},
                          .data = x};
}

/* What a receiver has of it, in memory of just that size; its manifest goes over the wire. */
static void *received(const Packed *packed, size_t *ret_size)
{
    const size_t length = meniscus__packed_array__get_packed_size(packed->manifest);
    uint8_t *wire = malloc(length);
    meniscus__packed_array__pack(packed->manifest, wire);
    Meniscus__PackedArray *manifest = meniscus__packed_array__unpack(NULL, length, wire);
    free(wire);
    assert_non_null(manifest);
    MnsError error = {0};
    assert_int_equal(packing_check(manifest, SIZE_MAX, ret_size, &error), MNS_OK);
    void *ret = malloc(*ret_size + !*ret_size);
    if (packing_unpack(manifest, packed->data, packed->size, ret, *ret_size, &error)) fail_msg("%s", error.text);
    meniscus__packed_array__free_unpacked(manifest, NULL);
    return ret;
}

static Packed *pack(const PackingArray *array, const PackingHow *how)
{
    Packed *packed = NULL;
    MnsError error = {0};
    if (packing_pack(array, how, &packed, &error)) fail_msg("%s", error.text);
    return packed;
}

static bool departs(const Packed *packed, Meniscus__Departure why)
{
    for (size_t k = 0; k < packed->manifest->n_departures; k++)
        if (packed->manifest->departures[k] == why) return true;
    return false;
}

/* |a - b| < bound, without rounding: the difference is s + r, with r what its rounding lost. */
static bool nearer(double a, double b, double bound)
{
    const double s = a - b, t = s - a, r = (a - (s - t)) - (b + t);
    if (fabs(s) != bound) return fabs(s) < bound;
    return s > 0 ? r < 0 : r > 0;
}

/* --- arrays of all kinds ------------------------------------------------------------------------------------------------ */

typedef void Fill(double *x, size_t n, uint64_t *seed);

static void fill_noise(double *x, size_t n, uint64_t *seed)
{
    for (size_t k = 0; k < n; k++) x[k] = 200 * draw_share(seed) - 73;
}
static void fill_smooth(double *x, size_t n, uint64_t *seed)
{
    const double phase = draw_share(seed);
    for (size_t k = 0; k < n; k++) x[k] = 1e5 + 3e4 * sin(phase + 0.002 * (double)k);
}
static void fill_bits(double *x, size_t n, uint64_t *seed) /* anything at all: NaN, infinities, denormals */
{
    for (size_t k = 0; k < n; k++) {
        const uint64_t bits = draw(seed);
        memcpy(&x[k], &bits, sizeof bits);
    }
}
static void fill_denormals(double *x, size_t n, uint64_t *seed)
{
    for (size_t k = 0; k < n; k++) x[k] = (k & 1 ? -1 : 1) * DBL_MIN * draw_share(seed);
}
static void fill_huge(double *x, size_t n, uint64_t *seed)
{
    for (size_t k = 0; k < n; k++) x[k] = (k & 1 ? -1 : 1) * DBL_MAX * draw_share(seed);
}
static void fill_constant(double *x, size_t n, uint64_t *seed)
{
    const double value = 1e3 * draw_share(seed);
    for (size_t k = 0; k < n; k++) x[k] = value;
}
static void fill_zeros(double *x, size_t n, uint64_t *seed)
{
    for (size_t k = 0; k < n; k++) x[k] = draw(seed) & 1 ? -0.0 : 0.0;
}
static void fill_far(double *x, size_t n, uint64_t *seed) /* small differences far from zero */
{
    for (size_t k = 0; k < n; k++) x[k] = 1e6 + 1e-4 * draw_share(seed);
}
static void fill_lattice(double *x, size_t n, uint64_t *seed) /* halves of steps, where rounding is at its worst */
{
    (void)seed;
    for (size_t k = 0; k < n; k++) x[k] = 0.001 * (double)(k % 997);
}

static Fill *const fills[] = {fill_noise,    fill_smooth, fill_bits, fill_denormals, fill_huge,
                              fill_constant, fill_zeros,  fill_far,  fill_lattice};
enum { FILLS = sizeof fills / sizeof *fills };

static void exact_values_come_back_bit_for_bit(void **state)
{
    (void)state;
    double *x = malloc(LARGEST * sizeof *x);
    uint64_t seed = 7;
    for (size_t f = 0; f < FILLS; f++)
        for (size_t n = 0; n <= LARGEST; n = n * 3 + 1)
            for (int codec = 0; codec < CODECS; codec++) {
                fills[f](x, n, &seed);
                const PackingArray array = doubles(x, n, 1);
                Packed *packed = pack(&array, &(PackingHow){.codec = (Meniscus__Codec)codec});
                size_t size;
                void *back = received(packed, &size);
                assert_int_equal(size, n * sizeof *x);
                if (n) assert_memory_equal(back, x, size);
                free(back);
                packing_free(packed);
            }
    free(x);
}

static void other_types_come_back_bit_for_bit(void **state)
{
    (void)state;
    static const char *const types[] = {"<f4", "<u8", "<u4", "|u1"};
    uint8_t *bytes = malloc(8 * LARGEST);
    uint64_t seed = 3;
    for (size_t k = 0; k < 8 * LARGEST; k++) bytes[k] = (uint8_t)(draw(&seed) % 5);
    for (size_t t = 0; t < 4; t++)
        for (int codec = 0; codec < CODECS; codec++)
            for (int exactness = 0; exactness <= PACKING_BOUNDED; exactness++) {
                const PackingArray array = {.type = types[t], .n_dims = 2, .shape = {LARGEST / 5, 5}, .data = bytes};
                const PackingHow how = {(PackingExactness)exactness, 1e3, (Meniscus__Codec)codec};
                Packed *packed = pack(&array, &how);
                size_t size;
                void *back = received(packed, &size);
                assert_int_equal(size, LARGEST * number_size(types[t]));
                assert_memory_equal(back, bytes, size);
                assert_string_equal(packed->manifest->type, types[t]);
                if (codec) assert_true(packed->size < size);
                free(back);
                packing_free(packed);
            }
    free(bytes);
}

static void floats_are_the_nearest_ones(void **state)
{
    (void)state;
    double *x = malloc(LARGEST * sizeof *x);
    uint64_t seed = 11;
    for (int codec = 0; codec < CODECS; codec++) {
        fill_noise(x, LARGEST, &seed);
        x[5] = NAN;
        x[6] = -INFINITY;
        x[7] = DBL_MIN;
        const PackingArray array = doubles(x, LARGEST, 2);
        Packed *packed = pack(&array, &(PackingHow){.exactness = PACKING_F32, .codec = (Meniscus__Codec)codec});
        size_t size;
        float *back = received(packed, &size);
        assert_int_equal(size, LARGEST * sizeof *back);
        for (size_t k = 0; k < LARGEST; k++) assert_true(isnan(x[k]) ? isnan(back[k]) : back[k] == (float)x[k]);
        free(back);
        packing_free(packed);
    }
    x[9] = 1e39;
    const PackingArray array = doubles(x, LARGEST, 2);
    Packed *packed = pack(&array, &(PackingHow){.exactness = PACKING_F32});
    assert_true(departs(packed, MENISCUS__DEPARTURE__DEPARTURE_TOO_LARGE));
    assert_string_equal(packed->manifest->type, "<f8");
    size_t size;
    void *back = received(packed, &size);
    assert_memory_equal(back, x, size);
    free(back);
    packing_free(packed);
    free(x);
}

/* Either all values keep it, or they are exact and the manifest says why. Returns how many bytes a number took. */
static unsigned keeps(const double *x, size_t n, size_t components, double bound, Meniscus__Codec codec)
{
    const PackingArray array = doubles(x, n, components);
    Packed *packed = pack(&array, &(PackingHow){PACKING_BOUNDED, bound, codec});
    const Meniscus__Quantisation *q = packed->manifest->quantisation;
    const unsigned width = q ? q->width : 8;
    size_t size;
    double *back = received(packed, &size);
    assert_int_equal(size, n * sizeof *x);
    if (q) {
        assert_true(q->bound == bound);
        for (size_t k = 0; k < n; k++)
            if (!nearer(back[k], x[k], bound))
                fail_msg("value %zu: %.17g became %.17g, bound %g", k, x[k], back[k], bound);
    } else if (n) {
        assert_true(departs(packed, MENISCUS__DEPARTURE__DEPARTURE_NOT_FINITE) ||
                    departs(packed, MENISCUS__DEPARTURE__DEPARTURE_TOO_FINE));
        assert_memory_equal(back, x, size);
    }
    free(back);
    packing_free(packed);
    return width;
}

static void a_bound_is_kept_to_the_last_bit_or_values_are_exact(void **state)
{
    (void)state;
    double *x = malloc(LARGEST * sizeof *x);
    uint64_t seed = 1;
    for (int round = 0; round < 600; round++) {
        const size_t components = 1 + draw(&seed) % 5, rows = draw(&seed) % (LARGEST / 5), n = rows * components;
        fills[draw(&seed) % FILLS](x, n, &seed);
        const double bound =
            exp2(draw_share(&seed) < 0.8 ? 40 * draw_share(&seed) - 30 : 2000 * draw_share(&seed) - 1060);
        keeps(x, n, components, bound, (Meniscus__Codec)(draw(&seed) % CODECS));
    }
    for (size_t k = 0; k < LARGEST; k++) x[k] = 0.5 * (double)k; /* in the middle between steps of twice the bound */
    assert_int_equal(keeps(x, LARGEST, 1, 0.5, MENISCUS__CODEC__CODEC_NONE), 2);
    free(x);
}

static void the_narrowest_integers_are_taken_that_keep_the_bound(void **state)
{
    (void)state;
    static const struct {
        double bound;
        unsigned width;
    } expected[] = {{1, 1}, {0.3, 2}, {0.002, 2}, {0.0005, 4}, {1e-7, 4}, {1e-8, 8}, {1e300, 1}, {5e-324, 8}};
    double *x = malloc(LARGEST * sizeof *x);
    uint64_t seed = 5;
    fill_noise(x, LARGEST, &seed); /* over 200 */
    for (size_t k = 0; k < sizeof expected / sizeof *expected; k++)
        assert_int_equal(keeps(x, LARGEST, 1, expected[k].bound, MENISCUS__CODEC__CODEC_NONE), expected[k].width);
    fill_constant(x, LARGEST, &seed);
    assert_int_equal(keeps(x, LARGEST, 1, 1e-9, MENISCUS__CODEC__CODEC_NONE), 1);
    fill_far(x, LARGEST, &seed);
    assert_int_equal(keeps(x, LARGEST, 1, 1e-6, MENISCUS__CODEC__CODEC_NONE), 1);
    assert_int_equal(keeps(x, LARGEST, 1, 1e-10, MENISCUS__CODEC__CODEC_NONE),
                     8); /* below what doubles can tell there */
    free(x);
}

/* The widths that follow from the range alone: each component counts from its own least value. */
static void components_far_apart_do_not_widen_each_other(void **state)
{
    (void)state;
    double x[300];
    uint64_t seed = 9;
    for (size_t k = 0; k < 100; k++)
        for (size_t c = 0; c < 3; c++) x[3 * k + c] = 1e4 * (double)c + draw_share(&seed);
    assert_int_equal(keeps(x, 300, 3, 0.01, MENISCUS__CODEC__CODEC_NONE), 1);
    assert_int_equal(keeps(x, 300, 1, 0.01, MENISCUS__CODEC__CODEC_NONE), 4);
}

static void one_value_that_is_not_finite_makes_all_exact(void **state)
{
    (void)state;
    static const double odd[] = {NAN, INFINITY, -INFINITY};
    double x[777];
    uint64_t seed = 2;
    for (size_t k = 0; k < 777; k += 97)
        for (size_t o = 0; o < 3; o++) {
            fill_noise(x, 777, &seed);
            x[k] = odd[o];
            const PackingArray array = doubles(x, 777, 3);
            Packed *packed = pack(&array, &(PackingHow){PACKING_BOUNDED, 0.1, MENISCUS__CODEC__CODEC_NONE});
            assert_null(packed->manifest->quantisation);
            assert_true(departs(packed, MENISCUS__DEPARTURE__DEPARTURE_NOT_FINITE));
            assert_ptr_equal(packed->data, x);
            packing_free(packed);
        }
}

static void a_codec_that_gains_nothing_is_left_out(void **state)
{
    (void)state;
    uint8_t noise[4096];
    uint64_t seed = 4;
    for (size_t k = 0; k < sizeof noise; k++) noise[k] = (uint8_t)(draw(&seed) >> 20);
    const PackingArray array = {.type = "|u1", .n_dims = 1, .shape = {sizeof noise}, .data = noise};
    for (int codec = 1; codec < CODECS; codec++) {
        Packed *packed = pack(&array, &(PackingHow){.codec = (Meniscus__Codec)codec});
        assert_int_equal(packed->manifest->codec, MENISCUS__CODEC__CODEC_NONE);
        assert_true(departs(packed, MENISCUS__DEPARTURE__DEPARTURE_NOT_SMALLER));
        assert_ptr_equal(packed->data, noise);
        packing_free(packed);
    }
}

static void bytes_are_shuffled_where_that_makes_fewer(void **state)
{
    (void)state;
    double *x = malloc(LARGEST * sizeof *x);
    uint32_t *same = malloc(LARGEST * sizeof *same);
    uint64_t seed = 8;
    fill_smooth(x, LARGEST, &seed);
    for (size_t k = 0; k < LARGEST; k++) same[k] = 0x01020304;
    for (int codec = 1; codec < CODECS; codec++) {
        const PackingArray smooth = doubles(x, LARGEST, 5);
        Packed *packed = pack(&smooth, &(PackingHow){PACKING_BOUNDED, 0.5, (Meniscus__Codec)codec});
        assert_int_equal(packed->manifest->shuffle, 5 * 2);
        assert_true(packed->size < LARGEST * 2 * 4 / 5);
        packing_free(packed);
        const PackingArray equal = {.type = "<u4", .n_dims = 1, .shape = {LARGEST}, .data = same};
        packed = pack(&equal, &(PackingHow){.codec = (Meniscus__Codec)codec});
        assert_false(packed->manifest->has_shuffle);
        packing_free(packed);
    }
    free(same);
    free(x);
}

static void the_same_array_gives_the_same_bytes(void **state)
{
    (void)state;
    double *x = malloc(LARGEST * sizeof *x), *y = malloc((LARGEST + 1) * sizeof *y);
    uint64_t seed = 6;
    fill_smooth(x, LARGEST, &seed);
    memcpy(y + 1, x, LARGEST * sizeof *x); /* elsewhere, otherwise aligned */
    for (int codec = 0; codec < CODECS; codec++)
        for (int exactness = 0; exactness <= PACKING_BOUNDED; exactness++) {
            const PackingHow how = {(PackingExactness)exactness, 1e-3, (Meniscus__Codec)codec};
            const PackingArray here = doubles(x, LARGEST, 1), there = doubles(y + 1, LARGEST, 1);
            Packed *a = pack(&here, &how), *b = pack(&there, &how);
            assert_int_equal(a->size, b->size);
            assert_memory_equal(a->data, b->data, a->size);
            assert_true(a->manifest->xxh64 == b->manifest->xxh64 && a->manifest->xxh64 == XXH64(a->data, a->size, 0));
            packing_free(a);
            packing_free(b);
        }
    free(y);
    free(x);
}

static void what_cannot_be_packed_is_refused_by_name(void **state)
{
    (void)state;
    static const double x[4] = {1, 2, 3, 4};
    static const struct {
        PackingArray array;
        PackingHow how;
        const char *path;
        MnsStatus status;
    } wrong[] = {
        {{.type = "<f8", .n_dims = 1, .shape = {4}}, {PACKING_BOUNDED, 0, 0}, "bound", MNS_E_INVALID},
        {{.type = "<f8", .n_dims = 1, .shape = {4}}, {PACKING_BOUNDED, -1, 0}, "bound", MNS_E_INVALID},
        {{.type = "<f8", .n_dims = 1, .shape = {4}}, {PACKING_BOUNDED, NAN, 0}, "bound", MNS_E_INVALID},
        {{.type = "<f8", .n_dims = 1, .shape = {4}}, {PACKING_BOUNDED, INFINITY, 0}, "bound", MNS_E_INVALID},
        {{.type = "<f8", .n_dims = 1, .shape = {4}}, {(PackingExactness)3, 1, 0}, "exactness", MNS_E_INVALID},
        {{.type = "<f8", .n_dims = 1, .shape = {4}}, {PACKING_F64, 0, (Meniscus__Codec)3}, "codec", MNS_E_INVALID},
        {{.type = "<i4", .n_dims = 1, .shape = {4}}, {PACKING_F64, 0, 0}, "type", MNS_E_INVALID},
        {{.n_dims = 1, .shape = {4}}, {PACKING_F64, 0, 0}, "type", MNS_E_INVALID},
        {{.type = "<f8", .n_dims = 5}, {PACKING_F64, 0, 0}, "shape", MNS_E_INVALID},
        {{.type = "<f8", .n_dims = 2, .shape = {SIZE_MAX, 2}}, {PACKING_F64, 0, 0}, "shape", MNS_E_LIMIT},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        Packed *packed = NULL;
        MnsError error = {0};
        PackingArray array = wrong[k].array;
        array.data = x;
        assert_int_equal(packing_pack(&array, &wrong[k].how, &packed, &error), wrong[k].status);
        assert_string_equal(error.path, wrong[k].path);
        assert_true(*error.text && !packed);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact_values_come_back_bit_for_bit),
        cmocka_unit_test(other_types_come_back_bit_for_bit),
        cmocka_unit_test(floats_are_the_nearest_ones),
        cmocka_unit_test(a_bound_is_kept_to_the_last_bit_or_values_are_exact),
        cmocka_unit_test(the_narrowest_integers_are_taken_that_keep_the_bound),
        cmocka_unit_test(components_far_apart_do_not_widen_each_other),
        cmocka_unit_test(one_value_that_is_not_finite_makes_all_exact),
        cmocka_unit_test(a_codec_that_gains_nothing_is_left_out),
        cmocka_unit_test(bytes_are_shuffled_where_that_makes_fewer),
        cmocka_unit_test(the_same_array_gives_the_same_bytes),
        cmocka_unit_test(what_cannot_be_packed_is_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
