/* SPDX-License-Identifier: BSD-3-Clause */
/* What runs left behind in their directory: counted, and deleted. */
#include "run/abandoned.h"

#include "io/atomic_file.h"
#include "io/directory.h"
#include "run/rundir.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* "abandoned" or "abandoned.N" */
static bool is_abandoned(const char *name)
{
    static const char stem[] = "abandoned";
    const size_t n = sizeof stem - 1;
    if (strncmp(name, stem, n) != 0) return false;
    return !name[n] || (name[n] == '.' && name[n + 1] && !name[n + 1 + strspn(name + n + 1, "0123456789")]);
}

static uint64_t bytes_in(int parent, const char *name)
{
    uint64_t bytes = 0;
    struct stat info;
    const int fd = openat(parent, name, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
    DIR *stream = fd < 0 ? NULL : fdopendir(fd);
    if (!stream) {
        if (fd >= 0) close(fd);
        return 0;
    }
    for (struct dirent *entry; (entry = readdir(stream));)
        if (!fstatat(fd, entry->d_name, &info, AT_SYMLINK_NOFOLLOW) && S_ISREG(info.st_mode))
            bytes += (uint64_t)info.st_size;
    closedir(stream);
    return bytes;
}

void abandoned_each(const char *dir, void (*visit)(void *arg, const char *name), void *arg)
{
    DIR *stream = opendir(dir);
    if (!stream) return;
    for (struct dirent *entry; (entry = readdir(stream));)
        if (is_abandoned(entry->d_name)) visit(arg, entry->d_name);
    closedir(stream);
}

typedef struct Count {
    int parent;
    Abandoned all;
} Count;

static void count(void *arg, const char *name)
{
    Count *of = arg;
    of->all.n++;
    of->all.bytes += bytes_in(of->parent, name);
}

Abandoned abandoned_count(const char *dir)
{
    Count of = {.parent = open(dir, O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
    if (of.parent < 0) return of.all;
    abandoned_each(dir, count, &of);
    close(of.parent);
    return of.all;
}

MnsStatus abandoned_delete(const char *aside, MnsError *error)
{
    char **names, path[4096];
    size_t n;
    MnsStatus status = rundir_list(aside, &names, &n, error);
    if (status) return status;
    for (size_t k = 0; k < n; k++) {
        if (!status) status = directory_path(path, aside, names[k], error);
        if (!status && unlink(path) && errno != ENOENT) status = file_fail(error, errno, "delete", path);
        free(names[k]);
    }
    free(names);
    if (!status && rmdir(aside) && errno != ENOENT && errno != ENOTEMPTY && errno != EEXIST)
        status = file_fail(error, errno, "delete", aside);
    return status;
}
