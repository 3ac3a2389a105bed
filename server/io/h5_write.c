/* SPDX-License-Identifier: BSD-3-Clause */
/* Datasets and attributes into an HDF5 file: each call closes what it opens, and does nothing after a failure. */
#include "io/h5_parts.h"

#include <stdlib.h>
#include <string.h>

/* Link creation that makes the groups on the way. */
static hid_t new_link(void)
{
    const hid_t link = H5Pcreate(H5P_LINK_CREATE);
    if (link >= 0) H5Pset_create_intermediate_group(link, 1);
    return link;
}

void h5_make_group(H5 *h, const char *name)
{
    if (!h5_going(h, name)) return;
    const hid_t link = new_link();
    const hid_t group = H5Gcreate2(h->file, name, link, H5P_DEFAULT, H5P_DEFAULT);
    if (group < 0) h5_refuse(h, name);
    h5_close_id(group);
    h5_close_id(link);
}

void h5_make(H5 *h, const char *name, hid_t type, int rank, const hsize_t *dims)
{
    if (!h5_going(h, name)) return;
    const hid_t link = new_link(), space = H5Screate_simple(rank, dims, NULL);
    const hid_t set = H5Dcreate2(h->file, name, type, space, link, H5P_DEFAULT, H5P_DEFAULT);
    if (set < 0) h5_refuse(h, name);
    h5_close_id(set);
    h5_close_id(space);
    h5_close_id(link);
}

void h5_put_rows(H5 *h, const char *name, hid_t type, size_t first, size_t n, const void *data)
{
    if (n == 0 || !h5_going(h, name)) return;
    const hid_t set = H5Dopen2(h->file, name, H5P_DEFAULT), space = H5Dget_space(set);
    const hid_t memory = h5_select_rows(space, first, n);
    if (memory < 0 || H5Dwrite(set, type, memory, space, H5P_DEFAULT, data) < 0) h5_refuse(h, name);
    h5_close_id(memory);
    h5_close_id(space);
    h5_close_id(set);
}

void h5_put(H5 *h, const char *name, hid_t type, size_t n, const void *data)
{
    h5_make(h, name, type, 1, (hsize_t[]){n});
    h5_put_rows(h, name, type, 0, n, data);
}

/* All get the length of the longest: HDF5 can search a damaged file for texts of variable length without end. */
void h5_put_texts(H5 *h, const char *name, size_t n, const char *const *texts)
{
    size_t size = 1;
    for (size_t k = 0; k < n; k++)
        if (strlen(texts[k]) >= size) size = strlen(texts[k]) + 1;
    char *packed = calloc(n ? n : 1, size);
    if (!packed) h5_raise(h, MNS_E_MEMORY, "no memory for texts of %zu bytes", n * size);
    for (size_t k = 0; packed && k < n; k++) strcpy(packed + k * size, texts[k]);
    const hid_t type = h5_new_text_type(size);
    h5_put(h, name, type, n, packed);
    h5_close_id(type);
    free(packed);
}

void h5_mark(H5 *h, const char *name, const char *attribute, hid_t type, size_t n, const void *values)
{
    if (!h5_going(h, name)) return;
    const hid_t space = n ? H5Screate_simple(1, (hsize_t[]){n}, NULL) : H5Screate(H5S_SCALAR);
    const hid_t mark = H5Acreate_by_name(h->file, name, attribute, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    if (mark < 0 || H5Awrite(mark, type, values) < 0) h5_refuse(h, attribute);
    h5_close_id(mark);
    h5_close_id(space);
}

void h5_mark_text(H5 *h, const char *name, const char *attribute, const char *text)
{
    const hid_t type = h5_new_text_type(strlen(text) + 1);
    h5_mark(h, name, attribute, type, 0, text);
    h5_close_id(type);
}
