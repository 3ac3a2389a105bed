/* SPDX-License-Identifier: BSD-3-Clause */
/* Time series of the probes: kept in memory, written whole to DIR/probes.hdf each time it is flushed.
 *
 *  /step [rows]   /time [rows] s   /probes/NAME [rows], attribute unit   /meniscus see meta.h
 *  /lines/id [lines]   /lines/row [lines]: time lines, the latest last, and the row at which each begins
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

/* Rename DIR/probes.hdf, which cannot be read, to probes.hdf.damaged, in the place of an earlier one. MNS_E_IO. */
MnsStatus series_set_aside(const char *dir, MnsError *error);

/* How many rows it has; how many of them are in the file, for any thread. */
size_t series_rows(const Series *series);
size_t series_saved(const Series *series);

/* From here on rows may be others than those that were here before. Done by series_new() for the first row; was_cut: it left out rows. */
bool series_was_cut(const Series *series);
MnsStatus series_begin_line(Series *series, MnsError *error);

/* The present time line; and how many rows of another one are still what they were, 0 if it is not known. */
uint64_t series_line(const Series *series);
size_t series_line_end(const Series *series, uint64_t line);

/* Copy rows out, of these probes; values: [n][n_columns]. */
void series_copy(const Series *series, size_t first, size_t n, size_t n_columns, const int *columns, uint64_t *step,
                 double *time, double *values);

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
