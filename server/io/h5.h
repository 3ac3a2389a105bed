/* SPDX-License-Identifier: BSD-3-Clause */
/* The dozen HDF5 calls we use. A file is filled or read by a function between opening and closing; the first failure
 * makes all further calls on it do nothing, so that function reads as a plain list of what the file holds.
 *
 * Names are paths from the root, as in "/state/velocity"; groups on the way are made as needed. Numbers are stored
 * in the type they have in memory. */
#ifndef IO_H5_H
#define IO_H5_H

#include "io/h5_driver.h"
#include "io/seal.h"
#include <meniscus/sim.h>

typedef struct H5 {
    hid_t file;
    const char *path;
    Disk disk;
    bool writing;
    SealNote seal;    /* of a sealed file; fill() may set it */
    MnsStatus status; /* of the first failure; MNS_OK: none */
    MnsError *error;  /* its sentence; may be NULL */
} H5;

typedef void H5Fill(H5 *h, const void *what);
typedef void H5Read(H5 *h, void *into);

/* Write a whole file atomically. @param sealed  protect it with a seal: see seal.h
 * MNS_OK; MNS_E_NO_SPACE, MNS_E_IO, MNS_E_MEMORY, what fill() raised: no new file, an old one untouched. */
MnsStatus h5_save(const char *path, bool sealed, H5Fill *fill, const void *what, MnsError *error);

/* Open a file and read it. @param sealed  refuse a file whose seal is missing or broken, before HDF5 sees it
 * MNS_OK; MNS_E_NOT_FOUND, MNS_E_IO, MNS_E_CORRUPT, MNS_E_VERSION, what read() raised. */
MnsStatus h5_load(const char *path, bool sealed, H5Read *read, void *into, MnsError *error);

/* Raise a failure of our own: the first one counts. */
void h5_raise(H5 *h, MnsStatus status, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* The HDF5 type and the size in bytes of a field's values. */
hid_t h5_type(MnsType type);
size_t h5_size(MnsType type);

/* --- writing: datasets, then attributes of them ------------------------------------------------------------------ */

void h5_make_group(H5 *h, const char *name);
void h5_make(H5 *h, const char *name, hid_t type, int rank, const hsize_t *dims);
void h5_put_rows(H5 *h, const char *name, hid_t type, size_t first, size_t n,
                 const void *data);                                           /* [n][all other dims] */
void h5_put(H5 *h, const char *name, hid_t type, size_t n, const void *data); /* makes and fills [n] */
void h5_put_texts(H5 *h, const char *name, size_t n, const char *const *texts);
void h5_mark(H5 *h, const char *name, const char *attribute, hid_t type, size_t n,
             const void *values); /* n 0: a scalar */
void h5_mark_text(H5 *h, const char *name, const char *attribute, const char *text);

/* --- reading ----------------------------------------------------------------------------------------------------- */

bool h5_has(H5 *h, const char *name);                                   /* a path, none of whose parts need exist */
size_t h5_members(H5 *h, const char *group);                            /* how many it has */
size_t h5_rows(H5 *h, const char *name);                                /* the first dimension of a dataset */
void h5_expect(H5 *h, const char *name, int rank, const hsize_t *dims); /* raises MNS_E_CORRUPT if the shape differs */

/* Raises MNS_E_CORRUPT if the whole file has fewer bytes, so that no memory is asked for on its word. */
void h5_expect_bytes(H5 *h, uint64_t bytes);

void h5_get_rows(H5 *h, const char *name, hid_t type, size_t first, size_t n, void *data); /* [n][all other dims] */
void h5_get(H5 *h, const char *name, hid_t type, size_t n, void *data); /* all of [n]; or as h5_expect() */
void h5_get_mark(H5 *h, const char *name, const char *attribute, hid_t type, void *value); /* a scalar */
bool h5_has_mark(H5 *h, const char *name, const char *attribute);
bool h5_mark_is(H5 *h, const char *name, const char *attribute, const char *text); /* what h5_mark_text() wrote */

#endif
