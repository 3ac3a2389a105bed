/* SPDX-License-Identifier: BSD-3-Clause */
/* What can be counted of a run from any thread without waiting for any other. */
#ifndef RUN_WATCH_H
#define RUN_WATCH_H

#include "run/run.h"

/* Files of one kind, since the daemon began. */
typedef struct RunFiles {
    uint64_t written, failed; /* each attempt that failed counts */
    double seconds;           /* wall-clock time of the writer in them [s] */
    double latest;            /* when the latest was written, since 1970 [s]; 0: none */
} RunFiles;

/* Journals, since the daemon began. */
typedef struct RunJournal {
    uint64_t records, failures; /* added; times that they could not be had on the disk */
    double seconds;             /* wall-clock time in which the solver waited for the disk [s] */
} RunJournal;

typedef struct RunCounts {
    uint64_t beats;                             /* as run_heartbeat() */
    size_t orders;                              /* waiting to be served between two steps */
    size_t notes;                               /* samples and progress that the desk has not fetched */
    uint64_t progress_dropped, samples_dropped; /* of those, given up */
    unsigned files, rows;                       /* waiting for the writer: files with particles, and all else */
    RunFiles snapshots, checkpoints;
    RunJournal journal;
} RunCounts;

/* Each number is right, but they may be of moments a little apart. */
void run_counts(Run *run, RunCounts *ret);

#endif
