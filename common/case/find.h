/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the cases are. */
#ifndef COMMON_CASE_FIND_H
#define COMMON_CASE_FIND_H

#include <meniscus/status.h>

/* Where a case is: `name` as a path if it names a file, else NAME.yaml in $MENISCUS_CASES, beside the program
 * (../server/cases from a build directory, ../share/meniscus/cases from an installation). MNS_E_NOT_FOUND says where
 * it looked, what is there and what is like it; MNS_E_INVALID: `name` is a directory or another thing that is no file. */
MnsStatus case_find(const char *name, char ret_path[static 4096], MnsError *error);

/* Tell of each case in the first of these folders that has any, in order of their names. */
void case_list(void (*tell)(void *arg, const char *name, const char *folder), void *arg);

#endif
