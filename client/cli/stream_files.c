/* SPDX-License-Identifier: BSD-3-Clause */
/* Items of a stream as files: arrays as numpy reads them, snapshots as they are in the run directory. */
#include "client/cli/stream.h"
#include "client/cli/whole_file.h"
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

enum { NPY_ALIGNMENT = 64, NPY_PREAMBLE = 10 };

/* The head of an .npy file, format 1.0: a Python literal, padded with blanks to a multiple of 64 bytes. */
static size_t npy_head(const MnsArray *array, char ret[256])
{
    static const char magic[] = {'\x93', 'N', 'U', 'M', 'P', 'Y', 1, 0};
    char shape[100] = "";
    for (size_t d = 0; d < array->n_dims; d++)
        snprintf(shape + strlen(shape), sizeof shape - strlen(shape), "%zu,", array->shape[d]);
    char *literal = ret + NPY_PREAMBLE;
    const int n =
        snprintf(literal, 200, "{'descr': '%s', 'fortran_order': False, 'shape': (%s), }", array->type, shape);
    const size_t used = NPY_PREAMBLE + (size_t)n + 1,
                 whole = (used + NPY_ALIGNMENT - 1) / NPY_ALIGNMENT * NPY_ALIGNMENT;
    memset(literal + n, ' ', whole - used);
    ret[whole - 1] = '\n';
    memcpy(ret, magic, sizeof magic);
    ret[8] = (char)((whole - NPY_PREAMBLE) & 0xff);
    ret[9] = (char)((whole - NPY_PREAMBLE) >> 8);
    return whole;
}

static bool write_npy(FILE *file, const void *arg)
{
    const MnsArray *array = arg;
    char head[256];
    const size_t size = npy_head(array, head);
    return fwrite(head, 1, size, file) == size && fwrite(array->data, 1, array->size, file) == array->size;
}

MnsStatus stream_put_arrays(const char *directory, const MnsStreamItem *item, MnsError *error)
{
    char path[PATH_MAX];
    for (size_t a = 0; a < item->n_arrays; a++) {
        if (strchr(item->arrays[a].name, '/'))
            return mns_fail(error, MNS_E_CORRUPT, "a field has a name that no file can have");
        snprintf(path, sizeof path, "%s/%s-%010" PRIu64 ".npy", directory, item->arrays[a].name, item->step);
        const MnsStatus status = whole_file_write(path, "the array", write_npy, &item->arrays[a], error);
        if (status) return status;
    }
    return MNS_OK;
}

MnsStatus stream_put_file(const char *directory, const MnsStreamItem *item, MnsError *error)
{
    char path[PATH_MAX];
    if (item->abandoned || !item->file) return MNS_OK;
    snprintf(path, sizeof path, "%s/%s", directory, item->file);
    const FilePiece piece = {item->data, item->size, item->offset, item->whole};
    return whole_file_piece(path, "the snapshot", &piece, error);
}
