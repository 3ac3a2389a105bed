/* SPDX-License-Identifier: BSD-3-Clause */
/* What the environment says of how to compute. */
#ifndef RUN_ENVIRONMENT_H
#define RUN_ENVIRONMENT_H

#include <meniscus/status.h>
#include <stdbool.h>

/* First of all in main(): waiting threads spin for a moment and then sleep, unless the environment says how they wait. Starts the
 * program again, once; returns if that is done or cannot be done. */
void environment_waiting(char **argv);

/* The instruction set of $MENISCUS_LEVEL, if that is set: for those who want the bits of an old machine, or to be spared a machine's
 * slow instructions. Returns what mns_level_force() does. */
MnsStatus environment_level(MnsError *error);

/* Is it set? */
bool environment_has_level(void);

#endif
