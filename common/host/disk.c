/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that outlive a power cut. */
#include "common/host/disk.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
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

/* @return 0 or an errno. */
static int check_regular(int fd)
{
    struct stat about;
    if (fstat(fd, &about)) return errno;
    return S_ISREG(about.st_mode) ? 0 : S_ISDIR(about.st_mode) ? EISDIR : ENXIO;
}

FILE *disk_open(const char *path, const char *mode)
{
    const int way = mode[1] == '+' ? O_RDWR : *mode == 'r' ? O_RDONLY : O_WRONLY;
    const int more = *mode == 'w' ? O_CREAT | O_TRUNC : 0;
    const int fd = open(path, way | more | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, 0666);
    if (fd < 0) return NULL;
    int failure = check_regular(fd);
    FILE *file = failure ? NULL : fdopen(fd, mode);
    if (file) return file;
    if (!failure) failure = errno;
    close(fd);
    errno = failure;
    return NULL;
}

MnsStatus disk_status(int code)
{
    return code == ENOSPC || code == EDQUOT || code == EFBIG ? MNS_E_NO_SPACE : MNS_E_IO;
}
