/* SPDX-License-Identifier: BSD-3-Clause */
/* What the journal of a run is told, and when its answers may leave. Answers of one round of orders wait for the disk
 * together; between steps the solver waits for it only where a command took effect. */
#include "run/inside.h"

#include "base/clock.h"
#include "base/log.h"
#include "common/case/file.h"
#include "io/directory.h"
#include "io/names.h"
#include "journal.pb-c.h"
#include "run/history.h"
#include "run/lineage.h"
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* For the records that a command leads to besides its own: how a step ended that it breaks off, a hash. */
enum { ROOM_BESIDES = 16 << 10 };

/* All that a run does again after a crash stands in one record, of JOURNAL_RECORD_MAX at most: so a checkpoint comes when the commands since
 * the last take this much, and what is commanded at one step boundary, which no checkpoint makes less, has an end. */
enum { NOTED_MAX = 8 << 20, NOTED_HERE_MAX = 12 << 20 };
_Static_assert((int)NOTED_HERE_MAX < (int)JOURNAL_RECORD_MAX, "with the case besides");

typedef Meniscus__JournalRecord Record;

/* --- the file ---------------------------------------------------------------------------------------------------------- */

static void tell_torn(Run *run, const char *path, const JournalReport *report)
{
    char text[512];
    if (!report->torn) return;
    snprintf(text, sizeof text,
             "the last %" PRIu64
             " bytes of %.300s were a record that a crash has left half written, and nobody was told "
             "of; they are cut off behind record %" PRIu64,
             report->torn, path, report->records);
    run_tell(run, NOTE_LOG, LOG_WARNING, "journal", text);
}

MnsStatus run_journal_open(Run *run, const char *directory, Journal **ret, bool *ret_made, MnsError *error)
{
    char path[4096];
    JournalReport report;
    Journal *journal = NULL;
    MnsStatus status = directory_path(path, directory, JOURNAL_NAME, error);
    if (status) return status;
    const bool made = access(path, F_OK) != 0;
    status = journal_open(path, &journal, &report, error);
    if (!status) status = journal_reserve(journal, ROOM_BESIDES, error);
    if (status) {
        journal_free(journal);
        if (made) unlink(path);
        return status;
    }
    tell_torn(run, path, &report);
    *ret = journal;
    *ret_made = made;
    return MNS_OK;
}

/* --- records ----------------------------------------------------------------------------------------------------------- */

static uint64_t wall_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u;
}

/* A failure is told by the next run_commit(). */
static void add(Run *run, Meniscus__JournalRecord__Kind kind, Record *record)
{
    record->has_kind = record->has_wall_us = record->has_step = true;
    record->kind = kind;
    record->wall_us = wall_us();
    const size_t size = meniscus__journal_record__get_packed_size(record);
    uint8_t *packed = malloc(size + 1);
    if (packed) meniscus__journal_record__pack(record, packed);
    if (!packed) mns_fail(&run->unwritten, MNS_E_MEMORY, "no memory for a record of the journal");
    else if (!journal_add(run->journal, packed, size, &run->unwritten)) run->journal_tally.records++;
    free(packed);
}

static void set_time(const Run *run, Record *record)
{
    record->has_time = run->sim != NULL;
    if (run->sim) record->time = mns_sim_progress(run->sim).t;
}

static void add_of_order(Run *run, Meniscus__JournalRecord__Kind kind, Record *record, Order *order)
{
    Meniscus__Who who = MENISCUS__WHO__INIT;
    who.name = (char *)order->who.name;
    who.role = (char *)role_name(order->who.role);
    record->who = &who;
    record->request = (Meniscus__Request *)order->request;
    const size_t size = meniscus__journal_record__get_packed_size(record);
    run->noted += size;
    run->noted_here += size;
    add(run, kind, record);
    record->who = NULL;
}

/* What is to come of it will be told by another record. */
static void note_ahead(Run *run, Meniscus__JournalRecord__Kind kind, Order *order)
{
    Record record = MENISCUS__JOURNAL_RECORD__INIT;
    if (!order->request || !run->journal) return;
    record.step = mns_sim_progress(run->sim).step;
    record.has_state = kind == MENISCUS__JOURNAL_RECORD__KIND__SCHEDULED;
    record.state = (Meniscus__State)run->state;
    set_time(run, &record);
    add_of_order(run, kind, &record, order);
    order->begun = run->uncommitted = true;
}

void run_note_begun(Run *run, Order *order)
{
    note_ahead(run, MENISCUS__JOURNAL_RECORD__KIND__BEGUN, order);
}

void run_note_scheduled(Run *run, Order *order)
{
    note_ahead(run, MENISCUS__JOURNAL_RECORD__KIND__SCHEDULED, order);
}

