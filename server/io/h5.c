/* SPDX-License-Identifier: BSD-3-Clause */
/* The dozen HDF5 calls we use: each returns everything it opened, and does nothing once a call on the file has failed. */
#include "io/h5.h"
#include "io/atomic_file.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { MAX_RANK = 4 };

/* --- failures ------------------------------------------------------------------------------------------------------------ */

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

/* What HDF5 says about the call that just failed; or the disk, if that was the reason. */
static void refuse(H5 *h, const char *name)
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

/* Whether to go on: a full disk ends the work here, not after gigabytes more. */
static bool going(H5 *h, const char *name)
{
    if (!h->status && h->disk.failure) refuse(h, name);
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

static void close_id(hid_t id)
{
    if (id >= 0) H5Idec_ref(id);
}

/* --- writing ------------------------------------------------------------------------------------------------------------- */

/* Link creation that makes the groups on the way. */
static hid_t new_link(void)
{
    const hid_t link = H5Pcreate(H5P_LINK_CREATE);
    if (link >= 0) H5Pset_create_intermediate_group(link, 1);
    return link;
}

void h5_make_group(H5 *h, const char *name)
{
    if (!going(h, name)) return;
    const hid_t link = new_link();
    const hid_t group = H5Gcreate2(h->file, name, link, H5P_DEFAULT, H5P_DEFAULT);
    if (group < 0) refuse(h, name);
    close_id(group);
    close_id(link);
}

void h5_make(H5 *h, const char *name, hid_t type, int rank, const hsize_t *dims)
{
    if (!going(h, name)) return;
    const hid_t link = new_link(), space = rank ? H5Screate_simple(rank, dims, NULL) : H5Screate(H5S_SCALAR);
    const hid_t set = H5Dcreate2(h->file, name, type, space, link, H5P_DEFAULT, H5P_DEFAULT);
    if (set < 0) refuse(h, name);
    close_id(set);
    close_id(space);
    close_id(link);
}

/* Select rows first ... first+n-1 of a dataset. @return their dataspace in memory, negative on failure. */
static hid_t select_rows(hid_t space, size_t first, size_t n)
{
    hsize_t count[MAX_RANK], start[MAX_RANK] = {first};
    const int rank = H5Sget_simple_extent_ndims(space);
    if (rank < 1 || rank > MAX_RANK || H5Sget_simple_extent_dims(space, count, NULL) < 0) return -1;
    count[0] = n;
    if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) < 0 || H5Sselect_valid(space) <= 0) return -1;
    return H5Screate_simple(rank, count, NULL);
}

void h5_put_rows(H5 *h, const char *name, hid_t type, size_t first, size_t n, const void *data)
{
    if (n == 0 || !going(h, name)) return;
    const hid_t set = H5Dopen2(h->file, name, H5P_DEFAULT), space = H5Dget_space(set);
    const hid_t memory = select_rows(space, first, n);
    if (memory < 0 || H5Dwrite(set, type, memory, space, H5P_DEFAULT, data) < 0) refuse(h, name);
    close_id(memory);
    close_id(space);
    close_id(set);
}

void h5_put(H5 *h, const char *name, hid_t type, size_t n, const void *data)
{
    h5_make(h, name, type, 1, (hsize_t[]){n});
    h5_put_rows(h, name, type, 0, n, data);
}

static hid_t new_text_type(size_t size)
{
    const hid_t type = H5Tcopy(H5T_C_S1);
    if (type >= 0) H5Tset_size(type, size), H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

void h5_put_texts(H5 *h, const char *name, size_t n, const char *const *texts)
{
    const hid_t type = new_text_type(H5T_VARIABLE);
    h5_put(h, name, type, n, texts);
    close_id(type);
}

void h5_put_text(H5 *h, const char *name, const char *text)
{
    const hid_t type = new_text_type(strlen(text) + 1);
    h5_make(h, name, type, 0, NULL);
    if (going(h, name)) {
        const hid_t set = H5Dopen2(h->file, name, H5P_DEFAULT);
        if (H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) < 0) refuse(h, name);
        close_id(set);
    }
    close_id(type);
}

