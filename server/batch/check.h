/* SPDX-License-Identifier: BSD-3-Clause */
/* A case looked at before it is run: what it takes, and what is doubtful in it. */
#ifndef BATCH_CHECK_H
#define BATCH_CHECK_H

#include "batch/batch.h"

/* Read and lay out the case, try a few steps, and print on standard output what came of it; nothing is written. Of the options name, settings and
 * json count. Returns an exit code of <meniscus/exit.h>. */
int check_case(const BatchOptions *options);

#endif
