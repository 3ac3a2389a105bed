/* SPDX-License-Identifier: BSD-3-Clause */
/* What came of a run: one JSON object, or a few lines for people. */
#ifndef BATCH_OUTCOME_H
#define BATCH_OUTCOME_H

#include "run/run.h"
#include <jansson.h>

typedef struct Outcome {
    RunStatus status;              /* when the run stood still                                       */
    Document *document;            /* a share                                                        */
    double probes[MNS_MAX_PROBES]; /* [document->c->n_probes], NAN where there is nothing          */
    char directory[RUNDIR_PATH];
    MnsError error; /* what went wrong, but for the fault in status; MNS_OK: nothing */
    int code;       /* exit code */
} Outcome;

/* Print on standard output. MNS_E_NO_SPACE, MNS_E_IO if it cannot be written; MNS_E_MEMORY. */
MnsStatus outcome_print(const Outcome *outcome, bool json, MnsError *error);

/* What to do about a failure, where there is no daemon to be asked or commanded: otherwise than mns_status_hint(). */
const char *outcome_hint(MnsStatus status);

/* Print as JSON why there was no run: one object all the same. */
void outcome_print_refusal(const MnsError *error, const char *hint, int code);

/* Print one object as a line, in characters that a terminal may be given, and free it; not 0 if it cannot be written. */
int outcome_print_json(json_t *object, size_t flags);

/* A text that comes from outside, as a name of a file, which need not be UTF-8; null for NULL. */
json_t *outcome_text(const char *text);

/* Say on standard error what went wrong, as compilers do: what is wrong in the case file at this path begins with its place, or with the --set,
 * all else with the name of the program. */
void outcome_complain(const char *path, const MnsError *error);

/* A failure as every command of `meniscus` says it; null if there is none. */
json_t *outcome_failure(const MnsError *error, int code);

void outcome_done(Outcome *outcome);

#endif
