/* SPDX-License-Identifier: BSD-3-Clause */
/* The snapshot files of a run directory, one after the other. */
#include "run/snapshots.h"

#include "io/atomic_file.h"
#include "io/directory.h"
#include "run/rundir.h"
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool is_snapshot(const char *name, uint64_t *ret_step)
{
    return !strncmp(name, SNAPSHOT_BEGIN, strlen(SNAPSHOT_BEGIN)) && name_step(name, ret_step);
}

/* False if there is no such file. */
static bool look(const char *directory, const char *name, struct stat *ret, int *ret_fd)
{
    char path[IO_PATH_MAX];
    if (directory_path(path, directory, name, NULL)) return false;
    *ret_fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (*ret_fd < 0) return false;
    if (!fstat(*ret_fd, ret) && S_ISREG(ret->st_mode)) return true;
    close(*ret_fd);
    return false;
}

static uint64_t written(const struct stat *info)
{
    return (uint64_t)info->st_mtim.tv_sec * 1000000000u + (uint64_t)info->st_mtim.tv_nsec;
}

static SnapshotPlace place_of(const char *name, const struct stat *info, uint64_t offset)
{
    SnapshotPlace place = {.written = written(info), .offset = offset};
    snprintf(place.name, sizeof place.name, "%s", name);
    return place;
}

/* The first file after a step that was written after a moment, and the last one before it. */
static void search(const char *directory, char *const *names, size_t n, bool any, uint64_t after, uint64_t since,
                   SnapshotNext *ret)
{
    uint64_t step, best = UINT64_MAX, last = 0;
    struct stat info;
    int fd;
    for (size_t k = 0; k < n; k++) {
        if (!is_snapshot(names[k], &step) || (!any && step <= after) || !look(directory, names[k], &info, &fd))
            continue;
        const bool fits = written(&info) > since;
        if (fits && step < best) {
            if (ret->there) close(ret->fd);
            best = step;
            ret->there = true;
            ret->fd = fd;
            ret->size = (uint64_t)info.st_size;
            ret->place = place_of(names[k], &info, 0);
            continue;
        }
        close(fd);
        if (fits || step < last || ret->there) continue;
        last = step;
        ret->place = place_of(names[k], &info, (uint64_t)info.st_size);
    }
}

/* Is the file of the place what it was? Then go on in it, or behind it. */
static bool go_on(const char *directory, const SnapshotPlace *from, SnapshotNext *ret)
{
    struct stat info;
    int fd;
    if (!look(directory, from->name, &info, &fd)) return false;
    if (written(&info) != from->written) {
        close(fd);
        return false;
    }
    if (from->offset < (uint64_t)info.st_size) {
        *ret = (SnapshotNext){.there = true, .fd = fd, .size = (uint64_t)info.st_size, .place = *from};
        return true;
    }
    close(fd);
    return true;
}

MnsStatus snapshots_next(const char *directory, const SnapshotPlace *from, SnapshotNext *ret, MnsError *error)
{
    char **names;
    size_t n;
    uint64_t after = 0;
    const bool begins = !from->name[0];
    *ret = (SnapshotNext){.fd = -1, .place = *from};
    if (!begins && !is_snapshot(from->name, &after)) ret->left = true;
    else if (!begins) ret->left = !go_on(directory, from, ret);
    if (ret->there) return MNS_OK;
    const MnsStatus status = rundir_list(directory, &names, &n, error);
    if (status) return status;
    if (ret->left) ret->place = (SnapshotPlace){.offset = 0};
    search(directory, names, n, begins || ret->left, after, ret->left ? from->written : 0, ret);
    for (size_t k = 0; k < n; k++) free(names[k]);
    free(names);
    if (ret->left && ret->there) close(ret->fd); /* it is told first */
    if (ret->left) ret->there = false;
    return MNS_OK;
}
