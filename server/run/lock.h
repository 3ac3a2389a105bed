/* SPDX-License-Identifier: BSD-3-Clause */
/* A file that says who uses something, locked as long as they do. The kernel lets go of the lock when the process ends, however it
 * ends; the file stays and means nothing by itself. */
#ifndef RUN_LOCK_H
#define RUN_LOCK_H

#include <meniscus/status.h>
#include <stdbool.h>

enum { LOCK_HOLDER = 128 };

/* Lock the file, making it for this user alone if need be, and write into it who we are. Never waits.
 *  ret_fd      lets go of the lock when closed
 *  ret_holder  on MNS_E_STATE, who has it: "process 4711 on host"; else untouched
 * MNS_E_STATE: somebody has it, this process by another call included; MNS_E_NO_SPACE, MNS_E_IO: not possible. */
MnsStatus lock_take(const char *path, int *ret_fd, char ret_holder[static LOCK_HOLDER], MnsError *error);

/* Write that we are leaving, and will let go of the lock in a moment: who comes may wait for that. Is it what a holder says? */
void lock_leave(int fd);
bool lock_is_leaving(const char *holder);

#endif