void run_note_halted(Run *run, RunState state)
{
    Record record = MENISCUS__JOURNAL_RECORD__INIT;
    if (!run->journal) return;
    record.step = mns_sim_progress(run->sim).step;
    record.has_state = true;
    record.state = (Meniscus__State)state;
    set_time(run, &record);
    add(run, MENISCUS__JOURNAL_RECORD__KIND__HALTED, &record);
    journal_write(run->journal, NULL); /* as a hash: where the machine fails the run comes to stand there once more */
}

void run_note_hash(Run *run)
{
    Record record = MENISCUS__JOURNAL_RECORD__INIT;
    const bool broken = run_is_broken(run); /* in the middle of a step */
    if (!run->journal || broken) return;
    record.step = mns_sim_progress(run->sim).step;
    set_time(run, &record);
    record.has_state_hash = true;
    record.state_hash = run->hash;
    add(run, MENISCUS__JOURNAL_RECORD__KIND__HASH, &record);
    journal_write(run->journal, NULL); /* what fails here is tried again with the next command, and told then */
}

/* Written before anybody is told, and not waited for: of what is in the file only a machine that fails loses anything. */
static MnsStatus note_lease_told(Run *run, bool undone, MnsError *error)
{
    Record record = MENISCUS__JOURNAL_RECORD__INIT;
    record.step = run->sim ? mns_sim_progress(run->sim).step : 0;
    set_time(run, &record);
    record.has_undone = undone;
    record.undone = undone;
    add(run, MENISCUS__JOURNAL_RECORD__KIND__LEASE, &record);
    if (!run->unwritten.status) return journal_write(run->journal, error);
    *error = run->unwritten;
    return error->status;
}

/* Entries that a set has changed. */
typedef struct Changes {
    size_t n;
    Meniscus__Change **list;
    bool whole; /* there was memory for all */
} Changes;

static Meniscus__Change *new_change(const char *path, const char *before, const char *after)
{
    Meniscus__Change *change = malloc(sizeof *change);
    if (!change) return NULL;
    meniscus__change__init(change);
    change->path = strdup(path);
    change->before = strdup(before);
    change->after = strdup(after);
    if (change->path && change->before && change->after) return change;
    meniscus__change__free_unpacked(change, NULL);
    return NULL;
}

static void add_change(void *arg, const char *path, const char *before, const char *after)
{
    Changes *changes = arg;
    Meniscus__Change **list = reallocarray(changes->list, changes->n + 1, sizeof *list);
    if (list) changes->list = list;
    Meniscus__Change *change = list ? new_change(path, before, after) : NULL;
    if (change) list[changes->n++] = change;
    else changes->whole = false;
}

static void free_changes(Changes *changes)
{
    for (size_t k = 0; k < changes->n; k++) meniscus__change__free_unpacked(changes->list[k], NULL);
    free(changes->list);
}

static bool begins_anew(const Order *order)
{
    switch (order->request->command_case) {
    case MENISCUS__REQUEST__COMMAND_LOAD:
    case MENISCUS__REQUEST__COMMAND_RESET:
    case MENISCUS__REQUEST__COMMAND_RESTORE: return true;
    default: return false;
    }
}

/* What a load after a crash is going to do again stands in its own record: both are there, or none. */
static void fill_again(Meniscus__Again *item, const LineageEntry *entry, uint64_t step)
{
    meniscus__again__init(item);
    item->has_step = true;
    item->step = entry->step > step || lineage_is_breakpoint(entry) ? entry->step : step;
    item->request = (Meniscus__Request *)entry->request;
    item->adopted = (Meniscus__Case *)entry->adopted;
    item->has_case_version = entry->version > 0;
    item->case_version = entry->version;
    item->has_anew = item->anew = entry->anew;
    item->has_scheduled = item->scheduled = entry->scheduled;
    item->has_until_step = entry->scheduled && entry->until != UINT64_MAX;
    item->until_step = entry->until;
    item->who = (Meniscus__Who *)entry->who;
}

static Meniscus__Again **list_again(const Lineage *lineage, uint64_t step, size_t *ret_n)
{
    Meniscus__Again **list = calloc(lineage->n + 1, sizeof *list);
    Meniscus__Again *items = calloc(lineage->n + 1, sizeof *items);
    size_t n = 0;
    if (!list || !items) {
        free(list);
        free(items);
        return NULL;
    }
    for (size_t k = 0; k < lineage->n; k++) {
        if (!lineage_needs(lineage, k, step)) continue;
        fill_again(&items[n], &lineage->entries[k], step);
        list[n] = &items[n];
        n++;
    }
    if (!n) free(items);
    *ret_n = n;
    return list;
}

