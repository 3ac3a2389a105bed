/* SPDX-License-Identifier: BSD-3-Clause */
/* Datasets and attributes out of an HDF5 file: each call closes what it opens, and does nothing after a failure. */
#include "io/h5_parts.h"

#include <string.h>
#include <sys/stat.h>

/* H5Lexists() fails if a group on the way is missing, so the way is walked. */
bool h5_has(H5 *h, const char *name)
{
    char part[256];
    const size_t length = strlen(name);
    if (length >= sizeof part || !h5_going(h, name)) return false;
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
    if (h5_going(h, group) && H5Gget_info_by_name(h->file, group, &info, H5P_DEFAULT) < 0) h5_refuse(h, group);
    return (size_t)info.nlinks;
}

/* @return the rank, at least 1; 0 after a failure. */
static int shape(H5 *h, const char *name, hsize_t dims[static H5_MAX_RANK])
{
    if (!h5_going(h, name)) return 0;
    const hid_t set = H5Dopen2(h->file, name, H5P_DEFAULT), space = set < 0 ? -1 : H5Dget_space(set);
    const int rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
    if (rank < 0) h5_refuse(h, name);
    else if (rank < 1 || rank > H5_MAX_RANK)
        h5_raise(h, MNS_E_CORRUPT, "'%s' of '%s' has %d dimensions", name, h->path, rank);
    else if (H5Sget_simple_extent_dims(space, dims, NULL) < 0) h5_refuse(h, name);
    h5_close_id(space);
    h5_close_id(set);
    return h->status ? 0 : rank;
}

size_t h5_rows(H5 *h, const char *name)
{
    hsize_t dims[H5_MAX_RANK] = {0};
    return shape(h, name, dims) ? (size_t)dims[0] : 0;
}

void h5_expect(H5 *h, const char *name, int rank, const hsize_t *dims)
{
    hsize_t found[H5_MAX_RANK] = {0};
    bool same = shape(h, name, found) == rank;
    for (int k = 0; k < rank && same; k++) same = found[k] == dims[k];
    if (!same) h5_raise(h, MNS_E_CORRUPT, "'%s' of '%s' does not have the shape it should have", name, h->path);
}

void h5_expect_bytes(H5 *h, uint64_t bytes)
{
    struct stat about;
    if (h->status) return;
    if (fstat(h->disk.fd, &about) == 0 && bytes <= (uint64_t)about.st_size) return;
    h5_raise(h, MNS_E_CORRUPT, "'%s' is damaged: it says that it holds more bytes than it has", h->path);
}

void h5_get_rows(H5 *h, const char *name, hid_t type, size_t first, size_t n, void *data)
{
    if (n == 0 || !h5_going(h, name)) return;
    const hid_t set = H5Dopen2(h->file, name, H5P_DEFAULT), space = set < 0 ? -1 : H5Dget_space(set);
    const hid_t memory = space < 0 ? -1 : h5_select_rows(space, first, n);
    if (memory < 0 || H5Dread(set, type, memory, space, H5P_DEFAULT, data) < 0) h5_refuse(h, name);
    h5_close_id(memory);
    h5_close_id(space);
    h5_close_id(set);
}

void h5_get(H5 *h, const char *name, hid_t type, size_t n, void *data)
{
    h5_expect(h, name, 1, (hsize_t[]){n});
    h5_get_rows(h, name, type, 0, n, data);
}

void h5_get_mark(H5 *h, const char *name, const char *attribute, hid_t type, void *value)
{
    if (!h5_going(h, attribute)) return;
    const hid_t mark = H5Aopen_by_name(h->file, name, attribute, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = mark < 0 ? -1 : H5Aget_space(mark);
    if (space < 0 || H5Sget_simple_extent_npoints(space) != 1 || H5Aread(mark, type, value) < 0)
        h5_refuse(h, attribute);
    h5_close_id(space);
    h5_close_id(mark);
}

bool h5_has_mark(H5 *h, const char *name, const char *attribute)
{
    return h5_has(h, name) && H5Aexists_by_name(h->file, name, attribute, H5P_DEFAULT) > 0;
}

bool h5_mark_is(H5 *h, const char *name, const char *attribute, const char *text)
{
    char found[256] = "";
    const hid_t type = h5_new_text_type(sizeof found);
    h5_get_mark(h, name, attribute, type, found);
    h5_close_id(type);
    return !h->status && strcmp(found, text) == 0;
}
