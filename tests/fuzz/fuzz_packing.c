/* SPDX-License-Identifier: BSD-3-Clause */
/* An array from a socket: it is refused by a sentence, or there is just what was agreed to. Input: the length of a manifest in two bytes, the
 * manifest, the packed bytes. What says that they came whole is made to match, or no input would get any further. */
#include "common/wire/packing.h"
#include "tests/fuzz/fuzz.h"
#include <string.h>
#include <xxhash.h>

enum { LIMIT = 1 << 20 };

static void unpack(Meniscus__PackedArray *manifest, const uint8_t *packed, size_t packed_size)
{
    MnsError error = {0};
    size_t size = 0;
    manifest->has_packed_bytes = manifest->has_xxh64 = 1;
    manifest->packed_bytes = packed_size;
    manifest->xxh64 = XXH64(packed, packed_size, 0);
    MnsStatus status = packing_check(manifest, LIMIT, &size, &error);
    if (status) PROMISE(*error.text && !size);
    else {
        void *array = malloc(size + !size); /* of just that size, for the address sanitizer */
        PROMISE(size <= LIMIT && array);
        status = packing_unpack(manifest, packed, packed_size, array, size, &error);
        PROMISE(!status || *error.text);
        free(array);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const size_t length = size < 2 ? 0 : data[0] + 256u * data[1];
    if (size < 2 + length) return 0;
    Meniscus__PackedArray *manifest = meniscus__packed_array__unpack(NULL, length, data + 2);
    if (!manifest) return 0;
    unpack(manifest, data + 2 + length, size - 2 - length);
    meniscus__packed_array__free_unpacked(manifest, NULL);
    return 0;
}
