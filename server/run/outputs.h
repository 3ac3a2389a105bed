/* SPDX-License-Identifier: BSD-3-Clause */
/* What a run leaves behind in its directory: probe series, snapshots, checkpoints. The runner copies what is due after a
 * step; the writer's thread writes it. Whatever is due waits for a slow disk, so that nothing is lost. */
#ifndef RUN_OUTPUTS_H
#define RUN_OUTPUTS_H

#include "io/checkpoint.h"
#include "io/journal.h"
#include "io/reserve.h"
#include "io/series.h"
#include "run/document.h"
#include "run/listing.h"
#include "run/outbox.h"
#include "run/rundir.h"
#include "run/writer.h"
#include <pthread.h>
#include <stdatomic.h>

/* Of the boundaries at which it was last looked whether each is due [s]; -INFINITY: never yet. Each has one of its own, as
 * what could not be taken for lack of memory is due again at the next boundary, and the others are not. */
typedef struct OutputTimes {
    double probes, snapshot, checkpoint;
} OutputTimes;

/* Files of one kind since the program began; the writer's thread counts, any may look. */
typedef struct OutputTally {
    _Atomic uint64_t written, failed;
    _Atomic double seconds, latest; /* spent on them; when the latest was written, since 1970, or 0 [s] */
} OutputTally;

/* The latest sample of the probes of this run. */
typedef struct Sample {
    bool taken;
    uint64_t step;
    double t; /* [s] */
    double values[MNS_MAX_PROBES];
} Sample;

/* What they take of the runner's time. */
enum { OUTPUTS_PROBES, OUTPUTS_CAPTURES, OUTPUTS_TIMERS };

typedef struct Outputs {
    char directory[RUNDIR_PATH];
    Writer *writer;
    Outbox *outbox;
    Series *series;              /* the writer's thread only, and outputs_rows(); NULL without probes */
    pthread_mutex_t series_lock; /* while it is looked at there, changed or replaced, with the document */
    Document *document;          /* that the series was opened with, and borrows from; NULL when closed */
    char aside[RUNDIR_PATH];     /* where outputs_open() moved files to; empty if there were none */
    Reserve reserve;             /* for what a full disk must not cost; the writer's thread only        */
    _Atomic bool rescued;        /* the reserve is given up until the run moves again                   */
    size_t state_size;           /* of a capture of the state [bytes]                              */
    _Atomic(MnsCapture *) spare; /* the last one that was written, for its room; NULL: none */
    bool series_lost;            /* outputs_open() found no samples from before, and should have  */
    bool series_damaged;         /* they are in probes.hdf.damaged                                */
    OutputTimes before;
    double wall_checkpoint;            /* clock_now() of the last one; of the beginning if there is none   */
    double wall_flush;                 /* the same for the series                                          */
    bool rows_wait;                    /* there are some since then, or it has changed otherwise */
    uint64_t at_checkpoint;            /* step of the last one; UINT64_MAX: none                           */
    uint64_t at_snapshot;              /* step of the last snapshot; UINT64_MAX: none                      */
    uint64_t snapshot_fields;          /* and what it has, as bits                                         */
    Document *checkpoint_of;           /* the case in it; NULL when closed                                 */
    double capture_seconds;            /* that copying the state for it took                               */
    _Atomic double checkpoint_seconds; /* that writing it took; the writer's to set             */

    Sample sample;
    MnsTimer timers[OUTPUTS_TIMERS]; /* since outputs_open() */
    OutputTally snapshots, checkpoints;
    Listing listing; /* of the snapshots */

    /* How long writing the series took the last time; the writer's to set. A crash may cost the samples since then, but
     * none before a checkpoint: a restart writes the later ones again. */
    _Atomic double flush_seconds;
    _Atomic unsigned followers; /* who wait for new rows of it; any thread counts */

    const Journal *journal; /* of the run, borrowed; NULL: it has none */
    int lock;               /* of its directory, borrowed; -1: it has none */

    /* Tell who ordered an output that it is written or failed; on the writer's thread. */
    void (*answer)(void *arg, Order *order, MnsStatus status, const MnsError *error);
    FileNote *note; /* snapshots that cannot be read, while outputs_open() waits; may be NULL */
    void *arg;
} Outputs;

/* Where a run goes over to. */
typedef struct OutputsPlace {
    const char *directory; /* which exists               */
    int lock;              /* of it; -1: it has none     */
    const char *
        aside; /* in it, where its journal was moved to, and where files are to follow; NULL or empty: it is where it was */
    bool
        goes_on; /* with the series; else that begins there, and all files are moved aside, not those of later steps alone */
    bool
        again; /* what was written before comes once more, to the bit: after a crash. Else rows of the series that are left out were of
                              another time line */
} OutputsPlace;

