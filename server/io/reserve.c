/* SPDX-License-Identifier: BSD-3-Clause */
/* Room on a disk that nobody else can take. */
#include "io/reserve.h"
#include "io/atomic_file.h"
#include "io/directory.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static MnsStatus refuse(MnsError *error, int number, uint64_t size, const char *dir)
{
    char what[96];
    snprintf(what, sizeof what, "keep %" PRIu64 " kB free, for all that a full disk must not cost, in",
             (size + 999) / 1000);
    return file_fail(error, number, what, dir);
}

MnsStatus reserve_hold(Reserve *reserve, const char *dir, uint64_t size, MnsError *error)
{
    char path[IO_PATH_MAX];
    if (reserve->held && reserve->size >= size) return MNS_OK;
    if (!reserve->held) {
        const MnsStatus status = directory_path(path, dir, ".reserve-XXXXXX", error);
        if (status) return status;
        const int fd = mkostemp(path, O_CLOEXEC);
        if (fd < 0) return refuse(error, errno, size, dir);
        unlink(path);
        *reserve = (Reserve){.held = true, .fd = fd};
    }
    const int failure = posix_fallocate(reserve->fd, 0, (off_t)size);
    if (!failure) {
        reserve->size = size;
        return MNS_OK;
    }
    if (ftruncate(reserve->fd, (off_t)reserve->size)) reserve->size = 0;
    if (!reserve->size) reserve_release(reserve);
    return failure == ENOSPC || failure == EDQUOT ? refuse(error, failure, size, dir) : MNS_OK;
}

void reserve_release(Reserve *reserve)
{
    if (reserve->held) close(reserve->fd);
    *reserve = (Reserve){.held = false};
}
