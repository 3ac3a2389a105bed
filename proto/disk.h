/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that outlive a power cut. */
#ifndef PROTO_DISK_H
#define PROTO_DISK_H

#include <meniscus/status.h>

/* Have the directory of a file on the disk, as a name that was given or taken away is not, before. @return 0 or an errno. */
int disk_sync_above(const char *path);

/* Of an errno of writing: MNS_E_NO_SPACE if disk, quota or size limit is used up, else MNS_E_IO. */
MnsStatus disk_status(int code);

#endif
