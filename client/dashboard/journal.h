/* SPDX-License-Identifier: BSD-3-Clause */
/* The journal of a run, for people: the commands, without the hashes of the state. */
#ifndef DASHBOARD_JOURNAL_H
#define DASHBOARD_JOURNAL_H

#include <jansson.h>
#include <meniscus/status.h>

enum { JOURNAL_RECORDS = 500 };

/* What `meniscus log DIRECTORY -o json` says, of the records only the last JOURNAL_RECORDS of commands. MNS_E_NOT_FOUND: there is no such
 * program; MNS_E_IO, MNS_E_TIMEOUT, MNS_E_LIMIT: it said nothing usable, or too much. */
MnsStatus journal_shown(const char *directory, json_t **ret, MnsError *error);

#endif
