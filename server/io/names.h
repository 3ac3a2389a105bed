/* SPDX-License-Identifier: BSD-3-Clause */
/* The names of numbered files: "checkpoint-0000000100.hdf" is the state after step 100. Ten digits, more if they are needed. */
#ifndef IO_NAMES_H
#define IO_NAMES_H

#include <stdbool.h>
#include <stdint.h>

#define CHECKPOINT_BEGIN "checkpoint-"
#define SNAPSHOT_BEGIN   "snapshot-"
#define NUMBERED_END     ".hdf"
#define JOURNAL_NAME     "journal"
#define INDEX_NAME       "snapshots.hdf.series"

enum { NUMBERED_NAME = 64 };

/* @param begin  CHECKPOINT_BEGIN or SNAPSHOT_BEGIN */
void name_numbered(const char *begin, uint64_t step, char ret[static NUMBERED_NAME]);

/* The step in such a name, of either kind; false for any other name. */
bool name_step(const char *name, uint64_t *ret_step);

#endif
