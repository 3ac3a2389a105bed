/* SPDX-License-Identifier: BSD-3-Clause */
/* Field snapshots for people: VTKHDF files that ParaView opens, and the index that gives them their times. */
#ifndef IO_SNAPSHOT_H
#define IO_SNAPSHOT_H

#include "io/file.h"

/* Write a capture as path ("....hdf"): a temporary file, fsync, rename. Vectors get three components in 2D too.
 * MNS_OK; MNS_E_NO_SPACE, MNS_E_IO: no file of that name is left, or the old one whole. */
MnsStatus snapshot_write(const char *path, const MnsCapture *capture, const FileMeta *meta, MnsError *error);

/* (Re)write DIR/snapshots.hdf.series from the snapshot files in dir, so that ParaView knows their times. Those that cannot
 * be read are left out; note() is told of each, if it is given. */
MnsStatus snapshot_index(const char *dir, FileNote *note, void *arg, MnsError *error);

#endif
