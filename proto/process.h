/* SPDX-License-Identifier: BSD-3-Clause */
/* Limits of the process that all programs must meet alike. */
#ifndef PROTO_PROCESS_H
#define PROTO_PROCESS_H

/* Call it first in main(). A write beyond the limit on the size of files (`ulimit -f`) then fails with EFBIG, like a write to a full disk;
 * by default the system ends the program with SIGXFSZ. Programs that this one starts inherit it. Threads get stacks of the size that ours need, those of
 * libraries too, whatever `ulimit -s` says; those of OpenMP unless OMP_STACKSIZE says another. */
void process_begin(void);

/* Set the soft limit on open files, which is often 1024, to the hard one, or to `most` if that is less. @return how many this process may open. */
int process_open_files(int most);

#endif
