/* SPDX-License-Identifier: BSD-3-Clause */
/* What this program would compute with on this machine, for who asks before a run. */
#ifndef BATCH_MACHINE_H
#define BATCH_MACHINE_H

#include <stdbool.h>

/* Print version, instruction set and arithmetic on standard output, as text or as one JSON object. Returns an exit code. */
int machine_print(bool json);

#endif
