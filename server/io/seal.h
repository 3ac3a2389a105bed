/* SPDX-License-Identifier: BSD-3-Clause */
/* A seal in front of an HDF5 file: HDF5 skips the first SEAL_SIZE bytes, so h5py and h5dump open sealed files as
 * they are. We check the seal before HDF5 sees anything, because HDF5 may crash on a damaged file.
 *
 *  bytes 0-7    "MENISCUS"
 *        8-11   version of our file formats, little endian like all that follows
 *        16-23  size of the whole file
 *        24-31  xxh64 of what follows the seal
 *        32-39 a number that grows from one checkpoint of a directory to the next, 0 if the file has none
 *        40-63 how far the journal of its run had come, a JournalPlace, all 0 if that is not known
 *        504-511 xxh64 of the seal's first 504 bytes */
#ifndef IO_SEAL_H
#define IO_SEAL_H

#include "io/file.h"
#include <meniscus/status.h>
#include <stdbool.h>
#include <stdint.h>

enum { SEAL_SIZE = 512, SEAL_VERSION = 1 };

/* What a seal tells of its file. */
typedef struct SealNote {
    uint64_t number;
    JournalPlace journal;
    uint64_t sum; /* of what follows; seal_write() finds it by itself */
} SealNote;

/* Seal an open file that has SEAL_SIZE bytes free in front. */
MnsStatus seal_write(int fd, const char *path, const SealNote *note, MnsError *error);

/* The seal of a file, without a look at what follows. False if it has no whole one. */
bool seal_read(const char *path, SealNote *ret);

/* MNS_OK; MNS_E_CORRUPT if anything at all has changed since it was sealed, or it never was; MNS_E_VERSION. */
MnsStatus seal_check(int fd, const char *path, MnsError *error);

#endif
