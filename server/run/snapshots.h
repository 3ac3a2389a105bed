/* SPDX-License-Identifier: BSD-3-Clause */
/* The snapshot files of a run directory, one after the other, for whoever takes them all. A file is known by its name and by when it was written, so
 * that one that a restore undid is not taken for the one that came in its place. */
#ifndef RUN_SNAPSHOTS_H
#define RUN_SNAPSHOTS_H

#include "io/names.h"
#include <meniscus/status.h>
#include <stdbool.h>
#include <time.h>

typedef struct SnapshotPlace {
    char name[NUMBERED_NAME]; /* of the file; empty: before the first                  */
    uint64_t written;         /* when it was [ns since 1970]                           */
    uint64_t offset;          /* bytes of it that were taken; its size or more: it is done */
} SnapshotPlace;

typedef struct SnapshotEntry {
    char name[NUMBERED_NAME];
    uint64_t step;
} SnapshotEntry;

typedef struct SnapshotNext {
    bool left;           /* the file of the place is undone: go on from `place`          */
    bool there;          /* there is a file, open                                        */
    int fd;              /* the caller's to close                                        */
    uint64_t size;       /* of the whole file                                            */
    SnapshotPlace place; /* where to go on: in this file, from its offset                */
} SnapshotNext;

/* The files of a directory in the order of their steps, as long as it stays as it is: so that who takes them all does not read it for each. Begins as
 * zeros. */
typedef struct SnapshotIndex {
    char *directory;
    struct timespec changed; /* the directory, before it was read */
    bool settled;            /* long enough before, so that a change since would show */
    SnapshotEntry *entries;
    size_t n;
} SnapshotIndex;

void snapshots_done(SnapshotIndex *index);

/* What comes at this place, if there is anything yet. MNS_E_IO; MNS_E_MEMORY. */
MnsStatus snapshots_next(SnapshotIndex *index, const char *directory, const SnapshotPlace *from, SnapshotNext *ret,
                         MnsError *error);

#endif