static void free_again(Meniscus__Again **list)
{
    if (list) free(list[0]);
    free(list);
}

/* Its own record may be in the journal of another run, or in none. True: to be told with this order. */
static bool tell_lease(const Run *run, const Order *order, Meniscus__LeaseGrant *ret)
{
    const bool loads = order->request->command_case == MENISCUS__REQUEST__COMMAND_LOAD && !order->lineage;
    if (!loads || !run->lease.epoch) return false;
    const double left = run->lease.until - clock_now();
    meniscus__lease_grant__init(ret);
    ret->has_epoch = ret->has_ttl_ms = true;
    ret->epoch = run->lease.epoch;
    ret->ttl_ms = left > 0 ? (uint64_t)(1e3 * left) : 0;
    ret->holder = (char *)run->lease.holder;
    return true;
}

/* One on the way back, and one of the daemon's own, for a signal. */
bool run_leaves_unended(const Run *run, const Order *order)
{
    const bool own = !strcmp(order->who.name, WHO_DAEMON);
    return order->request->command_case == MENISCUS__REQUEST__COMMAND_SHUTDOWN && (own || run->recovery.lineage);
}

/* The step that the run has come to: files take their time, and on the way back others have effect where the run was. */
static uint64_t noted_at(const Run *run, const Order *order)
{
    const bool later = order->filed || (run->recovery.lineage && run->sim && !begins_anew(order));
    return later ? mns_sim_progress(run->sim).step : order->effect_step;
}

static void note_done(Run *run, Order *order)
{
    Changes changes = {.whole = true};
    Record record = MENISCUS__JOURNAL_RECORD__INIT;
    Meniscus__LeaseGrant lease;
    char boot[HISTORY_BOOT] = "";
    record.step = noted_at(run, order);
    set_time(run, &record);
    if (tell_lease(run, order, &lease)) record.lease = &lease;
    if (run->before) case_message_differences(run->before->message, run->document->message, add_change, &changes);
    record.n_changes = changes.n;
    record.changes = changes.list;
    const bool anew = begins_anew(order), comeback = anew && order->lineage;
    if (anew || order->request->command_case == MENISCUS__REQUEST__COMMAND_ROLLBACK)
        record.case_ = run->document->message;
    if (record.case_) {
        record.level = (char *)mns_level();
        record.arithmetic = (char *)mns_arithmetic();
    }
    record.has_from_checkpoint = anew;
    record.from_checkpoint = record.has_from_sum = order->from_checkpoint;
    record.from_sum = order->from_sum;
    record.has_broken = record.broken = run->state == RUN_FAULT && !run->output_failed;
    record.has_case_version = run->versions.number > 0;
    record.case_version = run->versions.number;
    record.has_comeback = record.comeback = comeback || run_leaves_unended(run, order);
    if (comeback || order->request->command_case == MENISCUS__REQUEST__COMMAND_LEASE) history_boot(boot);
    record.has_boot = boot[0] != 0;
    record.boot = (ProtobufCBinaryData){strlen(boot), (uint8_t *)boot};
    if (comeback) record.again = list_again(order->lineage, order->effect_step, &record.n_again);
    record.reply = order->seal ? (Meniscus__Reply *)order->seal(order) : NULL;
    if (!changes.whole || (comeback && !record.again))
        mns_fail(&run->unwritten, MNS_E_MEMORY, "no memory for the journal");
    add_of_order(run, MENISCUS__JOURNAL_RECORD__KIND__COMMAND, &record, order);
    free_again(record.again);
    free_changes(&changes);
}

void run_note_done(Run *run, Order *order)
{
    if (!run->journal || (order->status && !order->begun)) return;
    note_done(run, order);
    run->uncommitted = true;
}

MnsStatus run_bound_way_back(Run *run, MnsError *error)
{
    const bool covered = run->outputs.at_checkpoint == mns_sim_progress(run->sim).step, due = run->noted > NOTED_MAX;
    run->noted_here = 0;
    if (covered || due) run->noted = 0;
    return due && !covered ? outputs_checkpoint(&run->outputs, run->sim, run->document, NULL, error) : MNS_OK;
}

bool run_keep(Run *run, Order *order)
{
    if (!run->uncommitted && !run->unsaid && !run->withheld) return false;
    order->next = run->unsaid;
    run->unsaid = order;
    return true;
}

void run_withhold(Run *run, const Order *order)
{
    if (run->journal && !begins_anew(order)) run->withheld = true;
}

void run_close_books(Run *run)
{
    writer_drain(run->outputs.writer, NULL);
    run_answer_filed(run);
    run_commit(run);
}

