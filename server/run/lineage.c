/* SPDX-License-Identifier: BSD-3-Clause */
/* The way to where a run was. */
#include "run/lineage.h"

#include "common/case/name.h"
#include "run/order.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef Meniscus__JournalRecord Record;

static MnsStatus fail_memory(MnsError *error)
{
    return mns_fail(error, MNS_E_MEMORY, "no memory for the journal");
}

static MnsStatus note_waiting(Lineage *lineage, size_t k, MnsError *error)
{
    size_t *waiting = reallocarray(lineage->waiting, lineage->n_waiting + 1, sizeof *waiting);
    if (!waiting) return fail_memory(error);
    lineage->waiting = waiting;
    waiting[lineage->n_waiting++] = k;
    return MNS_OK;
}

static MnsStatus add(Lineage *lineage, LineageEntry entry, MnsError *error)
{
    if (lineage->n == lineage->room) {
        const size_t room = 2 * lineage->room + 16;
        LineageEntry *entries = reallocarray(lineage->entries, room, sizeof *entries);
        if (!entries) return fail_memory(error);
        lineage->entries = entries;
        lineage->room = room;
    }
    lineage->entries[lineage->n++] = entry;
    const bool waits = entry.scheduled && entry.request && entry.until == UINT64_MAX;
    return waits ? note_waiting(lineage, lineage->n - 1, error) : MNS_OK;
}

static bool is_command(const LineageEntry *entry, Meniscus__Request__CommandCase command)
{
    return entry->request && entry->request->command_case == command;
}

static bool is_motion(const Meniscus__Request *request)
{
    return request->command_case == MENISCUS__REQUEST__COMMAND_STEP ||
           request->command_case == MENISCUS__REQUEST__COMMAND_RUN_UNTIL;
}

bool lineage_is_limit(const Meniscus__Request *request)
{
    return !request || is_motion(request);
}

bool lineage_sets_out(const Meniscus__Request *request)
{
    if (!request) return false;
    const Meniscus__Request__CommandCase command = request->command_case;
    return is_motion(request) || command == MENISCUS__REQUEST__COMMAND_START ||
           command == MENISCUS__REQUEST__COMMAND_RESUME;
}

static bool is_limit(const LineageEntry *entry)
{
    return !entry->adopted && !entry->scheduled && lineage_is_limit(entry->request);
}

/* What was done from this step on belongs to another time line, and so does all that was under way or scheduled; breakpoints are gone. */
static void cut(Lineage *lineage, uint64_t step)
{
    size_t n = 0;
    for (size_t k = 0; k < lineage->n; k++) {
        LineageEntry *entry = &lineage->entries[k];
        if (entry->scheduled && entry->until > step) entry->until = step;
        const bool gone = is_command(entry, MENISCUS__REQUEST__COMMAND_BREAKPOINT) || entry->step >= step;
        if (!gone) lineage->entries[n++] = *entry;
    }
    lineage->n = n;
    lineage->n_waiting = 0; /* all are dropped */
    lineage->begun = NULL;
    lineage->broken = NULL;
}

static MnsStatus begin_anew(Lineage *lineage, const Record *record, MnsError *error)
{
    const bool back = history_goes_back(record), first = !back || !lineage->original;
    cut(lineage, back ? record->step : 0);
    if (first) lineage->first_version = record->case_version;
    if (first) lineage->brought = back;
    lineage->arithmetic = record->arithmetic;
    /* Of a directory with nothing but a checkpoint the first load goes back already. */
    if (first && record->request->command_case == MENISCUS__REQUEST__COMMAND_LOAD) {
        const char *name = record->request->load->name;
        lineage->name = name ? name : CASE_NAMELESS;
        lineage->original = record->case_;
    }
    /* A checkpoint that a crash has led back to is no version: what follows makes the case as it was. */
    const LineageEntry adopted = {.step = record->step,
                                  .adopted = record->case_,
                                  .version = record->comeback ? 0 : record->case_version,
                                  .anew = true};
    MnsStatus status = back ? add(lineage, (LineageEntry){.step = record->step}, error) : MNS_OK;
    if (back && !status) status = add(lineage, adopted, error);
    for (size_t k = 0; !status && k < record->n_again; k++) {
        const Meniscus__Again *again = record->again[k];
        if (again->scheduled && !again->request) continue; /* nothing waits */
        status = add(lineage,
                     (LineageEntry){.step = again->step,
                                    .request = again->request,
                                    .adopted = again->adopted,
                                    .version = again->case_version,
                                    .anew = again->anew,
                                    .scheduled = again->scheduled,
                                    .until = again->has_until_step ? again->until_step : UINT64_MAX,
                                    .who = again->who},
                     error);
    }
    return status;
}

