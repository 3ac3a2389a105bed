/* SPDX-License-Identifier: BSD-3-Clause */
/* A run once more, from its journal: does it come to the same bits? */
#ifndef BATCH_REPLAY_H
#define BATCH_REPLAY_H

#include <stdbool.h>

/* Execute the case with all that was commanded and compare the hashes of the state that the journal has, from the last load that
 * began anew. Nothing is written but what is printed on standard output.
 *  threads  of the solver; -1: as the case says
 * Returns an exit code: MNS_EXIT_DONE if all agree, MNS_EXIT_FAILED if not or if it cannot be replayed, MNS_EXIT_IO. */
int replay_run(const char *directory, int threads, bool json);

#endif
