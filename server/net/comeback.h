/* SPDX-License-Identifier: BSD-3-Clause */
/* A daemon that is started again: what it replied before, the run that a crash has ended, what was under way. */
#ifndef NET_COMEBACK_H
#define NET_COMEBACK_H

#include "net/answers.h"
#include "run/lineage.h"
#include "run/rundir.h"

typedef struct Comeback {
    History history;
    Lineage lineage;
    bool due;  /* there is a run to come back to                                             */
    bool same; /* it was loaded by a daemon whose command line asked for the same case, or none */
    char directory[RUNDIR_PATH];
} Comeback;

/* Look for the run that was loaded last below parent, and remember what was replied there, and in those before it. Not MNS_OK: it is the one that is
 * asked for, and what its journal tells is not to be had; a new run would forget it. MNS_E_NOT_FOUND: its directory is not there.
 *  asked  as in RunOptions */
MnsStatus comeback_begin(Comeback *comeback, const char *parent, const char *asked, Answers *answers, MnsError *error);

/* The request that leads back to it; its order takes the lineage. Borrowed. */
void comeback_request(const Comeback *comeback, Meniscus__Request *ret, Meniscus__Load *load);

/* Both the caller's; NULL if there is none, or no memory.
 *  resume  for a run that was going on by itself, or in FAULT by a step that it does not survive, to be served after the request above
 *  rest    the step or run_until that was under way, under its id */
Meniscus__Request *comeback_resume(const Comeback *comeback);
Meniscus__Request *comeback_rest(const Comeback *comeback);

/* Take again what was scheduled, under its ids, to be served after the request above. */
void comeback_scheduled(const Comeback *comeback, Answers *answers);

void comeback_done(Comeback *comeback);

#endif
