/* SPDX-License-Identifier: BSD-3-Clause */
/* The thread that writes files: jobs are done one after the other, in the order they came. A job that fails is kept, and
 * all behind it, until it is tried again or discarded: nothing is lost and nothing is written out of order. */
#ifndef RUN_WRITER_H
#define RUN_WRITER_H

#include <meniscus/status.h>
#include <stdbool.h>

/* A copy of the particles is large, so that only two may be written or wait. */
enum { WRITER_HEAVY_MAX = 2 };

typedef struct Job {
    struct Job *next;
    bool heavy; /* holds a copy of the particles: few of these may wait                                  */
    bool once;  /* a failure is only told, the job is not kept                                           */
    bool row;   /* adds to a file: after a failed one no later one may be written, see writer_salvage()  */
    bool seals; /* promises that all before it is on the disk: the same after a failed job of any kind   */

    /* On the writer's thread; may be called again after a failure. */
    MnsStatus (*write)(struct Job *job, MnsError *error);

    /* On the writer's thread after success, or after any failure (the first one only, if the job is kept); may be NULL. */
    void (*told)(struct Job *job, MnsStatus status, const MnsError *error);

    void (*free)(struct Job *job); /* may be NULL: then it is the poster's */
} Job;

typedef struct Writer Writer;

/* Start the thread. wait(arg) is called now and then while somebody waits for it; may be NULL. */
MnsStatus writer_new(void (*wait)(void *arg), void *arg, Writer **ret, MnsError *error);

/* Finish what can be finished, discard the rest, end the thread. NULL is fine. */
void writer_free(Writer *writer);

/* Hand over a job. Waits while WRITER_HEAVY_MAX heavy ones are queued (many of the others); not if a job has failed, see
 * writer_failure(): the new one is kept behind it. */
void writer_post(Writer *writer, Job *job);

/* Hand over a job that is queued at a moment (clock_now()), or by writer_hurry(), of which there may be one at a time. Waits for nobody. */
void writer_post_late(Writer *writer, Job *job, double moment);

/* Queue that job now, if there is one. */
void writer_hurry(Writer *writer);

/* Do a job of the caller's after all others, but before one that has failed, and wait for it. */
MnsStatus writer_call(Writer *writer, Job *job, MnsError *error);

/* How many heavy jobs, and how many others, are queued or being done. Waits for nobody. */
void writer_queue(const Writer *writer, unsigned *ret_heavy, unsigned *ret_light);

/* Would it keep who posts a heavy job waiting? Waits for nobody. */
bool writer_is_full(const Writer *writer);

/* Has a job failed? MNS_OK or its failure. */
MnsStatus writer_failure(Writer *writer, MnsError *error);

/* Try the failed job again and wait for it and all behind it. MNS_OK, or the next failure. */
MnsStatus writer_retry(Writer *writer, MnsError *error);

/* Try each job that is left once, also those behind a failed one if they do without it, and wait. MNS_OK, or the first failure: the jobs
 * that failed or were not tried are kept. */
MnsStatus writer_salvage(Writer *writer, MnsError *error);

/* Wait until all is written. MNS_OK, or a failure: then what is left is kept. */
MnsStatus writer_drain(Writer *writer, MnsError *error);

/* Throw away what waits, for its moment too, after finishing what is being written, and forget the failure. Returns how many jobs. */
unsigned writer_discard(Writer *writer);

#endif
