/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that are whole under their name, or not there. */
#ifndef CLI_WHOLE_FILE_H
#define CLI_WHOLE_FILE_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <stdio.h>

/* Write PATH.part, then rename it. `write` returns whether all could be written; errno says why not.
 *  what  as in "the picture", for the complaint
 * MNS_E_NO_SPACE, MNS_E_IO. */
MnsStatus whole_file_write(const char *path, const char *what, bool (*write)(FILE *file, const void *arg),
                           const void *arg, MnsError *error);

#endif
