/* SPDX-License-Identifier: BSD-3-Clause */
/* How many files and sockets the process may have open (`ulimit -n`), and how many our programs take. */
#ifndef COMMON_HOST_OPEN_FILES_H
#define COMMON_HOST_OPEN_FILES_H

#include <meniscus/status.h>

/* What each takes at least, standard files counted and with some to spare. ZeroMQ ends the process where it cannot have the files for its sockets, so
 * programs look before they begin. A daemon gives connections some of its files alone (net/crowd.c), so it takes more than its own thirty. */
enum {
    OPEN_FILES_PROGRAM = 32,     /* a command, or a run without a daemon               */
    OPEN_FILES_CLIENT = 16,      /* one connection of a client: its sockets and theirs */
    OPEN_FILES_DAEMON = 64,      /* a daemon at its socket files                       */
    OPEN_FILES_DAEMON_FAR = 128, /* one with any of --tcp, --listen or --http          */
    OPEN_FILES_DASHBOARD = 128
};

/* Set the soft limit, which is often 1024, to the hard one, or to `most` if that is less. @return how many this process may open. */
int open_files_raise(int most);

/* May the process have `least` files open besides those that it was started with? Those of standard input, output and error are among the `least`.
 * MNS_E_LIMIT: no; the sentence says how many it may. */
MnsStatus open_files_check(int least, MnsError *error);

/* The same for programs: raises the soft limit if that is needed. */
MnsStatus open_files_need(int least, MnsError *error);

#endif
