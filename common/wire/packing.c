/* SPDX-License-Identifier: BSD-3-Clause */
/* Packing: numbers with fewer bytes if they need not be exact, bytes in an order that codecs like, a codec if it gains anything. */
#include "common/wire/packing.h"
#include "common/wire/frame.h"
#include "common/wire/packing_numbers.h"

#include <limits.h>
#include <lz4.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>
#include <zstd.h>

enum { ZSTD_LEVEL = 1, SAMPLE = 1 << 16, DEPARTURES = 2 };

typedef struct OwnedPacked {
    Packed packed; /* first, so that a pointer to it is a pointer to the whole */
    Meniscus__PackedArray manifest;
    Meniscus__Quantisation quantisation;
    uint64_t shape[PACKING_DIMS];
    Grid grid;
    Meniscus__Departure departures[DEPARTURES];
    void *memory; /* of the bytes, if they are not those of the array */
    char *name, *unit, type[4];
} OwnedPacked;

const char *packing_codec_name(Meniscus__Codec codec)
{
    static const char *const names[] = {"none", "lz4", "zstd"};
    const unsigned k = (unsigned)codec;
    return k < sizeof names / sizeof *names ? names[k] : NULL;
}

static void depart(OwnedPacked *to, Meniscus__Departure why)
{
    to->departures[to->manifest.n_departures++] = why;
}

/* --- numbers ------------------------------------------------------------------------------------------------------------ */

static size_t count_of(const OwnedPacked *to)
{
    size_t n = 1;
    for (size_t d = 0; d < to->manifest.n_shape; d++) n *= to->shape[d];
    return n;
}

/* The last index is that of components, if there are few. */
static size_t components_of(const OwnedPacked *to)
{
    const size_t dims = to->manifest.n_shape;
    const uint64_t last = dims > 1 ? to->shape[dims - 1] : 1;
    return last >= 1 && last <= PACKING_OFFSETS ? last : 1;
}

static void take_bytes(OwnedPacked *to, void *memory, size_t size)
{
    free(to->memory);
    to->memory = memory;
    to->packed.data = memory;
    to->packed.size = size;
}

static bool narrow(OwnedPacked *to, const double *x, size_t n)
{
    float *narrowed = malloc(n * sizeof *narrowed);
    if (!narrowed) return false;
    if (numbers_narrow(x, n, narrowed)) {
        memcpy(to->type, "<f4", sizeof to->type);
        take_bytes(to, narrowed, n * sizeof *narrowed);
    } else {
        depart(to, MENISCUS__DEPARTURE__DEPARTURE_TOO_LARGE);
        free(narrowed);
    }
    return true;
}

static void note_grid(OwnedPacked *to, double bound)
{
    Meniscus__Quantisation *q = &to->quantisation;
    q->has_width = q->has_step = q->has_bound = true;
    q->width = to->grid.width;
    q->step = to->grid.step;
    q->bound = bound;
    q->n_offset = to->grid.components;
    q->offset = to->grid.offset;
    to->manifest.quantisation = q;
}

static bool quantise(OwnedPacked *to, const double *x, size_t n, double bound)
{
    const Meniscus__Departure why = grid_find(x, n, components_of(to), bound, &to->grid);
    if (why) {
        depart(to, why);
        return true;
    }
    void *integers = malloc(n * to->grid.width);
    if (!integers) return false;
    if (grid_quantise(&to->grid, x, n, bound, integers)) {
        note_grid(to, bound);
        take_bytes(to, integers, n * to->grid.width);
    } else {
        depart(to, MENISCUS__DEPARTURE__DEPARTURE_TOO_FINE);
        free(integers);
    }
    return true;
}

/* False if there is no memory. */
static bool shrink(OwnedPacked *to, const PackingHow *how)
{
    const size_t n = count_of(to);
    const double *x = to->packed.data;
    if (strcmp(to->type, "<f8") != 0 || how->exactness == PACKING_F64) return true;
    if (!n) { /* of nothing, but of the type that was asked for */
        if (how->exactness == PACKING_F32) memcpy(to->type, "<f4", sizeof to->type);
        return true;
    }
    return how->exactness == PACKING_F32 ? narrow(to, x, n) : quantise(to, x, n, how->bound);
}

/* --- bytes -------------------------------------------------------------------------------------------------------------- */

/* Bytes that fit into the room, or 0 if there are more. */
static size_t encode(Meniscus__Codec codec, const void *data, size_t size, void *ret, size_t room)
{
    if (codec == MENISCUS__CODEC__CODEC_ZSTD) {
        const size_t packed = ZSTD_compress(ret, room, data, size, ZSTD_LEVEL);
        return ZSTD_isError(packed) ? 0 : packed;
    }
    if (size > LZ4_MAX_INPUT_SIZE) return 0;
    return (size_t)LZ4_compress_default(data, ret, (int)size, (int)room);
}

/* Are rows smaller when they are shuffled? A sample from the middle says so. */
static bool better_shuffled(Meniscus__Codec codec, const uint8_t *data, size_t size, size_t row)
{
    static const size_t room = SAMPLE + SAMPLE / 8;
    const size_t rows = size < SAMPLE ? size / row : SAMPLE / row, middle = (size / row - rows) / 2;
    const uint8_t *sample = data + middle * row;
    uint8_t *shuffled = malloc(SAMPLE), *coded = malloc(room);
    size_t with = 0, without = 0;
    if (shuffled && coded) {
        numbers_shuffle(sample, rows, row, shuffled);
        with = encode(codec, shuffled, rows * row, coded, room);
        without = encode(codec, sample, rows * row, coded, room);
    }
    free(shuffled);
    free(coded);
    return with && (!without || with < without);
}

