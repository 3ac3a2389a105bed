/* SPDX-License-Identifier: BSD-3-Clause */
/* Room on a disk that nobody else can take: given up when the disk is full, so that there is some for what must not be lost.
 * The file has no name: it is gone with the process that holds it, however that ends. */
#ifndef IO_RESERVE_H
#define IO_RESERVE_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct Reserve {
    bool held;
    int fd;
    uint64_t size; /* [bytes] */
} Reserve;

/* Hold at least so many bytes in a directory: the same one as long as any are held. On failure as many as before are.
 * MNS_E_NO_SPACE: the disk or the quota has not so many left. A file system that can promise no room is none of ours to
 * refuse: MNS_OK with nothing held. */
MnsStatus reserve_hold(Reserve *reserve, const char *dir, uint64_t size, MnsError *error);

/* Give it up; nothing to do if none is held. */
void reserve_release(Reserve *reserve);

#endif
