/* SPDX-License-Identifier: BSD-3-Clause */
/* What h5_write.c and h5_read.c share; nobody else needs it. */
#ifndef IO_H5_PARTS_H
#define IO_H5_PARTS_H

#include "io/h5.h"

enum { H5_MAX_RANK = 4 };

/* Whether to go on: a full disk ends the work here, not after gigabytes more. */
bool h5_going(H5 *h, const char *name);

/* Raise what HDF5 says about the call that just failed; or the disk, if that was the reason. */
void h5_refuse(H5 *h, const char *name);

/* Close whatever it is, if it is open. */
void h5_close_id(hid_t id);

/* Select rows first ... first+n-1 of a dataset's space. @return their dataspace in memory, negative on failure. */
hid_t h5_select_rows(hid_t space, size_t first, size_t n);

/* Text of `size` bytes with the zero at its end; H5T_VARIABLE: of any length, in memory a char *. */
hid_t h5_new_text_type(size_t size);

#endif
