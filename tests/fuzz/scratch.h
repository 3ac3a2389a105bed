/* SPDX-License-Identifier: BSD-3-Clause */
/* A file for what is read by its name: in memory where there is such a place, and gone in the end. */
#ifndef TESTS_FUZZ_SCRATCH_H
#define TESTS_FUZZ_SCRATCH_H

#include "tests/fuzz/fuzz.h"
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static char scratch_home[64], scratch_path[128];

static void scratch_end(void)
{
    unlink(scratch_path);
    rmdir(scratch_home);
}

static inline void scratch_begin(const char *name)
{
    snprintf(scratch_home, sizeof scratch_home, "%s/mns-fuzz-XXXXXX", access("/dev/shm", W_OK) ? "/tmp" : "/dev/shm");
    PROMISE(mkdtemp(scratch_home));
    snprintf(scratch_path, sizeof scratch_path, "%s/%s", scratch_home, name);
    atexit(scratch_end);
}

static inline void scratch_put(const void *data, size_t size)
{
    const int fd = open(scratch_path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    PROMISE(fd >= 0 && write(fd, data, size) == (ssize_t)size);
    close(fd);
}

#endif
