/* SPDX-License-Identifier: BSD-3-Clause */
/* How the threads of a team wait for each other. */
#ifndef RUN_WAITING_H
#define RUN_WAITING_H

/* First of all in main(): waiting threads spin for a moment and then sleep, unless the environment says how they wait. Starts the
 * program again, once; returns if that is done or cannot be done. */
void waiting_threads_sleep(char **argv);

#endif
