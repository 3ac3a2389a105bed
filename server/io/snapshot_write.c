/* SPDX-License-Identifier: BSD-3-Clause */
/* Snapshots as VTKHDF unstructured grids, version 1.0: one vertex cell per particle.
 *
 * That version and the ending .hdf are what ParaView 5.11 opens by itself. Nothing is compressed: some
 * builds of ParaView lack the filters. */
#include "io/columns.h"
#include "io/meta.h"
#include "io/snapshot.h"

#include <stdio.h>
#include <stdlib.h>

enum { VTK_VERTEX = 1, BLOCK = 1 << 16 };

typedef struct Snapshot {
    const MnsCapture *capture;
    const FileMeta *meta;
    size_t n; /* particles to write: all, or the fluid, which comes first */
} Snapshot;

/* The reader wants this attribute as a string of fixed length without an end mark. */
static void mark_type(H5 *h)
{
    static const char name[] = "UnstructuredGrid";
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, sizeof name - 1);
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    h5_mark(h, "/VTKHDF", "Type", type, 0, name);
    H5Tclose(type);
}

static void put_counts(H5 *h, size_t n)
{
    static const char *const names[] = {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"};
    const int64_t count = (int64_t)n;
    char name[64];
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        snprintf(name, sizeof name, "/VTKHDF/%s", names[k]);
        h5_put(h, name, H5T_NATIVE_INT64, 1, &count);
    }
}

/* Dataset name [n] of 0, 1, 2 ... */
static void put_counting(H5 *h, const char *name, size_t n)
{
    int64_t *values = malloc(BLOCK * sizeof *values);
    if (!values) h5_raise(h, MNS_E_MEMORY, "no memory for a buffer of %d rows", BLOCK);
    h5_make(h, name, H5T_NATIVE_INT64, 1, (hsize_t[]){n});
    for (size_t first = 0; first < n && !h->status; first += BLOCK) {
        const size_t count = n - first < BLOCK ? n - first : BLOCK;
        for (size_t k = 0; k < count; k++) values[k] = (int64_t)(first + k);
        h5_put_rows(h, name, H5T_NATIVE_INT64, first, count, values);
    }
    free(values);
}

static void put_types(H5 *h, size_t n)
{
    static const char name[] = "/VTKHDF/Types";
    uint8_t types[4096];
    for (size_t k = 0; k < sizeof types; k++) types[k] = VTK_VERTEX;
    h5_make(h, name, H5T_NATIVE_UINT8, 1, (hsize_t[]){n});
    for (size_t first = 0; first < n && !h->status; first += sizeof types)
        h5_put_rows(h, name, H5T_NATIVE_UINT8, first, n - first < sizeof types ? n - first : sizeof types, types);
}

static void put_field(H5 *h, const Snapshot *s, const char *name, int k)
{
    const MnsFieldInfo *field = &mns_fields()[k];
    columns_put(h, name, field->type, s->n, field->components, (const void *const *)s->capture->data[k]);
    meta_put_field(h, name, field);
}

static void put_fields(H5 *h, const Snapshot *s)
{
    const int position = mns_field_find("position");
    char name[128];
    put_field(h, s, "/VTKHDF/Points", position);
    h5_make_group(h, "/VTKHDF/PointData");
    for (int k = 0; mns_fields()[k].name; k++) {
        if (k == position || !(s->capture->fields >> k & 1)) continue;
        snprintf(name, sizeof name, "/VTKHDF/PointData/%s", mns_fields()[k].name);
        put_field(h, s, name, k);
    }
}

static void fill(H5 *h, const void *what)
{
    const Snapshot *s = what;
    h5_make_group(h, "/VTKHDF");
    h5_mark(h, "/VTKHDF", "Version", H5T_NATIVE_INT64, 2, (const int64_t[]){1, 0});
    mark_type(h);
    put_counts(h, s->n);
    put_counting(h, "/VTKHDF/Connectivity", s->n);
    put_counting(h, "/VTKHDF/Offsets", s->n + 1);
    put_types(h, s->n);
    put_fields(h, s);
    meta_put_run(h, s->meta);
    meta_put_moment(h, s->capture, s->n);
}

MnsStatus snapshot_write(const char *path, const MnsCapture *capture, const FileMeta *meta, MnsError *error)
{
    const size_t n = meta->c->output.walls ? capture->n : capture->n_fluid;
    if (!(capture->fields >> mns_field_find("position") & 1))
        return mns_fail(error, MNS_E_INVALID, "a snapshot needs the field 'position'");
    return h5_save(path, false, fill, &(Snapshot){capture, meta, n}, error);
}
