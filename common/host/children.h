/* SPDX-License-Identifier: BSD-3-Clause */
/* Children of this process: those that it starts, and those that it gets. As process 1 of a container, or where it was asked for
 * (PR_SET_CHILD_SUBREAPER), it gets those whose parent has ended, and has to take note of their end, or each takes a place in the table of processes for
 * ever. */
#ifndef COMMON_HOST_CHILDREN_H
#define COMMON_HOST_CHILDREN_H

#include <spawn.h>
#include <sys/types.h>

/* One that was started here. It stays where it is until it was waited for. */
typedef struct Child {
    pid_t pid; /* 0: not started, or ended */
    struct Child *next;
} Child;

/* As posix_spawnp() does, with the environment of this process. Returns 0, or an errno. */
int children_start(Child *ret, const char *program, const posix_spawn_file_actions_t *actions, char *const *words);

/* Wait for its end. Returns its status, as of waitpid(). */
int children_wait(Child *child);

/* Take note of all that have ended and were not started here. Never waits. */
void children_reap(void);

#endif
