/* SPDX-License-Identifier: BSD-3-Clause */
/* The journal of a run directory, for people and for programs. */
#ifndef BATCH_HISTORY_PRINT_H
#define BATCH_HISTORY_PRINT_H

#include <stdbool.h>

/* Print it on standard output: a table, or one JSON object. verify: only whether it is whole. Returns an exit code: MNS_EXIT_IO where
 * a byte has been changed. */
int history_print(const char *directory, bool verify, bool json);

#endif
