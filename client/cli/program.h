/* SPDX-License-Identifier: BSD-3-Clause */
/* Other programs of the project. */
#ifndef CLI_PROGRAM_H
#define CLI_PROGRAM_H

#include <meniscus/status.h>
#include <stddef.h>

/* Become another program: the one beside this one, or else the one in PATH. @param arguments  without the program's
 * name, which is ours, as people typed it; ends with NULL. Returns only if that fails: MNS_E_NOT_FOUND, MNS_E_MEMORY. */
MnsStatus program_become(const char *program, const char *const *arguments, MnsError *error);

/* What another program, found like that, prints on standard output, cut to `size`. MNS_E_NOT_FOUND; MNS_E_IO if it ends with
 * another exit code than 0; MNS_E_LIMIT if there are more than a few arguments. */
MnsStatus program_ask(const char *program, const char *const *arguments, char *ret, size_t size, MnsError *error);

#endif
