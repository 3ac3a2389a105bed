/* SPDX-License-Identifier: BSD-3-Clause */
/* Unpacking what came from outside: nothing is believed that was not checked, and no more memory taken than was agreed to. */
#include "common/wire/frame.h"
#include "common/wire/packing.h"
#include "common/wire/packing_numbers.h"

#include <lz4.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>
#include <zstd.h>

/* A name from outside, in a sentence. */
static const char *called(const Meniscus__PackedArray *manifest)
{
    return manifest->name ? manifest->name : "";
}

static MnsStatus corrupt(const Meniscus__PackedArray *manifest, const char *what, MnsError *error)
{
    return mns_fail(error, MNS_E_CORRUPT, "the array \"%.64s\" came damaged: %s", called(manifest), what);
}

/* Numbers of the shape. False if there are too many for memory. */
static bool count_of(const Meniscus__PackedArray *manifest, size_t *ret)
{
    *ret = 1;
    for (size_t d = 0; d < manifest->n_shape; d++)
        if (__builtin_mul_overflow(*ret, manifest->shape[d], ret)) return false;
    return true;
}

static MnsStatus check_quantisation(const Meniscus__PackedArray *manifest, size_t n, MnsError *error)
{
    const Meniscus__Quantisation *q = manifest->quantisation;
    if (!q) return MNS_OK;
    if (strcmp(manifest->type, "<f8") != 0) return corrupt(manifest, "it is quantised, but not of type <f8", error);
    if (q->width != 1 && q->width != 2 && q->width != 4)
        return corrupt(manifest, "it is quantised to integers of other than 1, 2 or 4 bytes", error);
    if (q->n_offset < 1 || q->n_offset > PACKING_OFFSETS || n % q->n_offset)
        return corrupt(manifest, "it does not have 1 to 16 offsets that fit its shape", error);
    bool finite = q->has_step && isfinite(q->step);
    for (size_t c = 0; c < q->n_offset; c++) finite = finite && isfinite(q->offset[c]);
    return finite ? MNS_OK : corrupt(manifest, "its step or an offset is not finite, or missing", error);
}

/* Bytes of its numbers as they are before a codec, and after. */
static size_t plain_size(const Meniscus__PackedArray *manifest, size_t n)
{
    return n * (manifest->quantisation ? manifest->quantisation->width : number_size(manifest->type));
}

static MnsStatus check_bytes(const Meniscus__PackedArray *manifest, size_t n, MnsError *error)
{
    const size_t plain = plain_size(manifest, n);
    if (!manifest->has_packed_bytes || !manifest->has_xxh64)
        return corrupt(manifest, "its manifest does not tell its size and checksum", error);
    if (manifest->has_shuffle &&
        (manifest->shuffle < 2 || manifest->shuffle > PACKING_SHUFFLE || plain % manifest->shuffle))
        return corrupt(manifest, "its bytes cannot have been shuffled in rows of that length", error);
    if (manifest->codec == MENISCUS__CODEC__CODEC_NONE
            ? manifest->packed_bytes != plain
            : manifest->packed_bytes >= plain ||
                  (manifest->codec == MENISCUS__CODEC__CODEC_LZ4 && plain > LZ4_MAX_INPUT_SIZE))
        return corrupt(manifest, "its sizes contradict each other", error);
    return MNS_OK;
}

MnsStatus packing_check(const Meniscus__PackedArray *manifest, size_t limit, size_t *ret_size, MnsError *error)
{
    size_t n, size;
    const size_t number = manifest->type ? number_size(manifest->type) : 0;
    if (!number)
        return mns_fail(error, MNS_E_VERSION, "the array \"%.64s\" is of type \"%.16s\", which is not known here",
                        called(manifest), manifest->type ? manifest->type : "");
    if (!packing_codec_name(manifest->codec))
        return mns_fail(error, MNS_E_VERSION, "the array \"%.64s\" is packed by codec %d, which is not known here",
                        called(manifest), (int)manifest->codec);
    if (manifest->n_shape > PACKING_DIMS) return corrupt(manifest, "it has more than 4 dimensions", error);
    if (!count_of(manifest, &n) || __builtin_mul_overflow(n, number, &size) || size > limit)
        return mns_fail(error, MNS_E_LIMIT, "the array \"%.64s\" is larger than the %zu bytes there is room for",
                        called(manifest), limit);
    if (!manifest->has_raw_bytes || manifest->raw_bytes != size)
        return corrupt(manifest, "its size is not that of its type and shape", error);
    MnsStatus status = check_quantisation(manifest, n, error);
    if (!status) status = check_bytes(manifest, n, error);
    if (!status) *ret_size = size;
    return status;
}

