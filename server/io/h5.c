/* SPDX-License-Identifier: BSD-3-Clause */
/* What writing and reading HDF5 share: failures as status and sentence, types, selections. */
#include "io/atomic_file.h"
#include "io/h5_parts.h"

#include <stdarg.h>
#include <stdio.h>

void h5_raise(H5 *h, MnsStatus status, const char *format, ...)
{
    if (h->status) return;
    char text[sizeof h->error->text];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    h->status = mns_fail(h->error, status, "%s", text);
}

/* Upwards: the first entry is the deepest, which says what was wrong. */
static herr_t deepest(unsigned k, const H5E_error2_t *entry, void *arg)
{
    if (k == 0) *(const char **)arg = entry->desc;
    return 0;
}

void h5_refuse(H5 *h, const char *name)
{
    const char *reason = NULL;
    const char *verb = h->writing ? "write" : "read";
    if (h->status) return;
    if (h->disk.failure) {
        h->status = file_fail(h->error, h->disk.failure, verb, h->path);
        return;
    }
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, deepest, &reason);
    h5_raise(h, h->writing ? MNS_E_IO : MNS_E_CORRUPT, "cannot %s '%s' of '%s': HDF5 says: %s", verb, name, h->path,
             reason ? reason : "nothing");
}

bool h5_going(H5 *h, const char *name)
{
    if (!h->status && h->disk.failure) h5_refuse(h, name);
    return !h->status;
}

hid_t h5_type(MnsType type)
{
    return type == MNS_F64 ? H5T_NATIVE_DOUBLE : type == MNS_U32 ? H5T_NATIVE_UINT32 : H5T_NATIVE_UINT8;
}

size_t h5_size(MnsType type)
{
    return type == MNS_F64 ? sizeof(double) : type == MNS_U32 ? sizeof(uint32_t) : sizeof(uint8_t);
}

void h5_close_id(hid_t id)
{
    if (id >= 0) H5Idec_ref(id);
}

hid_t h5_select_rows(hid_t space, size_t first, size_t n)
{
    hsize_t count[H5_MAX_RANK], start[H5_MAX_RANK] = {first};
    const int rank = H5Sget_simple_extent_ndims(space);
    if (rank < 1 || rank > H5_MAX_RANK || H5Sget_simple_extent_dims(space, count, NULL) < 0) return -1;
    count[0] = n;
    if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) < 0 || H5Sselect_valid(space) <= 0)
        return -1;
    return H5Screate_simple(rank, count, NULL);
}

hid_t h5_new_text_type(size_t size)
{
    const hid_t type = H5Tcopy(H5T_C_S1);
    if (type >= 0) H5Tset_size(type, size), H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}
