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

/* How far the journal had come, as the checkpoints know that were written last: of the present time line, and of those that a restore, a reset or a crash
 * has left, which may have come further. Its checksums are of all records up to one, so that the farthest is enough. */
typedef struct Farthest {
    const char *directory; /* of the run */
    uint64_t first;        /* of a JournalPlace */
    JournalPlace place;    /* no records: of none that is known */
    char name[512];        /* of the checkpoint, from the directory of the run on */
} Farthest;

static void look_in(Farthest *farthest, const char *directory, const char *below)
{
    char name[256];
    JournalPlace place;
    if (!checkpoint_place(directory, farthest->first, name, &place) || place.records <= farthest->place.records) return;
    farthest->place = place;
    snprintf(farthest->name, sizeof farthest->name, "%s%s%s", below, *below ? "/" : "", name);
}

static void look_aside(void *arg, const char *name)
{
    Farthest *farthest = arg;
    char path[4096];
    if (!directory_path(path, farthest->directory, name, NULL)) look_in(farthest, path, name);
}

static void find_farthest(const char *directory, const char *path, Farthest *ret)
{
    *ret = (Farthest){.directory = directory};
    if (journal_sum_at(path, JOURNAL_HEAD, &ret->first, NULL)) return;
    look_in(ret, directory, "");
    abandoned_each(directory, look_aside, ret);
}

static MnsStatus compare(const History *history, const char *path, const Farthest *farthest, MnsError *error)
{
    uint64_t last;
    const JournalPlace *place = &farthest->place;
    if (!place->records) return MNS_OK;
    if (history->n < place->records)
        return mns_fail(error, MNS_E_CORRUPT,
                        "'%.200s' is damaged: it ends with record %zu, at byte %" PRIu64 ", and had %" PRIu64
                        " records when %.80s was written: its end was cut off",
                        path, history->n, history->report.size, place->records, farthest->name);
    const HistoryRecord *record = &history->records[place->records - 1];
    const MnsStatus status = journal_sum_at(path, record->offset, &last, error);
    if (status || last == place->last) return status;
    return mns_fail(error, MNS_E_CORRUPT,
                    "'%.200s' is damaged: record %" PRIu64 ", which begins at byte %" PRIu64
                    ", is another than when %.80s was written: the end was cut off before it, and written anew",
                    path, record->number, record->offset, farthest->name);
}

/* The checkpoints are looked at first: of a run that goes on the journal may grow meanwhile. */
MnsStatus history_verify(const char *directory, History *ret, MnsError *error)
{
    char path[4096];
    Farthest farthest;
    *ret = (History){.n = 0};
    MnsStatus status = directory_path(path, directory, JOURNAL_NAME, error);
    if (status) return status;
    find_farthest(directory, path, &farthest);
    status = history_read(directory, ret, error);
    if (!status && !ret->n)
        return mns_fail(error, MNS_E_CORRUPT,
                        "the journal of '%.300s' has no record: it was emptied or cut off, or the run never began",
                        directory);
    return status ? status : compare(ret, path, &farthest, error);
}

/* The first record from k on that left what came behind this step, or NULL. */
static const HistoryRecord *left_by(const History *history, uint64_t k, uint64_t step)
{
    for (; k < history->n; k++)
        if (history_begins(history->records[k].message) && history->records[k].message->step < step)
            return &history->records[k];
    return NULL;
}

/* Is it a state that the journal tells of, on the present time line? */
static bool has_state(const History *history, uint64_t step, uint64_t hash)
{
    for (size_t k = history->n; k-- > 0;) {
        const Meniscus__JournalRecord *record = history->records[k].message;
        if (record->has_state_hash && record->step == step && record->state_hash == hash) return true;
        if (history_begins(record) && record->step < step) return false;
    }
    return false;
}

MnsStatus history_owns(const History *history, const char *directory, const Checkpoint *checkpoint, uint64_t hash,
                       MnsError *error)
{
    char path[4096];
    const JournalPlace *place = &checkpoint->journal;
    const uint64_t step = checkpoint->state->progress.step;
    const MnsStatus status = directory_path(path, directory, JOURNAL_NAME, error);
    if (status || has_state(history, step, hash)) return status;
    if (!has_sum(history, path, 1, place->first) || !has_sum(history, path, place->records, place->last))
        return mns_fail(error, MNS_E_INVALID,
                        "%.200s is a checkpoint of another run, whose state the journal of this one does not lead to; "
                        "restore one that this run has written, or load its own case to go on from it",
                        checkpoint->path);
    const HistoryRecord *left = left_by(history, place->records, step);
    if (!left) return MNS_OK;
    return mns_fail(error, MNS_E_INVALID,
                    "%.200s is of a time line that this run has left: record %" PRIu64
                    " of the journal goes back to step %" PRIu64 "; restore one that was written since then",
                    checkpoint->path, left->number, left->message->step);
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
