/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that outlive a power cut. */
#include "proto/disk.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* File systems that cannot sync a directory say EINVAL; there is nothing more to do for them. */
int disk_sync_above(const char *path)
{
    char directory[4096];
    const char *slash = strrchr(path, '/');
    snprintf(directory, sizeof directory, "%.*s", slash && slash > path ? (int)(slash - path) : 1, slash ? path : ".");
    const int fd = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return errno;
    const int code = fsync(fd) && errno != EINVAL ? errno : 0;
    close(fd);
    return code;
}

MnsStatus disk_status(int code)
{
    return code == ENOSPC || code == EDQUOT || code == EFBIG ? MNS_E_NO_SPACE : MNS_E_IO;
}
