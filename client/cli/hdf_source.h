/* SPDX-License-Identifier: BSD-3-Clause */
/* Files of HDF5 from outside, of which nothing is believed: for the commands that read snapshots and series. */
#ifndef CLI_HDF_SOURCE_H
#define CLI_HDF_SOURCE_H

#include <hdf5.h>
#include <meniscus/status.h>
#include <stdbool.h>

typedef struct Source {
    hid_t file;
    const char *path;
    MnsError *error;
    H5E_auto2_t print; /* what HDF5 did about failures before */
    void *print_arg;
} Source;

/* Both are borrowed until source_close(). MNS_E_NOT_FOUND, MNS_E_IO, MNS_E_CORRUPT. */
MnsStatus source_open(Source *s, const char *path, MnsError *error);
void source_close(Source *s);

/* MNS_E_CORRUPT: the file is not what it should be, and why. */
MnsStatus source_damaged(const Source *s, const char *what);

/* Is there a group or dataset of this name, which begins with a slash? */
bool source_has(const Source *s, const char *name);

/* A number that is an attribute of /meniscus, as a type of HDF5's; false if there is none. */
bool source_number(const Source *s, const char *name, hid_t type, void *ret);

/* A text of fixed length, at the object of that name; empty if there is none. */
void source_text(const Source *s, const char *object, const char *name, size_t size, char *ret);

/* Rows and columns of a dataset of numbers; a vector has one column. False: it is none, or has more than nine columns. */
bool source_shape(const Source *s, const char *name, hsize_t shape[2]);

/* All of a dataset with `rows` rows as doubles, to be freed. MNS_E_CORRUPT, MNS_E_MEMORY. */
MnsStatus source_numbers(const Source *s, const char *name, size_t rows, int *ret_columns, double **ret);

#endif
