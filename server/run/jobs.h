/* SPDX-License-Identifier: BSD-3-Clause */
/* The jobs of the writer's thread: each owns all it needs, so that the run may go on, change its case or end meanwhile. */
#ifndef RUN_JOBS_H
#define RUN_JOBS_H

#include "run/outputs.h"

/* All return MNS_OK when the job is queued, or MNS_E_MEMORY. */

/* Each takes over the capture, and the order if it is queued. */
MnsStatus job_post_snapshot(Outputs *outputs, MnsCapture *capture, Document *document, Order *order, MnsError *error);
MnsStatus job_post_checkpoint(Outputs *outputs, MnsCapture *capture, Document *document, Order *order, MnsError *error);

/* Waits: give up the reserve, for an output that has failed. */
void job_give_room(Outputs *outputs);

/* Waits: a checkpoint; ret_path: [4096], where it is. The capture stays the caller's. */
MnsStatus job_rescue_checkpoint(Outputs *outputs, MnsCapture *capture, Document *document, char *ret_path,
                                MnsError *error);

/* Add a row of n values to the series; write the series. */
MnsStatus job_post_row(Outputs *outputs, MnsProgress at, size_t n, const double *values, MnsError *error);
MnsStatus job_post_flush(Outputs *outputs, MnsError *error);

/* Waits: hold in a directory what all that can be waiting to be written takes, a checkpoint and the series among it.
 * MNS_E_NO_SPACE. */
MnsStatus job_hold(Writer *writer, Reserve *reserve, const char *directory, size_t state_size, MnsError *error);

/* Waits: series_new(). */
MnsStatus job_open_series(Writer *writer, const char *directory, const Document *document, bool goes_on,
                          uint64_t last_step, Series **ret, MnsError *error);

/* Waits: snapshot_index(), whose note() is called on the writer's thread, if there is an index. */
MnsStatus job_index(Writer *writer, const char *directory, uint64_t last, FileNote *note, void *arg, MnsError *error);

#endif