/* False unless the codec makes just so many bytes of them. */
static bool decode(Meniscus__Codec codec, const void *packed, size_t packed_size, void *ret, size_t size)
{
    if (codec == MENISCUS__CODEC__CODEC_ZSTD)
        return ZSTD_getFrameContentSize(packed, packed_size) == size &&
               ZSTD_findFrameCompressedSize(packed, packed_size) == packed_size &&
               ZSTD_decompress(ret, size, packed, packed_size) == size;
    const int got = LZ4_decompress_safe(packed, ret, (int)packed_size, (int)size);
    return got >= 0 && (size_t)got == size;
}

static void restore(const Meniscus__Quantisation *q, const void *integers, size_t n, double *ret)
{
    Grid grid = {.components = q->n_offset, .step = q->step, .width = q->width};
    memcpy(grid.offset, q->offset, q->n_offset * sizeof *q->offset);
    grid_restore(&grid, integers, n, ret);
}

/* The steps of packing backwards. The last one writes to ret, each one before to memory of its own; that of the integers is aligned. */
static MnsStatus undo(const Meniscus__PackedArray *manifest, const void *packed, size_t packed_size, void *ret,
                      size_t n, MnsError *error)
{
    const size_t plain = plain_size(manifest, n);
    const bool coded = manifest->codec != MENISCUS__CODEC__CODEC_NONE;
    const bool shuffled = manifest->has_shuffle, quantised = manifest->quantisation;
    const bool two = coded && (shuffled || quantised), three = quantised && (shuffled || !coded);
    uint8_t *decoded = two ? malloc(plain) : NULL, *rows = three ? malloc(plain) : NULL;
    MnsStatus status = MNS_OK;
    if ((two && !decoded) || (three && !rows))
        status = mns_fail(error, MNS_E_MEMORY, "no memory to unpack an array of %zu bytes", plain);
    const void *at = packed;
    if (!status && coded) {
        uint8_t *to = decoded ? decoded : ret;
        if (!decode(manifest->codec, packed, packed_size, to, plain))
            status = corrupt(manifest, "its codec does not make the bytes of its shape of what came", error);
        at = to;
    }
    if (!status && (shuffled || !coded)) {
        uint8_t *to = rows ? rows : ret;
        if (shuffled) numbers_unshuffle(at, plain / manifest->shuffle, manifest->shuffle, to);
        else memcpy(to, at, plain);
        at = to;
    }
    if (!status && quantised) restore(manifest->quantisation, at, n, ret);
    free(rows);
    free(decoded);
    return status;
}

MnsStatus packing_unpack(const Meniscus__PackedArray *manifest, const void *packed, size_t packed_size, void *ret,
                         size_t size, MnsError *error)
{
    size_t needed, n = 0;
    const MnsStatus status = packing_check(manifest, size, &needed, error);
    if (status) return status;
    if (needed != size) return corrupt(manifest, "there is room for another size", error);
    if (packed_size != manifest->packed_bytes)
        return corrupt(manifest, "not all of its bytes came, or too many", error);
    if (XXH64(packed_size ? packed : "", packed_size, 0) != manifest->xxh64)
        return corrupt(manifest, "its checksum does not match", error);
    if (!count_of(manifest, &n) || !n) return MNS_OK;
    return undo(manifest, packed, packed_size, ret, n, error);
}
