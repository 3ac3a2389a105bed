/* SPDX-License-Identifier: BSD-3-Clause */
/* Control groups of this process, of both versions, as Linux shows them in files. */
#ifndef COMMON_HOST_CONTROL_GROUPS_H
#define COMMON_HOST_CONTROL_GROUPS_H

#include <stdbool.h>
#include <stdint.h>

/* One group: look for limits in the files of its directory. old: of version 1. */
typedef void GroupLook(void *arg, const char *directory, bool old);

/* Look at the group of this process, those it is in, and the root, which is its own group in a container.
 *  root        "" for the machine; for tests a directory that has its proc and sys/fs/cgroup
 *  controller  "memory", "cpu" */
void groups_each(const char *root, const char *controller, GroupLook *look, void *arg);

/* The number behind a word at the beginning of a line; a word of "" is the first line's. False if there is none, as of "max". */
bool groups_number(const char *path, const char *word, uint64_t *ret);

#endif