static void take_grant(Lineage *lineage, const Record *record, const Meniscus__LeaseGrant *grant)
{
    if (!grant) return;
    lineage->lease.epoch = grant->epoch;
    lineage->lease.holder = grant->holder;
    lineage->lease.ttl_ms = grant->ttl_ms < LEASE_MS_MAX ? grant->ttl_ms : LEASE_MS_MAX;
    lineage->lease.until_us = record->wall_us + 1000 * lineage->lease.ttl_ms;
}

static void take_lease(Lineage *lineage, const Record *record)
{
    if (record->request->lease->release) lineage->lease.until_us = 0;
    const bool granted = record->reply && record->reply->result_case == MENISCUS__REPLY__RESULT_LEASE;
    take_grant(lineage, record, granted ? record->reply->lease : NULL);
}

static bool same_id(const Meniscus__Request *a, const Meniscus__Request *b)
{
    return a->id.len == ORDER_ID && b->id.len == ORDER_ID && !memcmp(a->id.data, b->id.data, ORDER_ID);
}

/* A scheduled command was done or dropped. False if it is none. */
static bool end_scheduled(Lineage *lineage, const Record *record, uint64_t step)
{
    for (size_t k = 0; k < lineage->n_waiting; k++) {
        LineageEntry *entry = &lineage->entries[lineage->waiting[k]];
        if (!same_id(entry->request, record->request)) continue;
        entry->until = step;
        lineage->n_waiting--;
        memmove(&lineage->waiting[k], &lineage->waiting[k + 1], (lineage->n_waiting - k) * sizeof *lineage->waiting);
        return true;
    }
    return false;
}

static void come_to(Lineage *lineage, const Record *record)
{
    if (record->step > lineage->step) lineage->step = record->step;
}

/* A breakpoint or an output that failed has halted the run, of which no record tells. */
static void halt(Lineage *lineage, RunState state)
{
    if (state == RUN_READY || state == RUN_PAUSED || state == RUN_DONE) lineage->state = state;
}

/* What was under way has ended, also where the program was leaving; in FAULT nothing else has; on the way back it was called off, or the
 * run was to go on. */
static RunState state_after(const Lineage *lineage, const Record *record)
{
    const Meniscus__Request *request = record->request;
    const RunState state = record->reply ? (RunState)record->reply->state : RUN_PAUSED;
    if (is_motion(request)) return state == RUN_DONE ? RUN_DONE : RUN_PAUSED;
    if (state == RUN_FAULT) return lineage->state;
    if (state != RUN_RECOVERING) return state;
    return request->command_case == MENISCUS__REQUEST__COMMAND_RESUME ? RUN_RUNNING : RUN_PAUSED;
}

/* A file takes its time, and the record comes behind those of later steps. */
static MnsStatus insert(Lineage *lineage, LineageEntry entry, MnsError *error)
{
    const MnsStatus status = add(lineage, entry, error);
    if (status) return status;
    size_t k = lineage->n - 1;
    for (; k > 0 && lineage->entries[k - 1].step > entry.step; k--) lineage->entries[k] = lineage->entries[k - 1];
    lineage->entries[k] = entry;
    for (size_t w = 0; w < lineage->n_waiting; w++)
        if (lineage->waiting[w] >= k) lineage->waiting[w]++;
    return MNS_OK;
}

/* That of a run that has diverged shows what comes of it once more by itself. */
static MnsStatus take_snapshot(Lineage *lineage, const Record *record, MnsError *error)
{
    const bool broken = record->has_broken && record->broken;
    if (broken || !history_done_well(record) || !record->reply || !record->reply->has_effect_step) return MNS_OK;
    return insert(lineage, (LineageEntry){.step = record->reply->effect_step, .request = record->request}, error);
}

