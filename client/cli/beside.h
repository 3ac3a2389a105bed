/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the other programs of the project are. */
#ifndef CLI_BESIDE_H
#define CLI_BESIDE_H

#include <limits.h>
#include <stdbool.h>

/* PATH of a program in the directory of this one. @return false if there is none that may be run. */
bool beside_find(const char *program, char ret[static PATH_MAX]);

#endif
