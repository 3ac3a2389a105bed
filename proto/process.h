/* SPDX-License-Identifier: BSD-3-Clause */
/* Limits of the process that all programs must meet alike. */
#ifndef PROTO_PROCESS_H
#define PROTO_PROCESS_H

/* The whole of main(): `run` is called once, in a thread with the stack that our programs need, whatever `ulimit -s` leaves the main one. Signals to the
 * process reach that thread and those it starts. Returns what `run` does.
 *
 * Meanwhile the main thread reaps the children that others have left to this process (proto/children.h): start your own by that.
 *
 * Before that, for all of the process: what is printed is escaped (proto/screen.h). A write beyond the limit on the size of files (`ulimit -f`) then fails with EFBIG, like a write to a full disk;
 * by default the system ends the program with SIGXFSZ. Programs that this one starts inherit it. Threads get stacks of the size that ours need, those of
 * libraries too, whatever `ulimit -s` says; those of OpenMP unless OMP_STACKSIZE says another. */
int process_main(int argc, char **argv, int (*run)(int argc, char **argv));

/* Set the soft limit on open files, which is often 1024, to the hard one, or to `most` if that is less. @return how many this process may open. */
int process_open_files(int most);

#endif
