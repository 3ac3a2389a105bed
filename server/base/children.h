/* SPDX-License-Identifier: BSD-3-Clause */
/* Children that this process did not start. As process 1 of a container, or where it was asked for (PR_SET_CHILD_SUBREAPER), it gets those whose
 * parent has ended, and has to take note of their end, or each takes a place in the table of processes for ever. For one thread. */
#ifndef BASE_CHILDREN_H
#define BASE_CHILDREN_H

#include <sys/types.h>

/* One that was started and will be waited for: it is left alone from here on, until that is done and 0 is given. */
void children_keep(pid_t pid);

/* Take note of all others that have ended. Never waits. */
void children_reap(void);

#endif
