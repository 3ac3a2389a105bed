/* SPDX-License-Identifier: BSD-3-Clause */
/* The front end, which is part of the program: there is no directory to find, and nothing else that could be served. */
#ifndef DASHBOARD_FILES_H
#define DASHBOARD_FILES_H

#include <stddef.h>

typedef struct File {
    const char *path, *type;
    const unsigned char *bytes;
    size_t size;
} File;

/* The file of that path, as in "/app.js"; NULL if there is none. */
const File *file_find(const char *path);

#endif
