/* SPDX-License-Identifier: BSD-3-Clause */
/* Packed arrays from outside: what lies, or came damaged, is refused by a sentence, whatever it is. */
#include "common/wire/packing.h"
#include "tests/support/check.h"
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

enum { ROWS = 500, COMPONENTS = 3, VALUES = ROWS * COMPONENTS };

/* Quantised to two bytes each. */
static Packed *sample(double x[VALUES], Meniscus__Codec codec)
{
    Packed *packed = NULL;
    for (size_t k = 0; k < VALUES; k++) x[k] = 1e5 + 3e4 * sin(0.002 * (double)k);
    const PackingArray array = {.name = "velocity", .type = "<f8", .n_dims = 2, .shape = {ROWS, COMPONENTS}, .data = x};
    assert_int_equal(packing_pack(&array, &(PackingHow){PACKING_BOUNDED, 1, codec}, &packed, NULL), MNS_OK);
    assert_int_equal(packed->manifest->codec, codec);
    assert_int_equal(packed->manifest->quantisation->width, 2);
    return packed;
}

/* The k-th lie; false if there are no more. */
static bool spoil(Meniscus__PackedArray *m, unsigned k)
{
    Meniscus__Quantisation *q = m->quantisation;
    switch (k) {
    case 0: m->type = NULL; break;
    case 1: m->type = (char *)"<f4"; break;
    case 2: m->type = (char *)"<c16"; break;
    case 3: m->codec = (Meniscus__Codec)3; break;
    case 4: m->codec = (Meniscus__Codec)(3 - m->codec); break; /* the other one */
    case 5: m->codec = MENISCUS__CODEC__CODEC_NONE; break;
    case 6: m->n_shape = 5; break;
    case 7: m->shape[0]++; break;
    case 8: m->shape[0] = UINT64_MAX / 2; break;
    case 9: m->raw_bytes = 8 * COMPONENTS * (m->shape[0] = 1ull << 40); break; /* a bomb, were it believed */
    case 10: m->raw_bytes--; break;
    case 11: m->has_raw_bytes = 0; break;
    case 12: m->has_packed_bytes = 0; break;
    case 13: m->packed_bytes++; break;
    case 14: m->packed_bytes = m->raw_bytes; break;
    case 15: m->has_xxh64 = 0; break;
    case 16: m->xxh64 ^= 1; break;
    case 17: m->has_shuffle = 1, m->shuffle = 0; break;
    case 18: m->has_shuffle = 1, m->shuffle = 7; break;
    case 19: m->has_shuffle = 1, m->shuffle = 1000; break;
    case 20: q->width = 3; break;
    case 21: q->width = 4; break;
    case 22: q->n_offset = 0; break;
    case 23: q->step = NAN; break;
    case 24: q->has_step = 0; break;
    case 25: q->offset[2] = INFINITY; break;
    case 26: q->n_offset = 7; break; /* of which there are no whole number */
    default: return false;
    }
    return true;
}

static void a_manifest_that_lies_is_refused_by_a_sentence(void **state)
{
    (void)state;
    double x[VALUES], back[VALUES];
    for (int codec = 1; codec <= 2; codec++) {
        bool more = true;
        for (unsigned k = 0; more; k++) {
            Packed *packed = sample(x, (Meniscus__Codec)codec);
            Meniscus__PackedArray lie = *packed->manifest;
            MnsError error = {0};
            more = spoil(&lie, k);
            const MnsStatus status = packing_unpack(&lie, packed->data, packed->size, back, sizeof back, &error);
            const bool refused = status == MNS_E_CORRUPT || status == MNS_E_LIMIT || status == MNS_E_VERSION;
            if (refused != more) fail_msg("lie %u of a manifest, codec %d: %s", k, codec, mns_status_name(status));
            assert_true(!more || *error.text);
            packing_free(packed);
        }
    }
}

/* The checksum is made to match, so that the codec itself must notice. */
static void bytes_that_are_damaged_are_noticed_or_harmless(void **state)
{
    (void)state;
    double x[VALUES];
    srand(13);
    unsigned noticed = 0, rounds = 2000;
    for (unsigned k = 0; k < rounds; k++) {
        Packed *packed = sample(x, (Meniscus__Codec)(1 + k % 2));
        Meniscus__PackedArray lie = *packed->manifest;
        const size_t size = k % 3 ? packed->size : 1 + (size_t)rand() % (packed->size - 1); /* and cut off */
        uint8_t *bytes = malloc(size);
        double *back = malloc(sizeof x); /* of just that size, for the address sanitizer */
        memcpy(bytes, packed->data, size);
        for (size_t j = (size_t)rand() % 4; j-- > 0;) bytes[(size_t)rand() % size] ^= (uint8_t)rand();
        lie.packed_bytes = size;
        lie.xxh64 = XXH64(bytes, size, 0);
        noticed += packing_unpack(&lie, bytes, size, back, sizeof x, NULL) == MNS_E_CORRUPT;
        free(back);
        free(bytes);
        packing_free(packed);
    }
    assert_true(noticed > rounds / 4);
}

static void bytes_that_are_missing_or_changed_are_noticed_by_the_checksum(void **state)
{
    (void)state;
    double x[VALUES], back[VALUES];
    for (int codec = 0; codec <= 2; codec++) {
        Packed *packed = sample(x, (Meniscus__Codec)codec);
        uint8_t *bytes = malloc(packed->size);
        memcpy(bytes, packed->data, packed->size);
        assert_int_equal(packing_unpack(packed->manifest, bytes, packed->size - 1, back, sizeof back, NULL),
                         MNS_E_CORRUPT);
        assert_int_equal(packing_unpack(packed->manifest, bytes, packed->size, back, sizeof back, NULL), MNS_OK);
        bytes[packed->size / 2] ^= 0x10;
        assert_int_equal(packing_unpack(packed->manifest, bytes, packed->size, back, sizeof back, NULL), MNS_E_CORRUPT);
        free(bytes);
        packing_free(packed);
    }
}

static void an_array_larger_than_agreed_is_refused_before_anything_is_done(void **state)
{
    (void)state;
    double x[VALUES];
    size_t size = 1;
    Packed *packed = sample(x, MENISCUS__CODEC__CODEC_ZSTD);
    assert_int_equal(packing_check(packed->manifest, sizeof x - 1, &size, NULL), MNS_E_LIMIT);
    assert_int_equal(size, 1);
    assert_int_equal(packing_check(packed->manifest, sizeof x, &size, NULL), MNS_OK);
    assert_int_equal(size, sizeof x);
    Meniscus__PackedArray larger = *packed->manifest;
    larger.packed_bytes = sizeof x; /* than without a codec */
    assert_int_equal(packing_check(&larger, sizeof x, &size, NULL), MNS_E_CORRUPT);
    packing_free(packed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_manifest_that_lies_is_refused_by_a_sentence),
        cmocka_unit_test(bytes_that_are_damaged_are_noticed_or_harmless),
        cmocka_unit_test(bytes_that_are_missing_or_changed_are_noticed_by_the_checksum),
        cmocka_unit_test(an_array_larger_than_agreed_is_refused_before_anything_is_done),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
