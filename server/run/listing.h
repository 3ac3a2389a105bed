/* SPDX-License-Identifier: BSD-3-Clause */
/* When the list of a run's snapshots, which ParaView reads, is written again. That is done as a whole, so not after each of very many: at once
 * while they are few, then when they are one in a hundred more, or where it takes a small share of the time; and when the run is left. */
#ifndef RUN_LISTING_H
#define RUN_LISTING_H

#include "run/writer.h"
#include <stddef.h>

/* The writer's thread only, and whoever knows that it has no job; all 0: nothing is known yet. */
typedef struct Listing {
    size_t listed, unlisted; /* snapshots in the list, and those since then      */
    double next;             /* clock_now() from which it may be written again whatever their number [s] */
    bool waits;              /* it is a job of the writer's for that moment   */
} Listing;

/* On the writer's thread: there is one snapshot more in the directory. MNS_OK: it is in the list, or will be soon, or when writer_hurry() is called;
 * or what snapshot_index() returns. */
MnsStatus listing_add(Listing *listing, Writer *writer, const char *directory, MnsError *error);

#endif
