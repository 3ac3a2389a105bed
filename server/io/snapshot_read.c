/* SPDX-License-Identifier: BSD-3-Clause */
/* Particles back from a snapshot or a checkpoint, with the fields the file has. */
#include "io/columns.h"
#include "io/snapshot.h"
#include "io/state.h"

#include <stdio.h>

static const char group[] = "/meniscus";

static uint64_t find_fields(H5 *h)
{
    char name[128];
    uint64_t fields = UINT64_C(1) << mns_field_find("position");
    for (int k = 0; mns_fields()[k].name; k++) {
        snprintf(name, sizeof name, "/VTKHDF/PointData/%s", mns_fields()[k].name);
        if (h5_has(h, name)) fields |= UINT64_C(1) << k;
    }
    return fields;
}

static void get_fields(H5 *h, MnsCapture *capture)
{
    const int position = mns_field_find("position");
    char name[128];
    for (int k = 0; mns_fields()[k].name; k++) {
        const MnsFieldInfo *field = &mns_fields()[k];
        if (!(capture->fields >> k & 1)) continue;
        if (k == position) snprintf(name, sizeof name, "/VTKHDF/Points");
        else snprintf(name, sizeof name, "/VTKHDF/PointData/%s", field->name);
        columns_get(h, name, field->type, capture->n, field->components, capture->data[k]);
    }
}

static void get_moment(H5 *h, MnsCapture *capture)
{
    h5_get_mark(h, group, "spacing", H5T_NATIVE_DOUBLE, &capture->spacing);
    h5_get_mark(h, group, "time", H5T_NATIVE_DOUBLE, &capture->progress.t);
    h5_get_mark(h, group, "dt", H5T_NATIVE_DOUBLE, &capture->progress.dt);
    h5_get_mark(h, group, "step", H5T_NATIVE_UINT64, &capture->progress.step);
}

static MnsCapture *get_snapshot(H5 *h)
{
    int dim = 0;
    uint64_t n_fluid = 0;
    const size_t n = h5_rows(h, "/VTKHDF/Points");
    h5_get_mark(h, group, "dim", H5T_NATIVE_INT, &dim);
    h5_get_mark(h, group, "fluid_particles", H5T_NATIVE_UINT64, &n_fluid);
    if (dim < 2 || dim > 3 || n > UINT32_MAX || n_fluid > n)
        h5_raise(h, MNS_E_CORRUPT, "'%s' is damaged: its numbers of dimensions and particles make no sense", h->path);
    if (h->status) return NULL;
    MnsCapture *capture = mns_capture_new(dim, n, (size_t)n_fluid, find_fields(h));
    if (!capture) {
        h5_raise(h, MNS_E_MEMORY, "no memory for the %zu particles of '%s'", n, h->path);
        return NULL;
    }
    get_moment(h, capture);
    get_fields(h, capture);
    return capture;
}

static void read_all(H5 *h, void *into)
{
    MnsCapture **capture = into;
    *capture = h5_has(h, "/state") ? state_get(h) : get_snapshot(h);
}

MnsStatus snapshot_read(const char *path, MnsCapture **ret_capture, MnsError *error)
{
    MnsCapture *capture = NULL;
    const MnsStatus status = h5_load(path, false, read_all, &capture, error);
    if (status) mns_capture_free(capture);
    else *ret_capture = capture;
    return status;
}
