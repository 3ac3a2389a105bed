/* SPDX-License-Identifier: BSD-3-Clause */
/* What the journal of a run directory tells. */
#include "run/history.h"

#include "io/directory.h"
#include "io/names.h"
#include "run/abandoned.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static MnsStatus take(void *arg, uint64_t number, uint64_t offset, const void *data, size_t size, MnsError *error)
{
    History *history = arg;
    const size_t n = history->n;
    if (!(n & (n - 1))) { /* a power of two: as large again */
        HistoryRecord *records = reallocarray(history->records, n ? 2 * n : 1, sizeof *records);
        if (!records) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu records of the journal", n);
        history->records = records;
    }
    Meniscus__JournalRecord *message = meniscus__journal_record__unpack(NULL, size, data);
    if (!message)
        return mns_fail(error, MNS_E_CORRUPT,
                        "record %" PRIu64 " of the journal, at byte %" PRIu64 ", is whole but says nothing known here",
                        number, offset);
    history->records[history->n++] = (HistoryRecord){number, offset, message};
    return MNS_OK;
}

MnsStatus history_read(const char *directory, History *ret, MnsError *error)
{
    char path[4096];
    *ret = (History){.n = 0};
    const MnsStatus status = directory_path(path, directory, JOURNAL_NAME, error);
    return status ? status : journal_read(path, take, ret, &ret->report, error);
}

static bool has_sum(const History *history, const char *path, uint64_t record, uint64_t sum)
{
    uint64_t found;
    if (!record || record > history->n) return false;
    return !journal_sum_at(path, history->records[record - 1].offset, &found, NULL) && found == sum;
}

/* A checkpoint that tells how far the journal had come when it was written. */
typedef struct Witness {
    JournalPlace place;
    char name[512]; /* from the directory of the run on */
} Witness;

/* Those of the present time line, and of those that a restore, a reset or a crash has left. */
typedef struct Witnesses {
    const char *directory; /* of the run */
    const char *below;     /* that is looked at: "" for itself */
    size_t n;
    Witness *list; /* [n] */
    bool all;      /* there was memory for each */
} Witnesses;

static void add_witness(void *arg, const char *name, const JournalPlace *place)
{
    Witnesses *of = arg;
    Witness *list = reallocarray(of->list, of->n + 1, sizeof *list);
    if (!list) {
        of->all = false;
        return;
    }
    of->list = list;
    Witness *witness = &list[of->n++];
    witness->place = *place;
    snprintf(witness->name, sizeof witness->name, "%s%s%s", of->below, *of->below ? "/" : "", name);
}

static void look_aside(void *arg, const char *name)
{
    Witnesses *of = arg;
    char path[4096];
    of->below = name;
    if (!directory_path(path, of->directory, name, NULL)) checkpoint_places(path, add_witness, of);
}

static MnsStatus find_witnesses(const char *directory, Witnesses *ret, MnsError *error)
{
    *ret = (Witnesses){.directory = directory, .below = "", .all = true};
    checkpoint_places(directory, add_witness, ret);
    abandoned_each(directory, look_aside, ret);
    return ret->all ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "no memory for a list of %zu checkpoints", ret->n);
}

/* Does the journal lack the record that was its last when the checkpoint was written? One whose journal began otherwise was brought from another run, and
 * proves nothing; of an empty journal the beginning is not known. */
static bool contradicts(const Witness *witness, const History *history, const char *path)
{
    const JournalPlace *place = &witness->place;
    if (history->n && !has_sum(history, path, 1, place->first)) return false;
    return !has_sum(history, path, place->records, place->last);
}

/* Each has to agree: one that was written after the damage does, and hides nothing that an older one knows. The one with most records is named. */
static const Witness *find_contradiction(const Witnesses *witnesses, const History *history, const char *path)
{
    const Witness *found = NULL;
    for (size_t k = 0; k < witnesses->n; k++) {
        const Witness *witness = &witnesses->list[k];
        if (found && witness->place.records <= found->place.records) continue;
        if (contradicts(witness, history, path)) found = witness;
    }
    return found;
}

