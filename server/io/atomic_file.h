/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that are whole or absent: written as PATH.tmp, synced, renamed, directory synced. */
#ifndef IO_ATOMIC_FILE_H
#define IO_ATOMIC_FILE_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <stddef.h>

enum { IO_PATH_MAX = 4096 };

#define ATOMIC_END ".tmp" /* of the name of a file that is not whole yet */

typedef struct AtomicFile {
    int fd;           /* open for reading and writing */
    const char *path; /* borrowed: the final name */
    char temporary[IO_PATH_MAX];
} AtomicFile;

/* Open PATH.tmp, empty. path is borrowed until commit or cancel, one of which must follow a success.
 * MNS_E_INVALID if the path is too long; otherwise as file_fail(). */
MnsStatus atomic_begin(AtomicFile *file, const char *path, MnsError *error);

/* Write size bytes to PATH.tmp and have them on the disk, so that a full one is known before anything depends on it. Then
 * atomic_commit() or atomic_cancel() as after atomic_begin(). */
MnsStatus atomic_fill(AtomicFile *file, const char *path, const void *data, size_t size, MnsError *error);

/* Give the file its name. On failure the temporary is gone and an older file of that name is untouched, unless only the
 * last step failed, syncing the directory: then the new file is in place and whole. */
MnsStatus atomic_commit(AtomicFile *file, MnsError *error);

/* Forget the file: the temporary is removed. */
void atomic_cancel(AtomicFile *file);

/* A whole file from memory. */
MnsStatus atomic_write(const char *path, const void *data, size_t size, MnsError *error);

/* A whole copy of a file. */
MnsStatus atomic_copy(const char *from, const char *to, MnsError *error);

/* Open a regular file. What else has its name holds nothing up, as a pipe without another end would, and is refused. @return -1: errno says why, ENXIO or
 * EISDIR that it is no file. */
int file_open(const char *path, int flags, unsigned mode);

/* Is the open file the one that has this name? */
bool file_is_at(int fd, const char *path);

/* Read or write `size` bytes at `offset`, whatever the system does in one go. @return 0 or an errno; a read sets
 * *ret_got to what there was before the end of the file. */
int file_read_at(int fd, void *data, size_t size, size_t offset, size_t *ret_got);
int file_write_at(int fd, const void *data, size_t size, size_t offset);

/* A new name lasts through a power failure only once its directory is on the disk: have it there. @return 0 or an errno. */
int file_sync_directory(const char *path);

/* Turn an errno into a status and a sentence: MNS_E_NO_SPACE if disk, quota or size limit is used up,
 * MNS_E_MEMORY, MNS_E_IO else. @param verb  as in "write" */
MnsStatus file_fail(MnsError *error, int number, const char *verb, const char *path);

#endif
