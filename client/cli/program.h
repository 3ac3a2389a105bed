/* SPDX-License-Identifier: BSD-3-Clause */
/* Other programs of the project. */
#ifndef CLI_PROGRAM_H
#define CLI_PROGRAM_H

#include <meniscus/status.h>

/* Become another program: the one beside this one, or else the one in PATH. @param arguments  without the program's
 * name; ends with NULL. Returns only if that fails: MNS_E_NOT_FOUND, MNS_E_MEMORY. */
MnsStatus program_become(const char *program, const char *const *arguments, MnsError *error);

#endif