/* A command that was done, or a step or run_until that ended, well or not. */
static MnsStatus take_command(Lineage *lineage, const Record *record, MnsError *error)
{
    const Meniscus__Request *request = record->request;
    /* What came on the way back had effect where the run was. */
    const uint64_t step = record->step > lineage->step ? record->step : lineage->step;
    LineageEntry entry = {.step = step, .request = request};
    if (end_scheduled(lineage, record, step) && !history_done_well(record)) {
        come_to(lineage, record); /* its time has shortened a step all the same */
        if (record->reply) halt(lineage, (RunState)record->reply->state);
        return MNS_OK;
    }
    lineage->state = state_after(lineage, record);
    if (is_motion(request)) lineage->broken = record->has_broken && record->broken ? request : NULL;
    else if (record->reply && (RunState)record->reply->state != RUN_FAULT) lineage->broken = NULL;
    come_to(lineage, record); /* it may have been commanded on the way back */
    lineage->untouched = false;
    switch (request->command_case) {
    case MENISCUS__REQUEST__COMMAND_STOP:
    case MENISCUS__REQUEST__COMMAND_SHUTDOWN: lineage->ended = true; return MNS_OK;
    case MENISCUS__REQUEST__COMMAND_SET: entry.version = record->case_version; return add(lineage, entry, error);
    case MENISCUS__REQUEST__COMMAND_START:
    case MENISCUS__REQUEST__COMMAND_RESUME:
    case MENISCUS__REQUEST__COMMAND_BREAKPOINT: return add(lineage, entry, error);
    case MENISCUS__REQUEST__COMMAND_ROLLBACK:
        entry = (LineageEntry){.step = step, .adopted = record->case_, .version = record->case_version};
        return add(lineage, entry, error);
    case MENISCUS__REQUEST__COMMAND_LEASE: take_lease(lineage, record); return MNS_OK;
    case MENISCUS__REQUEST__COMMAND_SNAPSHOT: return take_snapshot(lineage, record, error);
    default: break;
    }
    if (!is_motion(request)) return MNS_OK;
    lineage->begun = NULL;
    return add(lineage, (LineageEntry){.step = step}, error); /* its limit is gone */
}

/* A load after a crash: the run is where it was only when all is done again, and another crash may come before that. */
static MnsStatus take_comeback(Lineage *lineage, const Record *record, MnsError *error)
{
    const Lineage before = *lineage;
    const MnsStatus status = begin_anew(lineage, record, error);
    lineage->state = before.state;
    lineage->broken = before.broken;
    lineage->step = before.step;
    lineage->begun = before.begun;
    lineage->begun_step = before.begun_step;
    lineage->name = before.name;
    lineage->original = before.original;
    lineage->first_version = before.first_version;
    return status;
}

static MnsStatus take_scheduled(Lineage *lineage, const Record *record, MnsError *error)
{
    const LineageEntry entry = {
        .step = record->step, .request = record->request, .scheduled = true, .until = UINT64_MAX, .who = record->who};
    lineage->untouched = false;
    lineage->step = record->step;
    if (record->has_state) halt(lineage, (RunState)record->state);
    return add(lineage, entry, error);
}

static MnsStatus take(Lineage *lineage, const Record *record, MnsError *error)
{
    if (record->kind == MENISCUS__JOURNAL_RECORD__KIND__SCHEDULED && record->request)
        return take_scheduled(lineage, record, error);
    if (record->kind == MENISCUS__JOURNAL_RECORD__KIND__BEGUN && record->request) {
        /* After a crash it counts from where it began. */
        const bool goes_on = lineage->begun && same_id(lineage->begun, record->request);
        if (!goes_on) lineage->begun_step = record->step;
        lineage->begun = record->request;
        lineage->state = RUN_RUNNING;
        lineage->step = record->step;
        lineage->untouched = false;
        return add(lineage, (LineageEntry){.step = record->step, .request = record->request}, error);
    }
    if (record->kind == MENISCUS__JOURNAL_RECORD__KIND__HALTED) {
        come_to(lineage, record);
        if (record->has_state) halt(lineage, (RunState)record->state);
        return MNS_OK;
    }
    if (record->kind != MENISCUS__JOURNAL_RECORD__KIND__COMMAND || !record->request) return MNS_OK;
    if (record->comeback && !record->case_) return MNS_OK; /* a shutdown that ends no run */
    if (!history_begins(record)) return take_command(lineage, record, error);
    if (record->comeback) return take_comeback(lineage, record, error);
    take_grant(lineage, record, record->lease);
    lineage->ended = false;
    lineage->untouched = record->request->command_case == MENISCUS__REQUEST__COMMAND_LOAD && record->who &&
                         record->who->name && !strcmp(record->who->name, WHO_DAEMON);
    lineage->state = RUN_READY;
    lineage->step = record->step;
    return begin_anew(lineage, record, error);
}

