/* SPDX-License-Identifier: BSD-3-Clause */
/* The directory that holds everything of one run. */
#include "run/rundir.h"

#include "io/atomic_file.h"
#include "io/directory.h"
#include "io/names.h"
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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
        if (!made && errno != EEXIST) return file_fail(error, errno, "make the directory", path);
        *slash = '/';
    }
    if (access(path, W_OK | X_OK)) return file_fail(error, errno, "write to", path);
    *ret_made = made;
    return MNS_OK;
}

void rundir_unmake(const char *dir)
{
    rmdir(dir);
}

MnsStatus rundir_write(const char *dir, const char *name, const char *text, MnsError *error)
{
    char path[4096];
    const MnsStatus status = directory_path(path, dir, name, error);
    return status ? status : atomic_write(path, text, strlen(text), error);
}

static MnsStatus move_aside(const char *dir, const char *name, MnsError *error)
{
    char from[4096 + 260], to[4096 + 260], aside[4096];
    snprintf(aside, sizeof aside, "%s/abandoned", dir);
    if (mkdir(aside, 0777) && errno != EEXIST) return file_fail(error, errno, "make the directory", aside);
    snprintf(from, sizeof from, "%s/%s", dir, name);
    snprintf(to, sizeof to, "%s/%s", aside, name);
    return rename(from, to) ? file_fail(error, errno, "move aside", from) : MNS_OK;
}

MnsStatus rundir_abandon(const char *dir, bool all, uint64_t after, MnsError *error)
{
    DIR *stream = opendir(dir);
    if (!stream) return errno == ENOENT ? MNS_OK : file_fail(error, errno, "read", dir);
    MnsStatus status = MNS_OK;
    for (struct dirent *entry; !status && (entry = readdir(stream));) {
        uint64_t step;
        const bool numbered = name_step(entry->d_name, &step);
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
    return name_step(name, &step) || !strcmp(name, "probes.hdf") || !strcmp(name, "snapshots.hdf.series") ||
           !strcmp(name, "case.yaml");
}

MnsStatus rundir_list(const char *dir, char ***ret, size_t *ret_n, MnsError *error)
{
    struct dirent **entries;
    const int n = scandir(dir, &entries, is_output, alphasort);
    if (n < 0) return file_fail(error, errno, "read", dir);
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