/* --- before and after a command ---------------------------------------------------------------------------------------- */

MnsStatus run_journal_ready(Run *run, const Order *order, MnsError *error)
{
    if (begins_anew(order)) run_commit(run); /* it takes long, and may lead to another journal */
    const Meniscus__Request__CommandCase command = order->request->command_case;
    const bool elsewhere = command == MENISCUS__REQUEST__COMMAND_LOAD;
    const bool halts = order->appointed && command == MENISCUS__REQUEST__COMMAND_PAUSE;
    const bool rescues = run->state == RUN_FAULT && command == MENISCUS__REQUEST__COMMAND_CHECKPOINT;
    /* What halts a run is always possible, and so is what saves it. */
    if (!run->journal || order->urgent || halts || rescues || elsewhere) return MNS_OK;
    const size_t size =
        3 * meniscus__request__get_packed_size(order->request); /* itself, what it changed, what is replied */
    if (!order->motion && !begins_anew(order) && run->noted_here + size > NOTED_HERE_MAX)
        return mns_fail(
            error, MNS_E_LIMIT,
            "what was commanded at this step takes %zu bytes of the journal, and may take %d; go on by a step",
            run->noted_here, NOTED_HERE_MAX);
    return journal_reserve(run->journal, size + (run->document ? run->document->size : 0) + ROOM_BESIDES, error);
}

static MnsStatus sync_journal(Run *run, MnsError *error)
{
    const MnsError failed = run->unwritten;
    run->unwritten = (MnsError){.status = MNS_OK};
    run->uncommitted = false;
    if (!failed.status) return run->journal ? journal_commit(run->journal, error) : MNS_OK;
    *error = failed;
    return failed.status;
}

/* What changed nothing is as it was answered. */
static void tell_unwritten(Run *run, Order *order, const MnsError *why)
{
    if (order->status || !order->request || order->durable || order->rescues) return;
    const bool lease = order->request->command_case == MENISCUS__REQUEST__COMMAND_LEASE;
    order->status = mns_fail(&order->error, why->status, "%s; resume tries again: %.300s",
                             lease ? "the journal cannot be written, so the run is halted, and the lease as it was"
                                   : "it was done, but is not on the disk, so the run is halted",
                             why->text);
    order->state = run->state;
    if (order->seal) order->seal(order);
}

/* Nobody was told of it: it would be held by nobody, until it is over. */
static void take_lease_back(Run *run)
{
    MnsError error;
    run->lease = run->lease_before;
    note_lease_told(run, true, &error); /* its record may get to the disk later */
    run_publish(run);
}

/* So that a daemon that is started after a crash finds it: without that nothing is told as done. It is tried again each time. */
static MnsStatus note_current(Run *run, MnsError *error)
{
    MnsError why;
    const char *parent = run->options.parent, *directory = run->outputs.directory;
    bool same = false;
    const bool named = rundir_is_current(parent, directory, run->options.asked, &same);
    run->current_due = !same && rundir_note_current(parent, directory, run->options.asked, &why);
    if (!run->current_due || named) return MNS_OK; /* it is found as it is */
    rundir_forget_current(parent);                 /* else a crash would lead back to the run before this one */
    return mns_fail(error, why.status, "a daemon that is started after a crash would not find the run: %.300s",
                    why.text);
}

void run_sync(Run *run)
{
    MnsError error;
    if (!run->uncommitted) return;
    const double began = clock_now();
    MnsStatus status = sync_journal(run, &error);
    if (!status && run->current_due) status = note_current(run, &error);
    if (!status && run->lease_unsettled) status = note_lease_told(run, false, &error);
    run->journal_tally.seconds += clock_now() - began;
    run->journal_tally.failures += status != MNS_OK;
    for (Order *order = run->unsaid; order && !status; order = order->next) order->durable = true;
    if (status && run->lease_unsettled) take_lease_back(run);
    run->lease_unsettled = false;
    if (!status) return;
    if (run->sim && run->state != RUN_FAULT) run_fault(run, &error, true);
    for (Order *order = run->unsaid; order; order = order->next) tell_unwritten(run, order, &error);
}

void run_release(Run *run)
{
    Order *first = NULL;
    for (Order *order = run->unsaid, *next; order; order = next) { /* in the order in which they were answered */
        next = order->next;
        order->next = first;
        first = order;
    }
    run->unsaid = NULL;
    for (Order *order = first, *next; order; order = next) {
        next = order->next;
        run_hand_back(run, order);
    }
}

void run_commit(Run *run)
{
    run_sync(run);
    run_reveal(run);
    if (run_announces(run)) run_announce(run);
    run_release(run);
}
