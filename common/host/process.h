/* SPDX-License-Identifier: BSD-3-Clause */
/* Limits of the process that all programs must meet alike. */
#ifndef COMMON_HOST_PROCESS_H
#define COMMON_HOST_PROCESS_H

#include <stdnoreturn.h>

/* The whole of main(): ends the process with what `run` returns. That is called once, in a thread with the stack that our programs need, whatever
 * `ulimit -s` leaves the main one. Signals to the process reach that thread and those it starts. Meanwhile the main thread reaps the children that others
 * have left to this process: start those of your own by common/host/children.h.
 *
 * Before that, for all of the process: what is printed is escaped (common/host/screen.h). A write beyond the limit on the size of files (`ulimit -f`) fails with
 * EFBIG, like a write to a full disk; by default the system ends the program with SIGXFSZ. Programs that this one starts inherit it. Threads get stacks of
 * the size that ours need, those of libraries too; those of OpenMP unless OMP_STACKSIZE says another. At its end, by exit() too, a program whose standard
 * output could not be written says so, and ends with MNS_EXIT_IO if it would have ended with 0. */
noreturn void process_main(int argc, char **argv, int (*run)(int argc, char **argv));

#endif
