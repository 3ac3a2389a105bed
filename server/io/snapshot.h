/* SPDX-License-Identifier: BSD-3-Clause */
/* Field snapshots for people: VTKHDF files that ParaView opens, and the index that gives them their times. */
#ifndef IO_SNAPSHOT_H
#define IO_SNAPSHOT_H

#include "io/file.h"

/* Write a capture as path ("....hdf"): a temporary file, fsync, rename. Vectors get three components in 2D too.
 * MNS_OK; MNS_E_NO_SPACE, MNS_E_IO: no file of that name is left, or the old one whole. */
MnsStatus snapshot_write(const char *path, const MnsCapture *capture, const FileMeta *meta, MnsError *error);

/* (Re)write DIR/snapshots.hdf.series from the snapshot files in dir up to a step, UINT64_MAX: all, so that ParaView knows their times. Those that
 * cannot be read are left out; note() is told of each, if it is given. ret_n: how many it lists; may be NULL. */
MnsStatus snapshot_index(const char *dir, uint64_t last, size_t *ret_n, FileNote *note, void *arg, MnsError *error);

#endif
