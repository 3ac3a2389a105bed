/* SPDX-License-Identifier: BSD-3-Clause */
/* How much memory there is: to be asked before, as Linux gives more than it has and ends a process that uses it. */
#ifndef RUN_MEMORY_H
#define RUN_MEMORY_H

#include <stddef.h>

/* Bytes that this process can still take: the least of what is free on the machine, what its control groups are allowed, and what
 * its limit of addresses is; without swap. SIZE_MAX if nobody knows.
 *  root     "" for the machine; for tests a directory that has its proc and sys/fs/cgroup
 *  ret_why  which of them it is, as in "2 GB are ...": "free on this machine" */
size_t memory_free(const char *root, const char **ret_why);

#endif
