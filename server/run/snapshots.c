/* SPDX-License-Identifier: BSD-3-Clause */
/* The snapshot files of a run directory, one after the other. */
#include "run/snapshots.h"

#include "io/atomic_file.h"
#include "io/directory.h"
#include "run/rundir.h"
#include <errno.h>
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
    *ret_fd = file_open(path, O_RDONLY | O_NOFOLLOW, 0);
    if (*ret_fd < 0) return false;
    if (!fstat(*ret_fd, ret)) return true;
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

/* --- the index ---------------------------------------------------------------------------------------------------------- */

static const double SETTLED_AFTER = 0.1; /* [s] more than the clock of file systems is coarse */

void snapshots_done(SnapshotIndex *index)
{
    free(index->directory);
    free(index->entries);
    *index = (SnapshotIndex){.n = 0};
}

static int by_step(const void *a, const void *b)
{
    const uint64_t first = ((const SnapshotEntry *)a)->step, second = ((const SnapshotEntry *)b)->step;
    return (first > second) - (first < second);
}

static MnsStatus read_directory(SnapshotIndex *index, const char *directory, MnsError *error)
{
    char **names;
    size_t n;
    const MnsStatus status = rundir_list(directory, &names, &n, error);
    if (status) return status;
    index->directory = strdup(directory);
    index->entries = calloc(n + 1, sizeof *index->entries);
    for (size_t k = 0; k < n; k++) {
        SnapshotEntry entry = {.step = 0};
        if (index->entries && names[k] && is_snapshot(names[k], &entry.step)) {
            snprintf(entry.name, sizeof entry.name, "%s", names[k]);
            index->entries[index->n++] = entry;
        }
        free(names[k]);
    }
    free(names);
    if (!index->directory || !index->entries) {
        snapshots_done(index);
        return mns_fail(error, MNS_E_MEMORY, "no memory for the list of snapshots");
    }
    qsort(index->entries, index->n, sizeof *index->entries, by_step);
    return MNS_OK;
}

static MnsStatus refresh(SnapshotIndex *index, const char *directory, MnsError *error)
{
    struct stat info;
    struct timespec now;
    if (stat(directory, &info)) return file_fail(error, errno, "read", directory);
    if (index->settled && !strcmp(index->directory, directory) && info.st_mtim.tv_sec == index->changed.tv_sec &&
        info.st_mtim.tv_nsec == index->changed.tv_nsec)
        return MNS_OK;
    snapshots_done(index);
    clock_gettime(CLOCK_REALTIME, &now);
    index->changed = info.st_mtim;
    const double age = (double)(now.tv_sec - info.st_mtim.tv_sec) + 1e-9 * (double)(now.tv_nsec - info.st_mtim.tv_nsec);
    const MnsStatus status = read_directory(index, directory, error);
    index->settled = !status && age > SETTLED_AFTER;
    return status;
}

/* Where files after a step begin. */
static size_t behind(const SnapshotIndex *index, uint64_t step)
{
    size_t low = 0, high = index->n;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (index->entries[middle].step <= step) low = middle + 1;
        else high = middle;
    }
    return low;
}

/* The first file from entry k on that was written after a moment, or the last one before it. */
static void search(const SnapshotIndex *index, size_t k, uint64_t since, SnapshotNext *ret)
{
    struct stat info;
    int fd;
    for (; k < index->n && !ret->there; k++) {
        if (!look(index->directory, index->entries[k].name, &info, &fd)) continue;
        ret->there = written(&info) > since;
        ret->fd = ret->there ? fd : -1;
        ret->size = (uint64_t)info.st_size;
        ret->place = place_of(index->entries[k].name, &info, ret->there ? 0 : ret->size);
        if (!ret->there) close(fd);
    }
}

/* --- places ------------------------------------------------------------------------------------------------------------- */

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

MnsStatus snapshots_next(SnapshotIndex *index, const char *directory, const SnapshotPlace *from, SnapshotNext *ret,
                         MnsError *error)
{
    uint64_t after = 0;
    const bool begins = !from->name[0];
    *ret = (SnapshotNext){.fd = -1, .place = *from};
    if (!begins && !is_snapshot(from->name, &after)) ret->left = true;
    else if (!begins) ret->left = !go_on(directory, from, ret);
    if (ret->there) return MNS_OK;
    const MnsStatus status = refresh(index, directory, error);
    if (status) return status;
    if (!ret->left) {
        search(index, begins ? 0 : behind(index, after), 0, ret);
        return MNS_OK;
    }
    SnapshotNext next = {.fd = -1};
    search(index, 0, from->written, &next);
    if (next.there) close(next.fd); /* it is told first */
    ret->place = next.place;
    return MNS_OK;
}
