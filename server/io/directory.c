/* SPDX-License-Identifier: BSD-3-Clause */
/* The files of a run directory that belong together, the last written first. */
#include "io/directory.h"
#include "io/atomic_file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

typedef struct List {
    DirectoryEntry *entries; /* [room] */
    size_t n, room;
} List;

int directory_order(const DirectoryEntry *a, const DirectoryEntry *b)
{
    if (a->written.tv_sec != b->written.tv_sec) return a->written.tv_sec < b->written.tv_sec ? 1 : -1;
    if (a->written.tv_nsec != b->written.tv_nsec) return a->written.tv_nsec < b->written.tv_nsec ? 1 : -1;
    return strcmp(b->name, a->name);
}

static int by_age(const void *left, const void *right)
{
    return directory_order(left, right);
}

static bool fits(const char *name, const char *begin, const char *end)
{
    const size_t length = strlen(name), b = strlen(begin), e = strlen(end);
    return length >= b + e && memcmp(name, begin, b) == 0 && memcmp(name + length - e, end, e) == 0;
}

/* A file that vanishes while we look is none of ours. @return 0 or an errno. */
static int add(List *list, int dir, const char *name)
{
    struct stat about;
    if (fstatat(dir, name, &about, AT_SYMLINK_NOFOLLOW) != 0) return errno == ENOENT ? 0 : errno;
    if (!S_ISREG(about.st_mode)) return 0;
    if (list->n == list->room) {
        const size_t room = list->room ? 2 * list->room : 16;
        DirectoryEntry *entries = realloc(list->entries, room * sizeof *entries);
        if (!entries) return ENOMEM;
        list->entries = entries;
        list->room = room;
    }
    DirectoryEntry *entry = &list->entries[list->n++];
    snprintf(entry->name, sizeof entry->name, "%s", name);
    entry->written = about.st_mtim;
    entry->changed = about.st_ctim;
    return 0;
}

static int collect(List *list, DIR *stream, const char *begin, const char *end)
{
    for (;;) {
        errno = 0;
        const struct dirent *found = readdir(stream);
        if (!found) return errno;
        const int failure = fits(found->d_name, begin, end) ? add(list, dirfd(stream), found->d_name) : 0;
        if (failure) return failure;
    }
}

MnsStatus directory_list(const char *dir, const char *begin, const char *end, DirectoryEntry **ret_entries,
                         size_t *ret_n, MnsError *error)
{
    List list = {0};
    DIR *stream = opendir(dir);
    if (!stream) return file_fail(error, errno, "list", dir);
    const int failure = collect(&list, stream, begin, end);
    closedir(stream);
    if (failure) {
        free(list.entries);
        return file_fail(error, failure, "list", dir);
    }
    if (list.n) qsort(list.entries, list.n, sizeof *list.entries, by_age);
    *ret_entries = list.entries;
    *ret_n = list.n;
    return MNS_OK;
}

static const char *kind_of(mode_t mode)
{
    return S_ISDIR(mode) ? "a directory" : S_ISLNK(mode) ? "a link" : S_ISFIFO(mode) ? "a pipe" : "no file";
}

void directory_others(const char *dir, const char *begin, const char *end, void (*note)(void *arg, const char *text),
                      void *arg)
{
    struct stat about;
    char text[512];
    DIR *stream = opendir(dir);
    if (!stream) return;
    for (const struct dirent *found; (found = readdir(stream));) {
        if (!fits(found->d_name, begin, end)) continue;
        if (fstatat(dirfd(stream), found->d_name, &about, AT_SYMLINK_NOFOLLOW) || S_ISREG(about.st_mode)) continue;
        snprintf(text, sizeof text, "'%.200s/%.200s' is %s, and is passed over", dir, found->d_name,
                 kind_of(about.st_mode));
        note(arg, text);
    }
    closedir(stream);
}

MnsStatus directory_path(char ret[static 4096], const char *dir, const char *name, MnsError *error)
{
    const int length = snprintf(ret, 4096, "%s/%s", dir, name);
    if (length >= 0 && length < 4096) return MNS_OK;
    return mns_fail(error, MNS_E_INVALID, "the path '%.60s...' is too long", dir);
}
