/* SPDX-License-Identifier: BSD-3-Clause */
/* What every output file says about the run it belongs to. */
#ifndef IO_FILE_H
#define IO_FILE_H

#include <meniscus/sim.h>

typedef struct FileMeta {
    const MnsCase *c;      /* borrowed */
    const char *case_name; /* "dambreak2d" */
    const char *case_text; /* the whole case as YAML */
} FileMeta;

/* What people should know of a file. */
typedef void FileNote(void *arg, const char *text);

#endif
