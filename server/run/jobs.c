/* SPDX-License-Identifier: BSD-3-Clause */
/* The jobs of the writer's thread. */
#include "run/jobs.h"

#include "base/clock.h"
#include "io/atomic_file.h"
#include "io/directory.h"
#include "io/names.h"
#include "io/snapshot.h"
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

/* What can be in memory only when the disk is full: the files that wait, the one that failed and the one of the boundary at which that
 * was seen, and the checkpoint of that boundary; each with what HDF5 adds. */
enum { FILES_AT_RISK = WRITER_HEAVY_MAX + 3, FILE_OVERHEAD = 1 << 15 };

static uint64_t at_risk(size_t state_size, size_t series_size)
{
    return FILES_AT_RISK * ((uint64_t)state_size + FILE_OVERHEAD) + series_size;
}

/* The series has grown, or the reserve has been used. */
static MnsStatus renew_reserve(Outputs *outputs, MnsError *error)
{
    if (outputs->rescued) return MNS_OK;
    const uint64_t size = at_risk(outputs->state_size, outputs->series ? series_size(outputs->series) : 0);
    return reserve_hold(&outputs->reserve, outputs->directory, size, error);
}

/* A file with particles in it. */
typedef struct FileJob {
    Job job;
    Outputs *outputs;
    MnsCapture *capture;
    Document *document;
    Order *order;
    JournalPlace journal; /* of a checkpoint: how far it had come */
    int lock;             /* of the directory; -1: it has none    */
    char directory[RUNDIR_PATH];
} FileJob;

static FileMeta meta_of(const Document *document)
{
    return (FileMeta){.c = document->c, .case_name = document->name, .case_text = document->text};
}

