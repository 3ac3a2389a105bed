/* SPDX-License-Identifier: BSD-3-Clause */
/* The directory that holds everything of one run. */
#include "run/rundir.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A failure of the operating system, told apart by what people do about it. */
static MnsStatus refused(const char *what, const char *path, MnsError *error)
{
    const bool full = errno == ENOSPC || errno == EDQUOT;
    return mns_fail(error, full ? MNS_E_NO_SPACE : MNS_E_IO, "cannot %s %s: %s%s", what, path, strerror(errno),
                    full ? "; make room and resume" : "");
}

static bool exists(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0;
}

MnsStatus rundir_choose(const char *parent, const char *name, bool latest, char ret[static RUNDIR_PATH],
                        MnsError *error)
{
    if (strlen(parent) + strlen(name) + 16 > RUNDIR_PATH)
        return mns_fail(error, MNS_E_LIMIT, "the path of the run directory is too long: %.200s...", parent);
    char before[RUNDIR_PATH];
    snprintf(ret, RUNDIR_PATH, "%s/%s", parent, name);
    for (unsigned k = 2; exists(ret); k++) {
        memcpy(before, ret, sizeof before);
        snprintf(ret, RUNDIR_PATH, "%s/%s.%u", parent, name, k);
        if (latest && !exists(ret)) memcpy(ret, before, sizeof before);
        if (latest && !strcmp(ret, before)) break;
    }
    return MNS_OK;
}

MnsStatus rundir_make(const char *dir, bool *ret_made, MnsError *error)
{
    char path[4096];
    bool made = false;
    if (strlen(dir) >= RUNDIR_PATH)
        return mns_fail(error, MNS_E_LIMIT, "the path of the run directory is too long: %.200s...", dir);
    snprintf(path, sizeof path, "%s/", dir);
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        made = !mkdir(path, 0777);
        if (!made && errno != EEXIST) return refused("make the directory", path, error);
        *slash = '/';
    }
    if (access(path, W_OK | X_OK)) return refused("write to", path, error);
    *ret_made = made;
    return MNS_OK;
}

void rundir_unmake(const char *dir)
{
    rmdir(dir);
}

static MnsStatus write_all(int file, const char *path, const char *text, MnsError *error)
{
    for (size_t n = strlen(text); n;) {
        const ssize_t done = write(file, text, n);
        if (done < 0 && errno != EINTR) return refused("write", path, error);
        if (done < 0) continue;
        text += done;
        n -= (size_t)done;
    }
    return fsync(file) ? refused("write", path, error) : MNS_OK;
}

MnsStatus rundir_write(const char *dir, const char *name, const char *text, MnsError *error)
{
    char path[4096], part[4096 + 8];
    snprintf(path, sizeof path, "%s/%s", dir, name);
    snprintf(part, sizeof part, "%s.tmp", path);
    const int file = open(part, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0) return refused("write", part, error);
    MnsStatus status = write_all(file, part, text, error);
    if (close(file) && !status) status = refused("write", part, error);
    if (!status && rename(part, path)) status = refused("write", path, error);
    if (status) unlink(part);
    return status;
}

/* Step in the name of a checkpoint or snapshot file; false for any other name. */
static bool step_of(const char *name, uint64_t *ret)
{
    char tail[8] = "";
    unsigned long step;
    if (sscanf(name, "checkpoint-%10lu%7s", &step, tail) < 1 && sscanf(name, "snapshot-%10lu%7s", &step, tail) < 1)
        return false;
    *ret = step;
    return !strcmp(tail, ".hdf");
}

static MnsStatus move_aside(const char *dir, const char *name, MnsError *error)
{
    char from[4096 + 260], to[4096 + 260], aside[4096];
    snprintf(aside, sizeof aside, "%s/abandoned", dir);
    if (mkdir(aside, 0777) && errno != EEXIST) return refused("make the directory", aside, error);
    snprintf(from, sizeof from, "%s/%s", dir, name);
    snprintf(to, sizeof to, "%s/%s", aside, name);
    return rename(from, to) ? refused("move aside", from, error) : MNS_OK;
}

MnsStatus rundir_abandon(const char *dir, bool all, uint64_t after, MnsError *error)
{
    DIR *stream = opendir(dir);
    if (!stream) return errno == ENOENT ? MNS_OK : refused("read", dir, error);
    MnsStatus status = MNS_OK;
    for (struct dirent *entry; !status && (entry = readdir(stream));) {
        uint64_t step;
        const bool numbered = step_of(entry->d_name, &step);
        if ((numbered && (all || step > after)) || (all && !strcmp(entry->d_name, "probes.hdf")))
            status = move_aside(dir, entry->d_name, error);
    }
    closedir(stream);
    return status;
}

static int is_output(const struct dirent *entry)
{
    uint64_t step;
    const char *name = entry->d_name;
    return step_of(name, &step) || !strcmp(name, "probes.hdf") || !strcmp(name, "snapshots.hdf.series") ||
           !strcmp(name, "case.yaml");
}

MnsStatus rundir_list(const char *dir, char ***ret, size_t *ret_n, MnsError *error)
{
    struct dirent **entries;
    const int n = scandir(dir, &entries, is_output, alphasort);
    if (n < 0) return refused("read", dir, error);
    char **names = calloc((size_t)n + 1, sizeof *names);
    for (int k = 0; k < n; k++) {
        if (names) names[k] = strdup(entries[k]->d_name);
        free(entries[k]);
    }
    free(entries);
    if (!names) return mns_fail(error, MNS_E_MEMORY, "no memory for the list of files");
    *ret = names;
    *ret_n = (size_t)n;
    return MNS_OK;
}
