/* SPDX-License-Identifier: BSD-3-Clause */
/* An HDF5 file driver over an open file descriptor that remembers the first failure instead of reporting it.
 *
 * HDF5 reports a full disk late, in H5Fclose() at the worst, and then leaves its file and ids open for good. With this
 * driver a failed write looks like a success to HDF5, which closes cleanly, and the caller finds the exact errno in
 * Disk.failure: data stream to the disk, no image of the file is kept in memory. */
#ifndef IO_H5_DRIVER_H
#define IO_H5_DRIVER_H

#include <hdf5.h>

typedef struct Disk {
    int fd;       /* stays the caller's */
    int failure;  /* errno of the first call that failed; 0: none */
    hid_t driver; /* from h5_driver_use() on; 0: none            */
} Disk;

/* Make the files opened with a file access list use *disk, which must outlive them. @return negative if HDF5
 * refuses. */
herr_t h5_driver_use(hid_t access, Disk *disk);

/* After the file is closed, or could not be opened. */
void h5_driver_done(Disk *disk);

#endif