void h5_mark(H5 *h, const char *name, const char *attribute, hid_t type, size_t n, const void *values)
{
    if (!going(h, name)) return;
    const hid_t space = n ? H5Screate_simple(1, (hsize_t[]){n}, NULL) : H5Screate(H5S_SCALAR);
    const hid_t mark =
        H5Acreate_by_name(h->file, name, attribute, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    if (mark < 0 || H5Awrite(mark, type, values) < 0) refuse(h, attribute);
    close_id(mark);
    close_id(space);
}

void h5_mark_text(H5 *h, const char *name, const char *attribute, const char *text)
{
    const hid_t type = new_text_type(strlen(text) + 1);
    h5_mark(h, name, attribute, type, 0, text);
    close_id(type);
}

/* --- reading ------------------------------------------------------------------------------------------------------------- */

/* H5Lexists() fails if a group on the way is missing, so the way is walked. */
bool h5_has(H5 *h, const char *name)
{
    char part[256];
    const size_t length = strlen(name);
    if (length >= sizeof part || !going(h, name)) return false;
    for (size_t k = 1; k <= length; k++) {
        if (name[k] != '/' && name[k] != '\0') continue;
        memcpy(part, name, k);
        part[k] = '\0';
        if (H5Lexists(h->file, part, H5P_DEFAULT) <= 0) return false;
    }
    return true;
}

size_t h5_members(H5 *h, const char *group)
{
    H5G_info_t info = {0};
    if (going(h, group) && H5Gget_info_by_name(h->file, group, &info, H5P_DEFAULT) < 0) refuse(h, group);
    return (size_t)info.nlinks;
}

/* @return the rank, at least 1; 0 after a failure. */
static int shape(H5 *h, const char *name, hsize_t dims[static MAX_RANK])
{
    if (!going(h, name)) return 0;
    const hid_t set = H5Dopen2(h->file, name, H5P_DEFAULT), space = set < 0 ? -1 : H5Dget_space(set);
    const int rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
    if (rank < 0)
        refuse(h, name);
    else if (rank < 1 || rank > MAX_RANK)
        h5_raise(h, MNS_E_CORRUPT, "'%s' of '%s' has %d dimensions", name, h->path, rank);
    else if (H5Sget_simple_extent_dims(space, dims, NULL) < 0)
        refuse(h, name);
    close_id(space);
    close_id(set);
    return h->status ? 0 : rank;
}

size_t h5_rows(H5 *h, const char *name)
{
    hsize_t dims[MAX_RANK] = {0};
    return shape(h, name, dims) ? (size_t)dims[0] : 0;
}

void h5_expect(H5 *h, const char *name, int rank, const hsize_t *dims)
{
    hsize_t found[MAX_RANK] = {0};
    bool same = shape(h, name, found) == rank;
    for (int k = 0; k < rank && same; k++) same = found[k] == dims[k];
    if (!same) h5_raise(h, MNS_E_CORRUPT, "'%s' of '%s' does not have the shape it should have", name, h->path);
}

void h5_get_rows(H5 *h, const char *name, hid_t type, size_t first, size_t n, void *data)
{
    if (n == 0 || !going(h, name)) return;
    const hid_t set = H5Dopen2(h->file, name, H5P_DEFAULT), space = set < 0 ? -1 : H5Dget_space(set);
    const hid_t memory = space < 0 ? -1 : select_rows(space, first, n);
    if (memory < 0 || H5Dread(set, type, memory, space, H5P_DEFAULT, data) < 0) refuse(h, name);
    close_id(memory);
    close_id(space);
    close_id(set);
}

void h5_get_mark(H5 *h, const char *name, const char *attribute, hid_t type, void *value)
{
    if (!going(h, attribute)) return;
    const hid_t mark = H5Aopen_by_name(h->file, name, attribute, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = mark < 0 ? -1 : H5Aget_space(mark);
    if (space < 0 || H5Sget_simple_extent_npoints(space) != 1 || H5Aread(mark, type, value) < 0) refuse(h, attribute);
    close_id(space);
    close_id(mark);
}

bool h5_mark_is(H5 *h, const char *name, const char *attribute, const char *text)
{
    char found[256] = "";
    if (!going(h, attribute) || strlen(text) >= sizeof found) return false;
    const hid_t type = new_text_type(sizeof found);
    h5_get_mark(h, name, attribute, type, found);
    close_id(type);
    return !h->status && strcmp(found, text) == 0;
}
