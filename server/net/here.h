/* SPDX-License-Identifier: BSD-3-Clause */
/* Requests that the thread of the sockets answers at once, from what the run last published. */
#ifndef NET_HERE_H
#define NET_HERE_H

#include "net/exchange.h"

enum { ENTRIES_MAX = 128 }; /* of one get or set; many times what can be set */

void here_status(Run *run, Exchange *x);
void here_capabilities(Run *run, Exchange *x);
void here_get(Run *run, Exchange *x);

/* Entries of a case into the reply. MNS_E_STATE: document is NULL; MNS_E_NOT_FOUND, MNS_E_MEMORY. */
MnsStatus here_entries(const Document *document, Exchange *x, size_t n, const char *const *paths, MnsError *error);

#endif
