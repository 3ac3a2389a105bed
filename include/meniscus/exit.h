/* SPDX-License-Identifier: BSD-3-Clause */
/** exit.h - exit codes of meniscus and meniscusd, for scripts and workflow managers. */
#ifndef MENISCUS_EXIT_H
#define MENISCUS_EXIT_H

typedef enum MnsExit {
    MNS_EXIT_DONE = 0,         /* done                                                              */
    MNS_EXIT_FAILED = 1,       /* refused or failed                                                 */
    MNS_EXIT_USAGE = 2,        /* the command line is wrong                                         */
    MNS_EXIT_BAD_CASE = 65,    /* the case is wrong: standard error begins with its place           */
    MNS_EXIT_UNREACHABLE = 69, /* no daemon answers                                                 */
    MNS_EXIT_DIVERGED = 70,    /* the simulation has diverged, or a formula failed on the way       */
    MNS_EXIT_IO = 74,          /* a file could not be read or written, or the process may have too few open files */
    MNS_EXIT_AGAIN = 75,       /* stopped by a signal, after a checkpoint if it had begun, or another run has the
                                * directory: run the same command again with --resume auto; or another daemon has the
                                * state directory */
    MNS_EXIT_DENIED = 77,      /* the key is not let in, or lacks the role that this takes          */
    MNS_EXIT_TIMEOUT = 124     /* not done in time                                                  */
} MnsExit;

#endif
