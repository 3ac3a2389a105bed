/* SPDX-License-Identifier: BSD-3-Clause */
/* What the journal of a run directory tells: all of its records, in order. */
#ifndef RUN_HISTORY_H
#define RUN_HISTORY_H

#include "io/checkpoint.h"
#include "io/journal.h"
#include "journal.pb-c.h"
#include "run/document.h"
#include <meniscus/sim.h>

typedef struct HistoryRecord {
    uint64_t number, offset; /* in the file */
    Meniscus__JournalRecord *message;
} HistoryRecord;

typedef struct History {
    size_t n;
    HistoryRecord *records; /* [n] */
    JournalReport report;
} History;

/* Read it all. MNS_OK; MNS_E_NOT_FOUND; MNS_E_CORRUPT: a byte has been changed, the sentence says in which record, and what comes
 * before it is here; MNS_E_IO, MNS_E_MEMORY. Free it with history_done() in any case. */
MnsStatus history_read(const char *directory, History *ret, MnsError *error);
void history_done(History *history);

/* Behind what is said of an end that was cut off: a run must not go on there, as what it adds would hide that. */
#define HISTORY_WAY_ON ". Copy that checkpoint into a new directory to go on from it, or begin anew"

/* The same, and compare it with all checkpoints of the run, also of time lines that were left, that tell how far the journal had come. MNS_E_CORRUPT also where its
 * end was cut off since; and in the second where it has no record. */
MnsStatus history_check(const char *directory, History *ret, MnsError *error);
MnsStatus history_verify(const char *directory, History *ret, MnsError *error);

/* Does the journal lead to this state: has the run written the checkpoint, or gone on from it, and not left that time line since? Only then can what follows be
 * replayed, and come back after a crash. MNS_E_INVALID: it does not; MNS_E_VERSION: an older version wrote one of them, and they do not tell. */
MnsStatus history_owns(const History *history, const char *directory, const Checkpoint *checkpoint, MnsError *error);

/* What a record tells was done, and not refused or broken off; false also of hashes. */
bool history_done_well(const Meniscus__JournalRecord *record);

/* Is what comes after it of the case that it has: is it a load, reset or restore that was done? */
bool history_begins(const Meniscus__JournalRecord *record);

/* Does it lead back to a checkpoint, and not to the beginning? */
bool history_goes_back(const Meniscus__JournalRecord *record);

/* The machine's present start, which outlives any program: a UUID, or empty if it is not known. */
enum { HISTORY_BOOT = 40 };
void history_boot(char ret[static HISTORY_BOOT]);

/* Is record k a `lease` of which nobody was told: because the daemon that had written it down was killed before that, or because it took it back?
 *  boot  the machine's present start */
bool history_untold(const History *history, size_t k, const char *boot);

/* Name of its command, as in the protocol; and of that of a request. */
const char *history_command(const Meniscus__JournalRecord *record);
const char *history_request(const Meniscus__Request *request);

/* The state of a checkpoint in the directory and the case that it is of, both yours; what checkpoint_read() returns. */
MnsStatus history_checkpoint(const char *directory, uint64_t step, Document **ret_document, MnsCapture **ret_state,
                             MnsError *error);

#endif