/* Take note of an attempt that began then. */
static MnsStatus tally(OutputTally *of, double began, MnsStatus status)
{
    struct timespec now;
    of->seconds += clock_now() - began;
    if (status) of->failed++;
    else of->written++;
    if (!status && !clock_gettime(CLOCK_REALTIME, &now)) of->latest = (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
    return status;
}

static MnsStatus write_snapshot(Job *base, MnsError *error)
{
    const FileJob *job = (const FileJob *)base;
    const double began = clock_now();
    const FileMeta meta = meta_of(job->document);
    char name[NUMBERED_NAME], path[4096];
    name_numbered(SNAPSHOT_BEGIN, job->capture->progress.step, name);
    MnsStatus status = rundir_check(job->directory, job->lock, error);
    if (!status) status = directory_path(path, job->directory, name, error);
    if (!status) status = snapshot_write(path, job->capture, &meta, error);
    if (!status) status = listing_add(&job->outputs->listing, job->outputs->writer, job->directory, error);
    if (!status && job->order) memcpy(job->order->path, path, sizeof path);
    return tally(&job->outputs->snapshots, began, status);
}

/* A checkpoint tells how far the journal had come, and so the journal gets to the disk before it. By a descriptor of our own: what the disk refused is told once to
 * each, and the run must hear of it too. */
static JournalPlace settle_journal(const FileJob *job)
{
    char path[4096];
    const bool named = job->journal.records && !directory_path(path, job->directory, JOURNAL_NAME, NULL);
    const int fd = named ? file_open(path, O_RDONLY, 0) : -1;
    const bool settled = fd >= 0 && !fdatasync(fd);
    if (fd >= 0) close(fd);
    return settled ? job->journal : (JournalPlace){0};
}

static MnsStatus save_checkpoint(const FileJob *job, char ret_path[static 4096], MnsError *error)
{
    const Document *document = job->document;
    FileMeta meta = meta_of(document);
    meta.journal = settle_journal(job);
    const double began = clock_now();
    MnsStatus status = rundir_check(job->directory, job->lock, error);
    if (!status)
        status = checkpoint_write(job->directory, job->capture, &meta, document->blob, document->size,
                                  document->c->output.checkpoints_kept, ret_path, error);
    job->outputs->checkpoint_seconds = clock_now() - began;
    return tally(&job->outputs->checkpoints, began, status);
}

static MnsStatus write_checkpoint(Job *base, MnsError *error)
{
    const FileJob *job = (const FileJob *)base;
    char path[4096];
    const MnsStatus status = save_checkpoint(job, path, error);
    if (!status && job->order) memcpy(job->order->path, path, sizeof path);
    return status ? status : renew_reserve(job->outputs, error);
}

static void tell_order(Job *base, MnsStatus status, const MnsError *error)
{
    FileJob *job = (FileJob *)base;
    Order *order = job->order;
    job->order = NULL;
    if (order) job->outputs->answer(job->outputs->arg, order, status, error);
}

static void free_file_job(Job *base)
{
    FileJob *job = (FileJob *)base;
    mns_capture_free(atomic_exchange(&job->outputs->spare, job->capture));
    document_leave(job->document);
    free(job);
}

static JournalPlace place_of(const Outputs *outputs)
{
    return outputs->journal ? journal_place(outputs->journal) : (JournalPlace){0};
}

static MnsStatus post_file(Outputs *outputs, MnsStatus (*write)(Job *, MnsError *), MnsCapture *capture,
                           Document *document, Order *order, MnsError *error)
{
    FileJob *job = malloc(sizeof *job);
    if (!job) {
        mns_capture_free(capture);
        return mns_fail(error, MNS_E_MEMORY, "no memory for an output");
    }
    const bool seals = write == write_checkpoint; /* a restart writes nothing again that came before it */
    *job = (FileJob){.job = {.heavy = true, .seals = seals, .write = write, .told = tell_order, .free = free_file_job},
                     .outputs = outputs,
                     .capture = capture,
                     .document = document_share(document),
                     .order = order,
                     .journal = place_of(outputs),
                     .lock = outputs->lock};
    memcpy(job->directory, outputs->directory, sizeof job->directory);
    writer_post(outputs->writer, &job->job);
    return MNS_OK;
}

MnsStatus job_post_snapshot(Outputs *outputs, MnsCapture *capture, Document *document, Order *order, MnsError *error)
{
    return post_file(outputs, write_snapshot, capture, document, order, error);
}

MnsStatus job_post_checkpoint(Outputs *outputs, MnsCapture *capture, Document *document, Order *order, MnsError *error)
{
    return post_file(outputs, write_checkpoint, capture, document, order, error);
}

typedef struct RescueJob {
    FileJob file;
    char *ret_path;
} RescueJob;

static MnsStatus rescue_checkpoint(Job *base, MnsError *error)
{
    const RescueJob *job = (const RescueJob *)base;
    return save_checkpoint(&job->file, job->ret_path, error);
}

MnsStatus job_rescue_checkpoint(Outputs *outputs, MnsCapture *capture, Document *document, char *ret_path,
                                MnsError *error)
{
    RescueJob job = {.file = {.job = {.write = rescue_checkpoint},
                              .outputs = outputs,
                              .capture = capture,
                              .document = document,
                              .journal = place_of(outputs),
                              .lock = outputs->lock},
                     .ret_path = ret_path};
    memcpy(job.file.directory, outputs->directory, sizeof job.file.directory);
    return writer_call(outputs->writer, &job.file.job, error);
}

typedef struct RoomJob {
    Job job;
    Outputs *outputs;
} RoomJob;

static MnsStatus give_room(Job *base, MnsError *error)
{
    Outputs *outputs = ((const RoomJob *)base)->outputs;
    (void)error;
    reserve_release(&outputs->reserve);
    outputs->rescued = true;
    return MNS_OK;
}

void job_give_room(Outputs *outputs)
{
    RoomJob job = {{.write = give_room}, outputs};
    writer_call(outputs->writer, &job.job, NULL);
}

/* A sample of all probes; with n = 0, the wish that the series be written. */
typedef struct RowJob {
    Job job;
    Outputs *outputs;
    Series *series;
    int lock; /* of the directory; -1: it has none */
    uint64_t step;
    double t;
    size_t n;
    double values[];
} RowJob;

static MnsStatus write_row(Job *base, MnsError *error)
{
    const RowJob *row = (const RowJob *)base;
    if (row->n) {
        pthread_mutex_lock(&row->outputs->series_lock);
        const MnsStatus added = series_append(row->series, row->step, row->t, row->values, error);
        pthread_mutex_unlock(&row->outputs->series_lock);
        return added;
    }
    const double before = clock_now();
    MnsStatus status = rundir_check(row->outputs->directory, row->lock, error);
    if (!status) status = series_flush(row->series, error);
    row->outputs->flush_seconds = clock_now() - before;
    return status ? status : renew_reserve(row->outputs, error);
}

static void free_row(Job *base)
{
    free(base);
}

MnsStatus job_post_row(Outputs *outputs, MnsProgress at, size_t n, const double *values, MnsError *error)
{
    RowJob *row = malloc(sizeof *row + n * sizeof *values);
    if (!row) return mns_fail(error, MNS_E_MEMORY, "no memory for a sample of the probes");
    *row = (RowJob){.job = {.row = n > 0, .write = write_row, .free = free_row},
                    .outputs = outputs,
                    .series = outputs->series,
                    .lock = outputs->lock,
                    .step = at.step,
                    .t = at.t,
                    .n = n};
    for (size_t k = 0; k < n; k++) row->values[k] = values[k];
    writer_post(outputs->writer, &row->job);
    return MNS_OK;
}

MnsStatus job_post_flush(Outputs *outputs, MnsError *error)
{
    return job_post_row(outputs, (MnsProgress){.t = 0}, 0, NULL, error);
}

typedef struct HoldJob {
    Job job;
    Reserve *reserve;
    const char *directory;
    size_t state_size;
} HoldJob;

size_t outputs_longest(void)
{
    struct rlimit limit;
    const bool known = !getrlimit(RLIMIT_FSIZE, &limit) && limit.rlim_cur != RLIM_INFINITY;
    return known && limit.rlim_cur < SIZE_MAX ? (size_t)limit.rlim_cur : SIZE_MAX;
}

MnsStatus outputs_fit(const MnsSim *sim, MnsError *error)
{
    const size_t state_size = mns_sim_capture_size(sim, mns_sim_state_fields(sim)), longest = outputs_longest();
    if (longest > state_size) return MNS_OK;
    return mns_fail(error, MNS_E_NO_SPACE,
                    "cannot keep the state of this run: it has %zu kB, and the limit on the size of files is %zu kB; "
                    "raise the limit (`ulimit -f`, LimitFSIZE=) or compute with fewer particles",
                    state_size / 1000 + 1, longest / 1000);
}

static MnsStatus hold(Job *base, MnsError *error)
{
    const HoldJob *job = (const HoldJob *)base;
    return reserve_hold(job->reserve, job->directory, at_risk(job->state_size, 0), error);
}

MnsStatus job_hold(Writer *writer, Reserve *reserve, const char *directory, size_t state_size, MnsError *error)
{
    HoldJob job = {{.write = hold}, reserve, directory, state_size};
    return writer_call(writer, &job.job, error);
}

typedef struct OpenJob {
    Job job;
    const char *directory;
    const Document *document;
    bool goes_on;
    uint64_t last_step;
    Series **ret;
} OpenJob;

static MnsStatus open_series(Job *base, MnsError *error)
{
    const OpenJob *job = (const OpenJob *)base;
    const FileMeta meta = meta_of(job->document);
    return series_new(job->directory, &meta, job->goes_on, job->last_step, job->ret, error);
}

MnsStatus job_open_series(Writer *writer, const char *directory, const Document *document, bool goes_on,
                          uint64_t last_step, Series **ret, MnsError *error)
{
    OpenJob job = {{.write = open_series}, directory, document, goes_on, last_step, ret};
    return writer_call(writer, &job.job, error);
}

typedef struct IndexJob {
    Job job;
    const char *directory;
    uint64_t last;
    FileNote *note;
    void *arg;
} IndexJob;

static MnsStatus write_index(Job *base, MnsError *error)
{
    const IndexJob *job = (const IndexJob *)base;
    char path[4096];
    const MnsStatus status = directory_path(path, job->directory, INDEX_NAME, error);
    return status || access(path, F_OK) ? status
                                        : snapshot_index(job->directory, job->last, NULL, job->note, job->arg, error);
}

MnsStatus job_index(Writer *writer, const char *directory, uint64_t last, FileNote *note, void *arg, MnsError *error)
{
    IndexJob job = {{.write = write_index}, directory, last, note, arg};
    return writer_call(writer, &job.job, error);
}

typedef struct ReadJob {
    Job job;
    const char *path;
    CheckpointTakes *takes;
    void (*note)(void *arg, const char *text);
    void *arg;
    Checkpoint *ret;
} ReadJob;

static MnsStatus read_one(Job *base, MnsError *error)
{
    const ReadJob *job = (const ReadJob *)base;
    return checkpoint_read(job->path, job->ret, error);
}

MnsStatus outputs_read(Writer *writer, const char *path, Checkpoint *ret, MnsError *error)
{
    ReadJob job = {.job = {.write = read_one}, .path = path, .ret = ret};
    return writer_call(writer, &job.job, error);
}

static MnsStatus read_newest(Job *base, MnsError *error)
{
    const ReadJob *job = (const ReadJob *)base;
    return checkpoint_newest(job->path, job->ret, job->takes, job->note, job->arg, error);
}

MnsStatus outputs_read_newest(Writer *writer, const char *dir, CheckpointTakes *takes,
                              void (*note)(void *arg, const char *text), void *arg, Checkpoint *ret, MnsError *error)
{
    ReadJob job = {{.write = read_newest}, dir, takes, note, arg, ret};
    return writer_call(writer, &job.job, error);
}
