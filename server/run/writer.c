/* SPDX-License-Identifier: BSD-3-Clause */
/* The thread that writes files, and its queue. */
#include "run/writer.h"

#include "base/clock.h"
#include <assert.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <time.h>

enum { LIGHT_MAX = 4096 }; /* of decency */

struct Writer {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t changed;        /* anything below                                     */
    Job *first;                    /* the one being done, or that failed; then the others */
    Job *late;                     /* the one that waits for its moment, not queued yet; NULL: none */
    double moment;                 /* clock_now()                                        */
    _Atomic unsigned heavy, light; /* changed with the lock held, and looked at without */
    bool busy, leaving, salvaging;
    MnsStatus status; /* of the failed job */
    MnsError error;
    void (*wait)(void *arg);
    void *arg;
};

static void count(Writer *writer, const Job *job, int by)
{
    _Atomic unsigned *which = job->heavy ? &writer->heavy : &writer->light;
    *which += (unsigned)by;
}

static void tell(Job *job, MnsStatus status, const MnsError *error)
{
    if (job->told) job->told(job, status, error);
    if (status && !job->once) job->told = NULL; /* kept; whoever asked has been told */
}

/* Those behind one that failed wait with it until somebody resumes; whoever asked for them does not. */
static void tell_behind(Job *job, MnsStatus status, const MnsError *error)
{
    while ((job = job->next))
        if (!job->once) tell(job, status, error);
}

static void drop(Writer *writer, Job *job)
{
    Job **at = &writer->first;
    while (*at != job) at = &(*at)->next;
    *at = job->next;
    count(writer, job, -1);
    if (job->free) job->free(job);
}

/* Do a job; called with the lock held, which is let go meanwhile. It is gone afterwards, or kept if it failed. */
static MnsStatus work(Writer *writer, Job *job)
{
    MnsError error = {.status = MNS_OK};
    writer->busy = true;
    pthread_mutex_unlock(&writer->lock);
    const MnsStatus status = job->write(job, &error);
    pthread_mutex_lock(&writer->lock);
    tell(job, status, &error);
    writer->busy = false;
    const bool kept = status && !job->once;
    if (kept && !writer->status) {
        writer->status = status;
        writer->error = error;
    }
    if (kept && !writer->salvaging) tell_behind(job, status, &error);
    if (!kept) drop(writer, job);
    pthread_cond_broadcast(&writer->changed);
    return kept ? status : MNS_OK;
}

/* Put a job where list points, before what is there. */
static void insert(Writer *writer, Job **list, Job *job)
{
    job->next = *list;
    *list = job;
    count(writer, job, 1);
    pthread_cond_broadcast(&writer->changed);
}

static Job **end_of(Job **list)
{
    while (*list) list = &(*list)->next;
    return list;
}

/* With the lock held. */
static void queue_late(Writer *writer)
{
    Job *job = writer->late;
    writer->late = NULL;
    if (job) insert(writer, end_of(&writer->first), job);
}

/* Most files stand for themselves, so that one that cannot be written is no reason to give up the others. */
static void salvage(Writer *writer)
{
    bool row_failed = false;
    writer->status = MNS_OK;
    for (Job *job = writer->first, *next; job; job = next) {
        next = job->next;
        if ((job->row && row_failed) || (job->seals && writer->status)) continue;
        const bool is_row = job->row;
        if (work(writer, job) && is_row) row_failed = true;
    }
    Job *late = writer->late; /* what those asked for, too */
    queue_late(writer);
    if (late) work(writer, late);
    writer->salvaging = false;
    pthread_cond_broadcast(&writer->changed);
}

static void await_change(Writer *writer)
{
    if (!writer->late) {
        pthread_cond_wait(&writer->changed, &writer->lock);
        return;
    }
    const struct timespec moment = {
        .tv_sec = (time_t)fmin(writer->moment, 1e15),
        .tv_nsec = isfinite(writer->moment) ? (long)(1e9 * (writer->moment - floor(writer->moment))) : 0};
    pthread_cond_timedwait(&writer->changed, &writer->lock, &moment);
}

static void *writer_thread(void *arg)
{
    Writer *writer = arg;
    pthread_mutex_lock(&writer->lock);
    for (;;) {
        if (writer->late && clock_now() >= writer->moment) queue_late(writer);
        if (writer->salvaging) salvage(writer);
        else if (writer->first && (!writer->status || writer->first->once)) work(writer, writer->first);
        else if (writer->leaving) break;
        else await_change(writer);
    }
    pthread_mutex_unlock(&writer->lock);
    return NULL;
}

MnsStatus writer_new(void (*wait)(void *arg), void *arg, Writer **ret, MnsError *error)
{
    Writer *writer = calloc(1, sizeof *writer);
    if (!writer) return mns_fail(error, MNS_E_MEMORY, "no memory for the writer of files");
    writer->wait = wait;
    writer->arg = arg;
    pthread_mutex_init(&writer->lock, NULL);
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&writer->changed, &attributes);
    pthread_condattr_destroy(&attributes);
    if (pthread_create(&writer->thread, NULL, writer_thread, writer)) {
        free(writer);
        return mns_fail(error, MNS_E_MEMORY, "the operating system refuses a thread for the writer of files");
    }
    *ret = writer;
    return MNS_OK;
}

