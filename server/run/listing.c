/* SPDX-License-Identifier: BSD-3-Clause */
/* When the list of a run's snapshots is written again. A reader may find it a little behind the files, and always whole: what a crash has left out
 * is there again when the run is gone on with. */
#include "run/listing.h"

#include "base/clock.h"
#include "io/snapshot.h"
#include "run/rundir.h"
#include <stdio.h>
#include <stdlib.h>

/* So that N snapshots take the time of at most GROWTH N entries and not of N^2 / 2, or of the SHARE-th part of all time. */
enum { GROWTH = 100, SHARE = 20 };

typedef struct ListJob {
    Job job;
    Listing *listing;
    char directory[RUNDIR_PATH];
} ListJob;

static MnsStatus list_all(Listing *listing, const char *directory, MnsError *error)
{
    const double began = clock_now();
    const MnsStatus status = snapshot_index(directory, UINT64_MAX, &listing->listed, NULL, NULL, error);
    const double now = clock_now();
    if (status) return status;
    listing->unlisted = 0;
    listing->next = now + SHARE * (now - began);
    return MNS_OK;
}

static MnsStatus list_late(Job *base, MnsError *error)
{
    const ListJob *job = (const ListJob *)base;
    return job->listing->unlisted ? list_all(job->listing, job->directory, error) : MNS_OK;
}

static void free_job(Job *base)
{
    ListJob *job = (ListJob *)base;
    job->listing->waits = false;
    free(job);
}

/* Without memory it waits for the next snapshot. */
static void list_later(Listing *listing, Writer *writer, const char *directory)
{
    ListJob *job = listing->waits ? NULL : malloc(sizeof *job);
    if (!job) return;
    *job = (ListJob){.job = {.write = list_late, .free = free_job}, .listing = listing};
    snprintf(job->directory, sizeof job->directory, "%s", directory);
    listing->waits = true;
    writer_post_late(writer, &job->job, listing->next);
}

MnsStatus listing_add(Listing *listing, Writer *writer, const char *directory, MnsError *error)
{
    listing->unlisted++;
    const bool grown = listing->unlisted * GROWTH >= listing->listed;
    if (grown || clock_now() >= listing->next) return list_all(listing, directory, error);
    list_later(listing, writer, directory);
    return MNS_OK;
}