static MnsStatus fail_cut(const History *history, const char *path, const Witness *witness, MnsError *error)
{
    const uint64_t records = witness->place.records;
    if (!history->n)
        return mns_fail(error, MNS_E_CORRUPT,
                        "'%.200s' is damaged: it has no record, and had %" PRIu64
                        " records when %.60s was written" HISTORY_WAY_ON,
                        path, records, witness->name);
    if (history->n < records)
        return mns_fail(error, MNS_E_CORRUPT,
                        "'%.200s' is damaged: it ends with record %zu, at byte %" PRIu64 ", and had %" PRIu64
                        " records when %.60s was written: its end was cut off" HISTORY_WAY_ON,
                        path, history->n, history->report.size, records, witness->name);
    const HistoryRecord *record = &history->records[records - 1];
    return mns_fail(
        error, MNS_E_CORRUPT,
        "'%.200s' is damaged: record %" PRIu64 ", which begins at byte %" PRIu64
        ", is another than when %.60s was written: the end was cut off before it, and written anew" HISTORY_WAY_ON,
        path, record->number, record->offset, witness->name);
}

/* The checkpoints are looked at first: of a run that goes on the journal may grow meanwhile. */
MnsStatus history_check(const char *directory, History *ret, MnsError *error)
{
    char path[4096];
    Witnesses witnesses;
    *ret = (History){.n = 0};
    MnsStatus status = directory_path(path, directory, JOURNAL_NAME, error);
    if (status) return status;
    status = find_witnesses(directory, &witnesses, error);
    if (!status) status = history_read(directory, ret, error);
    const Witness *found = status ? NULL : find_contradiction(&witnesses, ret, path);
    if (found) status = fail_cut(ret, path, found, error);
    free(witnesses.list);
    return status;
}

MnsStatus history_verify(const char *directory, History *ret, MnsError *error)
{
    const MnsStatus status = history_check(directory, ret, error);
    if (status || ret->n) return status;
    return mns_fail(error, MNS_E_CORRUPT,
                    "the journal of '%.300s' has no record: it was emptied or cut off, or the run never began",
                    directory);
}

/* The first record from k on that left what came behind this step, or NULL. */
static const HistoryRecord *left_by(const History *history, uint64_t k, uint64_t step)
{
    for (; k < history->n; k++)
        if (history_begins(history->records[k].message) && history->records[k].message->step < step)
            return &history->records[k];
    return NULL;
}

/* How many records there were when the checkpoint was written, or when the run went on from it. 0: it is of another run, or with *ret_silent, it is not known
 * whose it is: an older version wrote it, or the record of a run that went on from a checkpoint of this step. */
static uint64_t records_at(const History *history, const char *path, const Checkpoint *checkpoint, bool *ret_silent)
{
    const JournalPlace *place = &checkpoint->journal;
    const uint64_t step = checkpoint->state->progress.step;
    *ret_silent = !place->records;
    if (has_sum(history, path, 1, place->first) && has_sum(history, path, place->records, place->last))
        return place->records;
    for (size_t k = history->n; k-- > 0;) {
        const Meniscus__JournalRecord *record = history->records[k].message;
        if (!history_goes_back(record) || record->step != step) continue;
        if (record->has_from_sum && record->from_sum == checkpoint->sum) return k + 1;
        *ret_silent = *ret_silent || !record->has_from_sum;
    }
    return 0;
}

MnsStatus history_owns(const History *history, const char *directory, const Checkpoint *checkpoint, MnsError *error)
{
    char path[4096];
    bool silent;
    const uint64_t step = checkpoint->state->progress.step;
    const MnsStatus status = directory_path(path, directory, JOURNAL_NAME, error);
    if (status) return status;
    const uint64_t known = records_at(history, path, checkpoint, &silent);
    const HistoryRecord *left = known ? left_by(history, known, step) : NULL;
    if (left)
        return mns_fail(error, MNS_E_INVALID,
                        "%.200s is of a time line that this run has left: record %" PRIu64
                        " of the journal goes back to step %" PRIu64,
                        checkpoint->path, left->number, left->message->step);
    if (known) return MNS_OK;
    if (silent)
        return mns_fail(error, MNS_E_VERSION, "%.200s does not tell which run has written it, as of an older version",
                        checkpoint->path);
    return mns_fail(error, MNS_E_INVALID,
                    "%.200s is a checkpoint of another run, whose state the journal of this one does not lead to",
                    checkpoint->path);
}