/* So that no step on the way back looks at all entries. */
static MnsStatus list_timed(Lineage *lineage, MnsError *error)
{
    lineage->timed = calloc(lineage->n + 1, sizeof *lineage->timed);
    if (!lineage->timed) return fail_memory(error);
    for (size_t k = 0; k < lineage->n; k++)
        if (lineage->entries[k].scheduled && lineage->entries[k].request && lineage->entries[k].request->has_at_time)
            lineage->timed[lineage->n_timed++] = k;
    return MNS_OK;
}

MnsStatus lineage_of(const History *history, const char *boot, Lineage *ret, MnsError *error)
{
    MnsStatus status = MNS_OK;
    *ret = (Lineage){.n = 0};
    for (size_t k = 0; !status && k < history->n; k++) {
        const LineageLease before = ret->lease;
        status = take(ret, history->records[k].message, error);
        if (history_untold(history, k, boot)) ret->lease = before;
    }
    if (!status && !ret->original)
        return mns_fail(error, MNS_E_STATE, "the journal has no load that could be gone back to");
    if (!status && ret->ended) return mns_fail(error, MNS_E_STATE, "the run was ended");
    return status ? status : list_timed(ret, error);
}

void lineage_done(Lineage *lineage)
{
    free(lineage->entries);
    free(lineage->waiting);
    free(lineage->timed);
    *lineage = (Lineage){.n = 0};
}

/* Of what ended up to the checkpoint only the last says anything; what set out there has outputs and conditions. */
static bool is_past(const Lineage *lineage, size_t k, uint64_t checkpoint)
{
    for (size_t next = k + 1; next < lineage->n && lineage->entries[next].step <= checkpoint; next++)
        if (is_limit(&lineage->entries[next])) return true;
    return false;
}

double lineage_lease_left(const Lineage *lineage, double wall)
{
    return fmin(1e-6 * (double)lineage->lease.until_us - wall, 1e-3 * (double)lineage->lease.ttl_ms);
}

double lineage_limit(const Lineage *lineage, uint64_t step, double t)
{
    double limit = INFINITY;
    for (size_t k = 0; k < lineage->n_timed; k++) {
        const LineageEntry *entry = &lineage->entries[lineage->timed[k]];
        const bool holds = entry->step <= step && step < entry->until;
        if (holds && entry->request->at_time > t) limit = fmin(limit, entry->request->at_time);
    }
    return limit;
}

bool lineage_is_breakpoint(const LineageEntry *entry)
{
    return is_command(entry, MENISCUS__REQUEST__COMMAND_BREAKPOINT);
}

bool lineage_needs(const Lineage *lineage, size_t k, uint64_t checkpoint)
{
    const LineageEntry *entry = &lineage->entries[k];
    if (entry->scheduled)
        return entry->until == UINT64_MAX || (entry->until > checkpoint && entry->request->has_at_time);
    /* The case of a checkpoint that a crash had led back to: what is done again leads there too. */
    if (entry->adopted && entry->anew && !entry->version) return false;
    const bool before = entry->step < checkpoint || (entry->step == checkpoint && !entry->request);
    if (is_limit(entry) && before) return !is_past(lineage, k, checkpoint);
    return is_command(entry, MENISCUS__REQUEST__COMMAND_BREAKPOINT) || entry->step >= checkpoint;
}
