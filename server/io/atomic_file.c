/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that are whole or absent, however the process, the disk or the power ends. */
#include "io/atomic_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

MnsStatus file_fail(MnsError *error, int number, const char *verb, const char *path)
{
    char reason[128];
    const char *text = strerror_r(number, reason, sizeof reason);
    if (number == ENOSPC || number == EDQUOT || number == EFBIG)
        return mns_fail(error, MNS_E_NO_SPACE, "cannot %s '%s': %s; %s", verb, path, text, mns_refusal_hint(number));
    if (number == ENOMEM)
        return mns_fail(error, MNS_E_MEMORY, "cannot %s '%s': %s; %s", verb, path, text, mns_refusal_hint(number));
    return mns_fail(error, MNS_E_IO, "cannot %s '%s': %s; %s", verb, path, text, mns_refusal_hint(number));
}

int file_open(const char *path, int flags, unsigned mode)
{
    struct stat about;
    const int fd = open(path, flags | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, mode);
    if (fd < 0) return -1;
    const int failure = fstat(fd, &about)        ? errno
                        : S_ISREG(about.st_mode) ? 0
                        : S_ISDIR(about.st_mode) ? EISDIR
                                                 : ENXIO;
    if (!failure) return fd;
    close(fd);
    errno = failure;
    return -1;
}

bool file_is_at(int fd, const char *path)
{
    struct stat own, there;
    return !fstat(fd, &own) && !stat(path, &there) && own.st_dev == there.st_dev && own.st_ino == there.st_ino;
}

int file_read_at(int fd, void *data, size_t size, size_t offset, size_t *ret_got)
{
    size_t got = 0;
    while (got < size) {
        const ssize_t part = pread(fd, (char *)data + got, size - got, (off_t)(offset + got));
        if (part < 0 && errno == EINTR) continue;
        if (part < 0) return errno;
        if (part == 0) break;
        got += (size_t)part;
    }
    *ret_got = got;
    return 0;
}

int file_write_at(int fd, const void *data, size_t size, size_t offset)
{
    for (size_t done = 0; done < size;) {
        const ssize_t part = pwrite(fd, (const char *)data + done, size - done, (off_t)(offset + done));
        if (part < 0 && errno == EINTR) continue;
        if (part < 0) return errno;
        done += (size_t)part;
    }
    return 0;
}

MnsStatus atomic_begin(AtomicFile *file, const char *path, MnsError *error)
{
    const int length = snprintf(file->temporary, sizeof file->temporary, "%s" ATOMIC_END, path);
    if (length < 0 || (size_t)length >= sizeof file->temporary)
        return mns_fail(error, MNS_E_INVALID, "the path '%.60s...' is longer than the %zu bytes allowed", path,
                        sizeof file->temporary - sizeof ATOMIC_END);
    file->path = path;
    file->fd = open(file->temporary, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY, 0666);
    return file->fd < 0 ? file_fail(error, errno, "create", file->temporary) : MNS_OK;
}

void atomic_cancel(AtomicFile *file)
{
    if (file->fd >= 0) close(file->fd);
    file->fd = -1;
    unlink(file->temporary);
}

/* File systems that cannot sync a directory say EINVAL; there is nothing more to do for them. */
int file_sync_directory(const char *path)
{
    char dir[IO_PATH_MAX];
    const char *slash = strrchr(path, '/');
    const int length = !slash ? 1 : slash == path ? 1 : (int)(slash - path);
    snprintf(dir, sizeof dir, "%.*s", length, slash ? path : ".");
    const int fd = open(dir, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return errno;
    const int failure = fsync(fd) != 0 && errno != EINVAL ? errno : 0;
    close(fd);
    return failure;
}

static int sync_and_close(AtomicFile *file)
{
    const int fd = file->fd;
    if (fd < 0) return 0; /* atomic_fill() has done it */
    int failure = fsync(fd) != 0 ? errno : 0;
    file->fd = -1;
    if (close(fd) != 0 && !failure) failure = errno;
    return failure;
}

MnsStatus atomic_commit(AtomicFile *file, MnsError *error)
{
    int failure = sync_and_close(file);
    if (!failure && rename(file->temporary, file->path) != 0) failure = errno;
    if (failure) {
        atomic_cancel(file);
        return file_fail(error, failure, "write", file->path);
    }
    failure = file_sync_directory(file->path);
    return failure ? file_fail(error, failure, "sync the directory of", file->path) : MNS_OK;
}

MnsStatus atomic_fill(AtomicFile *file, const char *path, const void *data, size_t size, MnsError *error)
{
    const MnsStatus status = atomic_begin(file, path, error);
    if (status) return status;
    int failure = file_write_at(file->fd, data, size, 0);
    if (!failure) failure = sync_and_close(file);
    if (!failure) return MNS_OK;
    atomic_cancel(file);
    return file_fail(error, failure, "write", path);
}

MnsStatus atomic_write(const char *path, const void *data, size_t size, MnsError *error)
{
    AtomicFile file;
    const MnsStatus status = atomic_fill(&file, path, data, size, error);
    return status ? status : atomic_commit(&file, error);
}

/* @return 0 or an errno. */
static int copy_bytes(int from, int to)
{
    char block[1 << 16];
    size_t got = sizeof block;
    int failure = 0;
    for (size_t done = 0; !failure && got == sizeof block; done += got) {
        failure = file_read_at(from, block, sizeof block, done, &got);
        if (!failure) failure = file_write_at(to, block, got, done);
    }
    return failure;
}

MnsStatus atomic_copy(const char *from, const char *to, MnsError *error)
{
    AtomicFile file;
    const int fd = file_open(from, O_RDONLY, 0);
    if (fd < 0) return file_fail(error, errno, "read", from);
    const MnsStatus status = atomic_begin(&file, to, error);
    const int failure = status ? 0 : copy_bytes(fd, file.fd);
    close(fd);
    if (status) return status;
    if (!failure) return atomic_commit(&file, error);
    atomic_cancel(&file);
    return file_fail(error, failure, "copy", from);
}