void history_done(History *history)
{
    for (size_t k = 0; k < history->n; k++) meniscus__journal_record__free_unpacked(history->records[k].message, NULL);
    free(history->records);
    *history = (History){.n = 0};
}

bool history_done_well(const Meniscus__JournalRecord *record)
{
    return record->kind == MENISCUS__JOURNAL_RECORD__KIND__COMMAND && record->request &&
           (!record->reply || record->reply->code == MENISCUS__CODE__OK);
}

bool history_begins(const Meniscus__JournalRecord *record)
{
    return history_done_well(record) && record->case_ &&
           record->request->command_case != MENISCUS__REQUEST__COMMAND_ROLLBACK;
}

bool history_goes_back(const Meniscus__JournalRecord *record)
{
    if (!history_begins(record)) return false;
    if (record->has_from_checkpoint) return record->from_checkpoint;
    if (record->request->command_case == MENISCUS__REQUEST__COMMAND_RESTORE) return true;
    return record->request->command_case == MENISCUS__REQUEST__COMMAND_LOAD && record->request->load->resume &&
           record->step > 0;
}

void history_boot(char ret[static HISTORY_BOOT])
{
    FILE *file = fopen("/proc/sys/kernel/random/boot_id", "re");
    if (!file || !fgets(ret, HISTORY_BOOT, file)) ret[0] = 0;
    ret[strcspn(ret, "\n")] = 0;
    if (file) fclose(file);
}

static bool is_of_boot(const Meniscus__JournalRecord *record, const char *boot)
{
    return record->boot.len == strlen(boot) && !memcmp(record->boot.data, boot, record->boot.len);
}

bool history_untold(const History *history, size_t k, const char *boot)
{
    const Meniscus__JournalRecord *record = history->records[k].message, *last = NULL;
    if (!record->has_boot || history_begins(record) || !history_done_well(record)) return false;
    for (k++; k < history->n; k++) {
        const Meniscus__JournalRecord *next = history->records[k].message;
        const bool tells = next->kind == MENISCUS__JOURNAL_RECORD__KIND__LEASE;
        if (last && !tells) break;
        if (history_begins(next) && next->comeback && next->has_boot) /* where it was judged already */
            return record->boot.len == next->boot.len && !memcmp(record->boot.data, next->boot.data, next->boot.len);
        if (tells) last = next;
    }
    return last ? last->undone : is_of_boot(record, boot);
}

const char *history_request(const Meniscus__Request *request)
{
    const ProtobufCFieldDescriptor *field =
        protobuf_c_message_descriptor_get_field(&meniscus__request__descriptor, (unsigned)request->command_case);
    return field ? field->name : "";
}

const char *history_command(const Meniscus__JournalRecord *record)
{
    return record->request ? history_request(record->request) : "";
}

MnsStatus history_checkpoint(const char *directory, uint64_t step, Document **ret_document, MnsCapture **ret_state,
                             MnsError *error)
{
    char name[NUMBERED_NAME], path[4096];
    Checkpoint checkpoint;
    name_numbered(CHECKPOINT_BEGIN, step, name);
    MnsStatus status = directory_path(path, directory, name, error);
    if (!status) status = checkpoint_read(path, &checkpoint, error);
    if (status) return status;
    status = document_unpack(checkpoint.case_blob, checkpoint.case_size, name, ret_document, error);
    if (!status) {
        *ret_state = checkpoint.state;
        checkpoint.state = NULL;
    }
    checkpoint_done(&checkpoint);
    return status;
}
