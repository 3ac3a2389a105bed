/* SPDX-License-Identifier: BSD-3-Clause */
/* What the environment says of how to compute. */
#ifndef RUN_ENVIRONMENT_H
#define RUN_ENVIRONMENT_H

#include <meniscus/status.h>
#include <stdbool.h>

/* First of all in main(): waiting threads spin for a moment and then sleep, unless the environment says how they wait. Starts the
 * program again, once; returns if that is done or cannot be done. */
void environment_waiting(char **argv);

/* For the thread that calls it: teams of OpenMP have as many threads as processors may be used, of which the runtime knows those that
 * the process is bound to, and not the quota of its control groups. OMP_NUM_THREADS wins. */
void environment_threads(void);

/* Do threads of OpenMP get stacks that the solver fits into? OMP_STACKSIZE may say how large they are. MNS_E_LIMIT: no. */
MnsStatus environment_stacks(MnsError *error);

/* The instruction set of $MENISCUS_LEVEL, if that is set: for those who want the bits of an old machine, or to be spared a machine's
 * slow instructions. Returns what mns_level_force() does. */
MnsStatus environment_level(MnsError *error);

/* The instruction set the program began with: that one, or this machine's best. */
const char *environment_own_level(void);

/* From here on, compute as what is gone on with was computed, unless $MENISCUS_LEVEL says how: by the program's own instruction set, or if that has
 * another arithmetic, by the plainest.
 *  arithmetic  as mns_arithmetic() names it; NULL: not known
 * False if that is not to be had: then it is the program's own. */
bool environment_compute_as(const char *arithmetic);

/* As the program began. */
void environment_compute_anew(void);

#endif
