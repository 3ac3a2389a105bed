/* SPDX-License-Identifier: BSD-3-Clause */
/* What led to where a run was, of all that its journal tells: the way from its last beginning, without the time lines that were
 * left. */
#ifndef RUN_LINEAGE_H
#define RUN_LINEAGE_H

#include "run/history.h"
#include "run/state.h"

/* At a step: a command, or a case that was adopted with a restore or a rollback. */
typedef struct LineageEntry {
    uint64_t step;
    const Meniscus__Request *request;
    const Meniscus__Case *adopted;
    uint64_t version; /* of the case that it led to; 0: to none                       */
    bool anew;        /* that none before it can be gone back to from                */
    bool scheduled;   /* accepted here; it shortened steps up to the step `until`, at which it was done or dropped */
    uint64_t until;   /* UINT64_MAX: it waits still                                  */
    const Meniscus__Who *who; /* of a scheduled one; or NULL                          */
} LineageEntry;

/* The last lease that somebody was told of. */
typedef struct LineageLease {
    uint64_t epoch; /* 0: none                                                                     */
    const char *holder;
    uint64_t until_us; /* on the wall clock                                                           */
    uint64_t ttl_ms;   /* the same, from when it was given: no lease lives longer, whatever the clock says */
} LineageLease;

/* All borrowed from the history but `entries`, `waiting` and `timed`. */
typedef struct Lineage {
    const char *directory;          /* of the run; the caller's                                           */
    const char *name;               /* of the case                                                        */
    const Meniscus__Case *original; /* as it was loaded                                                   */
    uint64_t first_version;         /* of the original                                                    */
    const char *arithmetic; /* in which it was computed since its last beginning; NULL: the journal does not say */
    size_t n;
    LineageEntry *entries; /* [n] of [room], by rising steps                                     */
    size_t room, n_waiting, n_timed;
    size_t *waiting; /* [n_waiting] entries that are scheduled and neither done nor dropped: few */
    size_t *timed;   /* [n_timed] those that have shortened steps                          */
    bool brought;    /* it began from a checkpoint and not from the start   */
    bool ended;      /* by a stop or a shutdown: there is nothing to come back to          */
    bool untouched;  /* the daemon has loaded it, and nothing was commanded since           */
    RunState state;  /* after the last command                                             */
    uint64_t step;   /* the same: it was there, or beyond if it was RUNNING                */
    const Meniscus__Request
        *broken; /* it is PAUSED before a step that it does not survive, and was told to take; or NULL */
    const Meniscus__Request *begun; /* a step or run_until that was under way; or NULL                     */
    uint64_t begun_step;
    LineageLease lease;
} Lineage;

/* boot: of history_boot(). MNS_OK; MNS_E_STATE: there is no load, or it has ended; MNS_E_MEMORY. Free it with lineage_done() in any case. */
MnsStatus lineage_of(const History *history, const char *boot, Lineage *ret, MnsError *error);
void lineage_done(Lineage *lineage);

/* How long the last lease lives on at this moment of the wall clock, the only one that a crash leaves; where that was put back, no longer
 * than it was given for. Both in [s]; negative: it is over. */
double lineage_lease_left(const Lineage *lineage, double wall);

/* The time to which what was scheduled shortened the step that followed the boundary of this step [s]; INFINITY: to none. */
double lineage_limit(const Lineage *lineage, uint64_t step, double t);

/* Is it a step or run_until, or its end (NULL): the time to which the last step is shortened? */
bool lineage_is_limit(const Meniscus__Request *request);

/* Has it set the run in motion? */
bool lineage_sets_out(const Meniscus__Request *request);

/* One is there from the step on at which it was set, however far back: what was true by then has halted the run already. */
bool lineage_is_breakpoint(const LineageEntry *entry);

/* Must entry k be done again by a run that goes on from a checkpoint of this step? Checkpoints have what was set, and nothing else. */
bool lineage_needs(const Lineage *lineage, size_t k, uint64_t checkpoint);

#endif
