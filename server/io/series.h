/* SPDX-License-Identifier: BSD-3-Clause */
/* Time series of the probes: kept in memory, written whole to DIR/probes.hdf each time it is flushed.
 *
 *  /step [rows]   /time [rows] s   /probes/NAME [rows], attribute unit   /meniscus see meta.h
 *
 * In Python:  f = h5py.File("probes.hdf")
 *             t, p1 = f["time"][:], f["probes/P1"][:]        # unit: f["probes/P1"].attrs["unit"].decode() */
#ifndef IO_SERIES_H
#define IO_SERIES_H

#include "io/file.h"

typedef struct Series Series;

/* A series for the probes of meta->c. What an existing DIR/probes.hdf holds up to and including `last_step` is kept
 * if its probes are the same; pass resume = false to begin anew. Nothing is written yet.
 * @param meta  what it points to is borrowed until series_free().
 * MNS_OK; MNS_E_CORRUPT, MNS_E_VERSION, MNS_E_IO if there is a file that cannot be read; MNS_E_INVALID,
 * MNS_E_MEMORY. */
MnsStatus series_new(const char *dir, const FileMeta *meta, bool resume, uint64_t last_step, Series **ret,
                     MnsError *error);

/* How many rows it has. */
size_t series_rows(const Series *series);

/* What its values take [bytes]. */
size_t series_size(const Series *series);

/* Add a row, in place of those of the same step and later: a run that went back to a step comes by it again.
 * values: [meta->c->n_probes], NAN where there is nothing. MNS_E_MEMORY: the row is not added. */
MnsStatus series_append(Series *series, uint64_t step, double t, const double *values, MnsError *error);

/* Write the file: temporary file, fsync, rename. Nothing to do if nothing was added. After a failure it may be tried
 * again. */
MnsStatus series_flush(Series *series, MnsError *error);

/* Free it, flushed or not; NULL is fine. */
void series_free(Series *series);

#endif