/* Go over to a directory with the state of sim. On failure outputs and all files are as they were; on success the present ones are closed.
 * MNS_E_NO_SPACE also where there is no room for what a disk that fills up later must not cost.
 *  ret_lost  as outputs_close() says of them */
MnsStatus outputs_open(Outputs *outputs, const OutputsPlace *place, Document *document, const MnsSim *sim,
                       MnsError *ret_lost, MnsError *error);

/* The longest that a file of this process may be (`ulimit -f`) [bytes]; SIZE_MAX: any. */
size_t outputs_longest(void);

/* May a checkpoint be that long? A run that has none would lose its state at the end. MNS_E_NO_SPACE. */
MnsStatus outputs_fit(const MnsSim *sim, MnsError *error);

/* Write what is left and close the series. MNS_OK; or the failure, and what could not be written is given up. */
MnsStatus outputs_close(Outputs *outputs, MnsError *error);

/* Take what is due at this boundary. MNS_OK; MNS_E_MEMORY: what could not be taken is due when this is called again; or the
 * failure of an output by the writer: then what is due has been taken all the same and is kept behind the one that failed. */
MnsStatus outputs_take(Outputs *outputs, const MnsSim *sim, Document *document, MnsError *error);

/* Is there anything that has not been looked at for the boundary at t, as before the first step? */
bool outputs_behind(const Outputs *outputs, double t);

/* Take a checkpoint now, or a snapshot with these fields besides those of the case. MNS_OK or MNS_E_MEMORY.
 *  order  answered when it is written, or not: then it is taken over unless MNS_E_MEMORY is returned; NULL if nobody asked */
MnsStatus outputs_checkpoint(Outputs *outputs, const MnsSim *sim, Document *document, Order *order, MnsError *error);
MnsStatus outputs_snapshot(Outputs *outputs, const MnsSim *sim, Document *document, uint64_t fields, Order *order,
                           MnsError *error);

/* There is a snapshot of this step with these fields besides those of the case. */
void outputs_know_snapshot(Outputs *outputs, uint64_t step, uint64_t fields);

/* Rows of the series that are on the disk. */
typedef struct SeriesRows {
    uint64_t line;         /* the time line                                                              */
    bool left;             /* rows from `first` on were of a line that was left: nothing else is filled in */
    size_t first, n;       /* rows */
    uint64_t *step;        /* [n], the caller's with the others */
    double *time, *values; /* [n], [n][n_columns] */
} SeriesRows;

/* At most so many from row `first` of a line on, 0 for whatever line there is. n is 0 if there are none yet. Any thread. MNS_E_STATE: there is
 * no series, or it is of another document, whose columns may be others; MNS_E_MEMORY. */
MnsStatus outputs_rows(Outputs *outputs, const Document *document, uint64_t line, uint64_t first, size_t most,
                       size_t n_columns, const int *columns, SeriesRows *ret, MnsError *error);

/* What is on the disk, or was sent, of rows after these is of another time line. MNS_E_MEMORY. */
MnsStatus outputs_begin_line(Outputs *outputs, MnsError *error);

/* Have the series written soon. */
MnsStatus outputs_flush(Outputs *outputs, MnsError *error);

/* All that was taken is on the disk before this returns, unless an output has failed. */
MnsStatus outputs_settle(Outputs *outputs, MnsError *error);

/* The series and a checkpoint of this very step, written before this returns. */
MnsStatus outputs_finish(Outputs *outputs, const MnsSim *sim, Document *document, MnsError *error);

/* After an output that failed: write what can be written, and then a checkpoint of this very step, before this returns. The reserve
 * is given up for it, until the series is written the next time. MNS_OK: all of it is there. Else there is no checkpoint: a restart from one would
 * not write again what is missing before it. ret_path: [4096], where it is. */
MnsStatus outputs_rescue(Outputs *outputs, const MnsSim *sim, Document *document, char *ret_path, MnsError *error);

/* checkpoint_read() and checkpoint_newest() on the writer's thread, with what they call. */
MnsStatus outputs_read(Writer *writer, const char *path, Checkpoint *ret, MnsError *error);
MnsStatus outputs_read_newest(Writer *writer, const char *dir, CheckpointTakes *takes,
                              void (*note)(void *arg, const char *text), void *arg, Checkpoint *ret, MnsError *error);

#endif
