/* SPDX-License-Identifier: BSD-3-Clause */
/* Items of a stream as files: arrays as numpy reads them, snapshots as they are in the run directory. */
#include "client/cli/stream.h"
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { NPY_ALIGNMENT = 64, NPY_PREAMBLE = 10 };

static MnsStatus fail(const char *path, MnsError *error)
{
    const MnsStatus status = errno == ENOSPC ? MNS_E_NO_SPACE : MNS_E_IO;
    return mns_fail(error, status, "cannot write %.300s: %s; %s", path, strerror(errno), mns_refusal_hint(errno));
}

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

/* Under another name first, so that whoever looks finds it whole. */
static MnsStatus write_npy(const char *path, const MnsArray *array, MnsError *error)
{
    char head[256], part[PATH_MAX];
    const size_t size = npy_head(array, head);
    snprintf(part, sizeof part, "%s.part", path);
    FILE *file = fopen(part, "wb");
    if (!file) return fail(part, error);
    bool good = fwrite(head, 1, size, file) == size && fwrite(array->data, 1, array->size, file) == array->size;
    good = !fclose(file) && good;
    if (good && !rename(part, path)) return MNS_OK;
    const MnsStatus status = fail(path, error);
    unlink(part);
    return status;
}

MnsStatus stream_put_arrays(const char *directory, const MnsStreamItem *item, MnsError *error)
{
    char path[PATH_MAX - 8];
    for (size_t a = 0; a < item->n_arrays; a++) {
        if (strchr(item->arrays[a].name, '/'))
            return mns_fail(error, MNS_E_CORRUPT, "a field has a name that no file can have");
        snprintf(path, sizeof path, "%s/%s-%010" PRIu64 ".npy", directory, item->arrays[a].name, item->step);
        const MnsStatus status = write_npy(path, &item->arrays[a], error);
        if (status) return status;
    }
    return MNS_OK;
}

MnsStatus stream_put_file(const char *directory, const MnsStreamItem *item, MnsError *error)
{
    char path[PATH_MAX - 8], part[PATH_MAX];
    if (item->abandoned || !item->file) return MNS_OK;
    snprintf(path, sizeof path, "%s/%s", directory, item->file);
    snprintf(part, sizeof part, "%s.part", path);
    FILE *file = fopen(part, item->offset ? "r+b" : "wb");
    if (!file) return fail(part, error);
    bool good = !fseeko(file, (off_t)item->offset, SEEK_SET) &&
                (!item->size || fwrite(item->data, 1, item->size, file) == item->size);
    good = !fclose(file) && good;
    if (good && item->whole) good = !rename(part, path);
    return good ? MNS_OK : fail(path, error);
}
