/* SPDX-License-Identifier: BSD-3-Clause */
/* The files of a run directory that belong together. */
#ifndef IO_DIRECTORY_H
#define IO_DIRECTORY_H

#include <meniscus/status.h>
#include <stddef.h>
#include <time.h>

typedef struct DirectoryEntry {
    char name[256];
    struct timespec written, changed; /* its contents; its contents, its name or anything else of it */
} DirectoryEntry;

/* List the regular files of dir whose names begin and end so, the last written first, equally old ones by falling name.
 * @param ret_entries  [*ret_n], to be freed.  MNS_E_IO, MNS_E_MEMORY. */
MnsStatus directory_list(const char *dir, const char *begin, const char *end, DirectoryEntry **ret_entries,
                         size_t *ret_n, MnsError *error);

/* Tell of all else of such a name: directories, links, pipes. */
void directory_others(const char *dir, const char *begin, const char *end, void (*note)(void *arg, const char *text),
                      void *arg);

/* Their order for qsort(): negative if a comes first. */
int directory_order(const DirectoryEntry *a, const DirectoryEntry *b);

/* "DIR/NAME". MNS_E_INVALID if it is too long for ret. */
MnsStatus directory_path(char ret[static 4096], const char *dir, const char *name, MnsError *error);

#endif
