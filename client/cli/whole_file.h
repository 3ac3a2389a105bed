/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that are whole under their name, or not there, however the process, the disk or the power ends. */
#ifndef CLI_WHOLE_FILE_H
#define CLI_WHOLE_FILE_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <stdio.h>

enum { WHOLE_FILE_PATH = 4096 };

/* Write PATH.part, have it on the disk, and rename it. `write` returns whether all could be written; errno says why not.
 *  what  as in "the picture", for the complaint
 * MNS_E_NO_SPACE, MNS_E_IO. */
MnsStatus whole_file_write(const char *path, const char *what, bool (*write)(FILE *file, const void *arg),
                           const void *arg, MnsError *error);

/* The same for a file that comes piece by piece: write one at its offset, those before having been written, and give it its name with the last. */
typedef struct FilePiece {
    const void *data;
    size_t size, offset;
    bool is_last;
} FilePiece;
MnsStatus whole_file_piece(const char *path, const char *what, const FilePiece *piece, MnsError *error);

#endif