/* Sleep until something changes, or for a second. */
static void sleep_locked(Writer *writer)
{
    struct timespec moment;
    clock_gettime(CLOCK_MONOTONIC, &moment);
    moment.tv_sec++;
    pthread_cond_timedwait(&writer->changed, &writer->lock, &moment);
    if (writer->wait) writer->wait(writer->arg);
}

/* With the lock held. */
static MnsStatus failure(const Writer *writer, MnsError *error)
{
    if (writer->status && error) *error = writer->error;
    return writer->status;
}

static MnsStatus drain(Writer *writer, MnsError *error)
{
    while (writer->first && !writer->status) sleep_locked(writer);
    return failure(writer, error);
}

void writer_post(Writer *writer, Job *job)
{
    pthread_mutex_lock(&writer->lock);
    while (!writer->status && (job->heavy ? writer->heavy >= WRITER_HEAVY_MAX : writer->light >= LIGHT_MAX))
        sleep_locked(writer);
    insert(writer, end_of(&writer->first), job);
    if (writer->status && !writer->salvaging) tell(job, writer->status, &writer->error); /* it failed meanwhile */
    pthread_mutex_unlock(&writer->lock);
}

void writer_post_late(Writer *writer, Job *job, double moment)
{
    pthread_mutex_lock(&writer->lock);
    assert(!writer->late);
    writer->late = job;
    writer->moment = moment;
    pthread_cond_broadcast(&writer->changed);
    pthread_mutex_unlock(&writer->lock);
}

void writer_hurry(Writer *writer)
{
    pthread_mutex_lock(&writer->lock);
    queue_late(writer);
    pthread_mutex_unlock(&writer->lock);
}

/* A job of the caller's, with room for its outcome. */
typedef struct Call {
    Job job;
    Job *inner;
    bool done;
    MnsStatus status;
    MnsError error;
} Call;

static MnsStatus call_write(Job *job, MnsError *error)
{
    Call *call = (Call *)job;
    return call->inner->write(call->inner, error);
}

/* The lock is held here, so whoever waits for `done` sees the whole outcome. */
static void call_told(Job *job, MnsStatus status, const MnsError *error)
{
    Call *call = (Call *)job;
    call->status = status;
    call->error = *error;
    call->done = true;
}

MnsStatus writer_call(Writer *writer, Job *job, MnsError *error)
{
    Call call = {.job = {.write = call_write, .told = call_told, .once = true}, .inner = job};
    pthread_mutex_lock(&writer->lock);
    drain(writer, NULL);
    insert(writer, &writer->first, &call.job); /* before a failed job, if there is one: nobody is busy with it */
    while (!call.done) sleep_locked(writer);
    if (call.status && error) *error = call.error;
    pthread_mutex_unlock(&writer->lock);
    return call.status;
}

void writer_queue(const Writer *writer, unsigned *ret_heavy, unsigned *ret_light)
{
    *ret_heavy = writer->heavy;
    *ret_light = writer->light;
}

bool writer_is_full(const Writer *writer)
{
    return writer->heavy >= WRITER_HEAVY_MAX;
}

MnsStatus writer_failure(Writer *writer, MnsError *error)
{
    pthread_mutex_lock(&writer->lock);
    const MnsStatus status = failure(writer, error);
    pthread_mutex_unlock(&writer->lock);
    return status;
}

MnsStatus writer_drain(Writer *writer, MnsError *error)
{
    pthread_mutex_lock(&writer->lock);
    const MnsStatus status = drain(writer, error);
    pthread_mutex_unlock(&writer->lock);
    return status;
}

MnsStatus writer_retry(Writer *writer, MnsError *error)
{
    pthread_mutex_lock(&writer->lock);
    writer->status = MNS_OK;
    pthread_cond_broadcast(&writer->changed);
    const MnsStatus status = drain(writer, error);
    pthread_mutex_unlock(&writer->lock);
    return status;
}

MnsStatus writer_salvage(Writer *writer, MnsError *error)
{
    pthread_mutex_lock(&writer->lock);
    writer->salvaging = true;
    pthread_cond_broadcast(&writer->changed);
    while (writer->salvaging) sleep_locked(writer);
    const MnsStatus status = failure(writer, error);
    pthread_mutex_unlock(&writer->lock);
    return status;
}

unsigned writer_discard(Writer *writer)
{
    unsigned n = 0;
    const MnsError error = {.status = MNS_E_INTERRUPTED, .text = "the run was given up before this was written"};
    pthread_mutex_lock(&writer->lock);
    while (writer->busy) sleep_locked(writer);
    queue_late(writer);
    for (; writer->first; n++) {
        tell(writer->first, MNS_E_INTERRUPTED, &error);
        drop(writer, writer->first);
    }
    writer->status = MNS_OK;
    pthread_mutex_unlock(&writer->lock);
    return n;
}

void writer_free(Writer *writer)
{
    if (!writer) return;
    writer_drain(writer, NULL);
    writer_discard(writer);
    pthread_mutex_lock(&writer->lock);
    writer->leaving = true;
    pthread_cond_broadcast(&writer->changed);
    pthread_mutex_unlock(&writer->lock);
    pthread_join(writer->thread, NULL);
    pthread_cond_destroy(&writer->changed);
    pthread_mutex_destroy(&writer->lock);
    free(writer);
}
