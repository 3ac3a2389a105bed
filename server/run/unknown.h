/* SPDX-License-Identifier: BSD-3-Clause */
/* Names that somebody asks for and that there are not: what they may have meant, and what there is. */
#ifndef RUN_UNKNOWN_H
#define RUN_UNKNOWN_H

#include <meniscus/case.h>
#include <stdint.h>

/* MNS_E_NOT_FOUND, with the path of the entry to blame. name may be NULL.
 *  fields  those that there are, bit k for field k of mns_fields() */
MnsStatus unknown_field(const char *path, const char *name, uint64_t fields, MnsError *error);
MnsStatus unknown_probe(const char *path, const char *name, const MnsCase *c, MnsError *error);

#endif