static size_t row_of(const OwnedPacked *to)
{
    const size_t number = to->manifest.quantisation ? to->grid.width : number_size(to->type);
    return number * components_of(to);
}

/* False if there is no memory. */
static bool compress(OwnedPacked *to, Meniscus__Codec codec)
{
    const size_t size = to->packed.size, row = row_of(to);
    if (codec == MENISCUS__CODEC__CODEC_NONE || !size) return true;
    const bool shuffled = row > 1 && better_shuffled(codec, to->packed.data, size, row);
    uint8_t *planes = shuffled ? malloc(size) : NULL, *coded = malloc(size);
    const bool room = coded && (planes || !shuffled);
    if (room && shuffled) numbers_shuffle(to->packed.data, size / row, row, planes);
    const size_t packed = room ? encode(codec, shuffled ? planes : to->packed.data, size, coded, size - 1) : 0;
    free(planes);
    if (!packed) {
        free(coded);
        if (room) depart(to, MENISCUS__DEPARTURE__DEPARTURE_NOT_SMALLER);
        return room;
    }
    void *fitted = realloc(coded, packed);
    if (fitted) coded = fitted;
    take_bytes(to, coded, packed);
    to->manifest.codec = codec;
    to->manifest.has_shuffle = shuffled;
    to->manifest.shuffle = shuffled ? (uint32_t)row : 0;
    return true;
}

/* --- the whole ---------------------------------------------------------------------------------------------------------- */

static MnsStatus check(const PackingArray *array, const PackingHow *how, size_t *ret_size, MnsError *error)
{
    size_t size = array->type ? number_size(array->type) : 0;
    if (!size)
        return mns_fail_at(error, MNS_E_INVALID, "type",
                           "an array of type \"%.16s\"; there are <f8, <f4, <u8, <u4, |u1",
                           array->type ? array->type : "");
    if (!packing_codec_name(how->codec))
        return mns_fail_at(error, MNS_E_INVALID, "codec", "there is no codec %d; there are none, lz4 and zstd",
                           (int)how->codec);
    if ((unsigned)how->exactness > PACKING_BOUNDED)
        return mns_fail_at(error, MNS_E_INVALID, "exactness", "exactness is f64, f32 or bounded, not %d",
                           (int)how->exactness);
    if (how->exactness == PACKING_BOUNDED && !(how->bound > 0 && isfinite(how->bound)))
        return mns_fail_at(error, MNS_E_INVALID, "bound", "a bound is above 0 and finite; this one is %g", how->bound);
    if (array->n_dims > PACKING_DIMS)
        return mns_fail_at(error, MNS_E_INVALID, "shape", "an array has at most %d dimensions; this one has %zu",
                           PACKING_DIMS, array->n_dims);
    for (size_t d = 0; d < array->n_dims; d++)
        if (__builtin_mul_overflow(size, array->shape[d], &size) || size > PTRDIFF_MAX)
            return mns_fail_at(error, MNS_E_LIMIT, "shape", "an array of this shape does not fit into memory");
    *ret_size = size;
    return MNS_OK;
}

/* NULL if there is no memory. */
static OwnedPacked *describe(const PackingArray *array, size_t size)
{
    OwnedPacked *to = calloc(1, sizeof *to);
    if (!to) return NULL;
    meniscus__packed_array__init(&to->manifest);
    meniscus__quantisation__init(&to->quantisation);
    memcpy(to->type, array->type, sizeof to->type);
    for (size_t d = 0; d < array->n_dims; d++) to->shape[d] = array->shape[d];
    to->packed = (Packed){.manifest = &to->manifest, .data = array->data, .size = size};
    to->name = strdup(array->name ? array->name : "");
    to->unit = strdup(array->unit ? array->unit : "");
    Meniscus__PackedArray *manifest = &to->manifest;
    manifest->name = to->name;
    manifest->unit = to->unit;
    manifest->type = to->type;
    manifest->n_shape = array->n_dims;
    manifest->shape = to->shape;
    manifest->departures = to->departures;
    manifest->has_codec = manifest->has_xxh64 = manifest->has_raw_bytes = manifest->has_packed_bytes = true;
    return to;
}

MnsStatus packing_pack(const PackingArray *array, const PackingHow *how, Packed **ret, MnsError *error)
{
    size_t size = 0;
    const MnsStatus status = check(array, how, &size, error);
    if (status) return status;
    OwnedPacked *to = describe(array, size);
    if (!to || !to->name || !to->unit || !shrink(to, how) || !compress(to, how->codec)) {
        packing_free(to ? &to->packed : NULL);
        return mns_fail(error, MNS_E_MEMORY, "no memory to pack an array of %zu bytes", size);
    }
    to->manifest.raw_bytes = count_of(to) * number_size(to->type);
    to->manifest.packed_bytes = to->packed.size;
    to->manifest.xxh64 = XXH64(to->packed.size ? to->packed.data : "", to->packed.size, 0);
    *ret = &to->packed;
    return MNS_OK;
}

void packing_free(Packed *packed)
{
    if (!packed) return;
    OwnedPacked *owned = (OwnedPacked *)packed;
    free(owned->name);
    free(owned->unit);
    free(owned->memory);
    free(owned);
}
