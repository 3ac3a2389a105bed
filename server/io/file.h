/* SPDX-License-Identifier: BSD-3-Clause */
/* What every output file says about the run it belongs to. */
#ifndef IO_FILE_H
#define IO_FILE_H

#include <meniscus/sim.h>

/* How far a journal had come: so many records, and the beginnings of the checksums of the first and the last of them. */
typedef struct JournalPlace {
    uint64_t records; /* 0: not known */
    uint64_t first, last;
} JournalPlace;

typedef struct FileMeta {
    const MnsCase *c;      /* borrowed */
    const char *case_name; /* "dambreak2d" */
    const char *case_text; /* the whole case as YAML */
    JournalPlace journal;  /* of the run, on the disk; of checkpoints */
} FileMeta;

/* What people should know of a file. */
typedef void FileNote(void *arg, const char *text);

#endif
