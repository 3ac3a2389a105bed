/* SPDX-License-Identifier: BSD-3-Clause */
/* Arrays as they go over the wire: as exact as asked, as small as can be had quickly. What comes out depends on what goes in alone,
 * and on the versions of the codecs. proto/packing.proto says what the bytes are. Any thread may call these. */
#ifndef COMMON_WIRE_PACKING_H
#define COMMON_WIRE_PACKING_H

#include "packing.pb-c.h"
#include <meniscus/status.h>
#include <stddef.h>

enum { PACKING_DIMS = 4, PACKING_OFFSETS = 16, PACKING_SHUFFLE = 256 };

/* An array in memory, row-major. */
typedef struct PackingArray {
    const char *name, *unit,
        *type; /* type as numpy writes it; what is said about exactness is for "<f8", others stay as they are */
    size_t n_dims, shape[PACKING_DIMS];
    const void *data;
} PackingArray;

typedef enum PackingExactness { PACKING_F64, PACKING_F32, PACKING_BOUNDED } PackingExactness;

typedef struct PackingHow {
    PackingExactness exactness;
    double bound; /* of PACKING_BOUNDED: > 0, in the unit of the array, for each component by itself */
    Meniscus__Codec codec;
} PackingHow;

/* Packed bytes and what they are. The manifest lives as long as the whole. */
typedef struct Packed {
    const Meniscus__PackedArray *manifest;
    const void *data; /* [size]; the bytes of the array itself, not a copy, if nothing had to be changed */
    size_t size;
} Packed;

/* Pack. The array must stay as it is while the result is in use; its name and unit are copied. MNS_OK; MNS_E_INVALID for a bound that is not
 * above 0 and finite, a codec, an exactness or a type that there is not, more dimensions than PACKING_DIMS; MNS_E_LIMIT for a shape too large for memory; MNS_E_MEMORY. */
MnsStatus packing_pack(const PackingArray *array, const PackingHow *how, Packed **ret, MnsError *error);

/* NULL is fine. */
void packing_free(Packed *packed);

/* Can there be such an array, and has it at most `limit` bytes, packed as well as unpacked? To be asked before anything is done, or kept room for, because
 * of a manifest from outside. MNS_OK and the bytes it unpacks to; MNS_E_CORRUPT if it contradicts itself, MNS_E_LIMIT, MNS_E_VERSION for a
 * codec or a type that is not known here. */
MnsStatus packing_check(const Meniscus__PackedArray *manifest, size_t limit, size_t *ret_size, MnsError *error);

/* Unpack what came from outside into `ret` of `size` bytes, those that packing_check() told. Takes up to twice as much memory
 * meanwhile. MNS_OK; as packing_check() with this size for a limit; MNS_E_CORRUPT if the bytes are not what the manifest says they are;
 * MNS_E_MEMORY. On failure *ret holds nothing of use. */
MnsStatus packing_unpack(const Meniscus__PackedArray *manifest, const void *packed, size_t packed_size, void *ret,
                         size_t size, MnsError *error);

/* "none", "lz4", "zstd"; NULL for a number that is no codec. */
const char *packing_codec_name(Meniscus__Codec codec);

#endif
