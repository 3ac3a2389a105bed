/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that outlive a power cut. */
#ifndef COMMON_HOST_DISK_H
#define COMMON_HOST_DISK_H

#include <meniscus/status.h>
#include <stdio.h>

/* Have the directory of a file on the disk, as a name that was given or taken away is not, before. @return 0 or an errno. */
int disk_sync_above(const char *path);

/* Open a regular file as fopen() does, by "r", "w" or "r+". What else has its name holds nothing up, as a pipe without another end would, and is refused.
 * NULL: errno says why, ENXIO or EISDIR that it is no file. */
FILE *disk_open(const char *path, const char *mode);

/* Of an errno of writing: MNS_E_NO_SPACE if disk, quota or size limit is used up, else MNS_E_IO. */
MnsStatus disk_status(int code);

#endif
