/* SPDX-License-Identifier: BSD-3-Clause */
/* Changes of a run under way: entries of its case, breakpoints, outputs on demand. */
#include "run/inside.h"

#include "base/clock.h"
#include "base/log.h"
#include "common/host/text.h"
#include "run/unknown.h"
#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>
#include <time.h>

/* Nothing is asked to end in the past. */
static MnsStatus check_end(const Run *run, const Document *document, MnsError *error)
{
    const double t = mns_sim_progress(run->sim).t, end = document->c->end_time;
    if (end >= t) return MNS_OK;
    return mns_fail_at(error, MNS_E_INVALID, "end_time",
                       "the end time must not lie before the present time, %.9g s; found %.9g", t, end);
}

static void tell_changes(Run *run, const Meniscus__Set *set)
{
    for (size_t k = 0; k < set->n_assignments; k++) {
        char text[512];
        snprintf(text, sizeof text, "%.200s = %.200s", set->assignments[k]->path, set->assignments[k]->value);
        run_tell(run, NOTE_EVENT, LOG_INFORMATION, "set", text);
    }
}

/* Go over to a document, which is taken over. ret_before: the one until now, to be left; may be NULL. */
static MnsStatus adopt(Run *run, Document *document, Document **ret_before, MnsError *error)
{
    MnsStatus status = check_end(run, document, error);
    if (!status) status = mns_sim_steer(run->sim, document->c, error);
    if (status) {
        document_leave(document);
        return status;
    }
    if (ret_before) *ret_before = run->document;
    else document_leave(run->document);
    run->document = document;
    /* Rates may be those of the new case, and the rest of the state is the same. */
    if (run->hashed && mns_sim_hash(run->sim) != run->hash) run->hashed = false;
    tap_renew(run->tap, run->sim);
    if (run->state != RUN_RECOVERING) versions_add(&run->versions, document);
    run_publish(run);
    return MNS_OK;
}

/* Go over to a document, which is taken over. */
static MnsStatus change(Run *run, Order *order, Document *document, MnsError *error)
{
    const MnsStatus status = adopt(run, document, &run->before, error);
    if (status) return status;
    order->document = document_share(document);
    order->threads = (unsigned)mns_sim_threads(run->sim);
    return MNS_OK;
}

/* Was it a formula of gravity that the run stands for, and is it another one now? */
static bool mends(const Run *run)
{
    const MnsCase *old = run->before->c, *now = run->document->c;
    bool changed = false;
    if (run->state != RUN_FAULT || run->output_failed || run_is_broken(run)) return false;
    for (int d = 0; d < now->dim; d++) changed = changed || strcmp(old->gravity[d], now->gravity[d]) != 0;
    return changed && strncmp(run->fault.path, "gravity", 7) == 0;
}

/* Answer an order that was to change the case. */
static void answer_change(Run *run, Order *order, MnsStatus status, const MnsError *error)
{
    if (!status && run->state == RUN_DONE && mns_sim_progress(run->sim).t < run->document->c->end_time)
        run_enter(run, RUN_PAUSED, "the end time was moved");
    if (!status && mends(run)) run_enter(run, RUN_PAUSED, "the formula that failed was changed");
    run_answer(run, order, status, error);
    document_leave(run->before);
    run->before = NULL;
}

/* What is changed in a run that cannot be gone on with would be of no use, and a way back to there would go another way. */
static MnsStatus check_whole(const Run *run, MnsError *error)
{
    return run->state == RUN_FAULT && run_is_broken(run) ? run_refuse_broken(run, error) : MNS_OK;
}

void run_set(Run *run, Order *order, const Meniscus__Set *set)
{
    MnsError error;
    Document *document;
    MnsStatus status = check_whole(run, &error);
    if (!status) status = document_set(run->document, set, &document, &error);
    if (!status) status = change(run, order, document, &error);
    if (!status) tell_changes(run, set);
    answer_change(run, order, status, &error);
}

/* Could the run go over to it, if it were now? */
static MnsStatus check_document(const Run *run, const Document *document, MnsError *error)
{
    const MnsStatus status = check_end(run, document, error);
    return status ? status : mns_sim_check_steer(run->sim, document->c, error);
}

MnsStatus run_check_set(const Run *run, const Meniscus__Set *set, MnsError *error)
{
    Document *document;
    MnsStatus status = document_set(run->document, set, &document, error);
    if (status) return status;
    status = check_document(run, document, error);
    document_leave(document);
    return status;
}

MnsStatus run_check_rollback(const Run *run, uint64_t version, MnsError *error)
{
    Document *document;
    const MnsStatus status = versions_find(&run->versions, version, &document, error);
    return status ? status : check_document(run, document, error);
}

void run_rollback(Run *run, Order *order, uint64_t version)
{
    MnsError error;
    char text[64];
    Document *document;
    MnsStatus status = check_whole(run, &error);
    if (!status) status = versions_find(&run->versions, version, &document, &error);
    if (!status) status = change(run, order, document_share(document), &error);
    snprintf(text, sizeof text, "to version %" PRIu64, version);
    if (!status) run_tell(run, NOTE_EVENT, LOG_INFORMATION, "rollback", text);
    answer_change(run, order, status, &error);
}

MnsStatus run_set_again(Run *run, const Meniscus__Set *set, MnsError *error)
{
    Document *document;
    const MnsStatus status = document_set(run->document, set, &document, error);
    return status ? status : adopt(run, document, NULL, error);
}

MnsStatus run_adopt_again(Run *run, const Meniscus__Case *message, MnsError *error)
{
    Document *document;
    const MnsStatus status = document_new(message, run->document->name, &document, error);
    return status ? status : adopt(run, document, NULL, error);
}

/* What the case became with an entry of a lineage. */
static MnsStatus after_entry(const Document *old, const LineageEntry *entry, Document **ret, MnsError *error)
{
    if (entry->adopted) return document_new(entry->adopted, old->name, ret, error);
    return document_set(old, entry->request->set, ret, error);
}

/* The entry that led to the first version of those that are kept; the number of all where that is the original. */
static size_t first_kept(const Lineage *lineage)
{
    size_t n = 0;
    for (size_t k = lineage->n; k > 0; k--) {
        const LineageEntry *entry = &lineage->entries[k - 1];
        n += entry->version > 0;
        if (entry->version && (entry->anew || n == VERSIONS_KEPT)) return k - 1;
    }
    return lineage->n;
}

/* The case as it was before entry `end`. What is not kept of it is only read, not made a case of: there may be very much. */
static MnsStatus find_before(Run *run, const Lineage *lineage, size_t end, Document **ret, MnsError *error)
{
    const Meniscus__Case *base = lineage->original;
    Meniscus__Case *last = NULL;
    size_t begin = 0;
    MnsStatus status = MNS_OK;
    for (size_t k = 0; k < end; k++)
        if (lineage->entries[k].version && lineage->entries[k].adopted) {
            base = lineage->entries[k].adopted;
            begin = k + 1;
        }
    for (size_t k = begin; !status && k < end; k++) {
        Meniscus__Case *next;
        if (!lineage->entries[k].version) continue;
        run_beat(run);
        status = document_assign(last ? last : base, lineage->entries[k].request->set, &next, error);
        if (status) break;
        if (last) meniscus__case__free_unpacked(last, NULL);
        last = next;
    }
    if (!status) status = document_new(last ? last : base, run->document->name, ret, error);
    if (last) meniscus__case__free_unpacked(last, NULL);
    return status;
}

MnsStatus run_remember(Run *run, const Lineage *lineage, MnsError *error)
{
    Document *last;
    const size_t first = first_kept(lineage);
    const bool all = first == lineage->n;
    MnsStatus status = find_before(run, lineage, all ? 0 : first, &last, error);
    if (status) return status;
    if (all) versions_begin(&run->versions, lineage->first_version, last);
    for (size_t k = all ? 0 : first; !status && k < lineage->n; k++) {
        const LineageEntry *entry = &lineage->entries[k];
        Document *next;
        if (!entry->version) continue;
        run_beat(run);
        status = after_entry(last, entry, &next, error);
        if (status) break;
        if (k == first || entry->anew) versions_begin(&run->versions, entry->version, next);
        else versions_add(&run->versions, next);
        document_leave(last);
        last = next;
    }
    document_leave(last);
    return status;
}

void run_lease(Run *run, Order *order, const LeaseWish *wish)
{
    MnsError error;
    char text[160];
    struct timespec today;
    clock_gettime(CLOCK_REALTIME, &today);
    /* So that epochs rise where no journal has the last one, and a daemon may have begun within the same second: milliseconds. */
    const uint64_t least = 1000 * (uint64_t)today.tv_sec + (uint64_t)today.tv_nsec / 1000000;
    const Lease before = run->lease;
    const MnsStatus status = lease_take(&run->lease, wish, least, clock_now(), &error);
    if (!status) {
        if (run->journal && !run->lease_unsettled) run->lease_before = before;
        run->lease_unsettled = run->journal != NULL;
        if (!wish->release) order->lease = run->lease;
        snprintf(text, sizeof text, wish->release ? "%s has given it back" : "%s has it for %.1f s", run->lease.holder,
                 1e-3 * (double)run->lease.ttl_ms);
        run_publish(run);
        run_tell(run, NOTE_EVENT, LOG_INFORMATION, "lease", text);
    }
    run_answer(run, order, status, &error);
}

/* Of one that is new: what has been passed never comes. */
static MnsStatus check_breakpoint(MnsProgress now, const Breakpoint *point, MnsError *error)
{
    const MnsStatus status = text_name_check(point->name, "name", error);
    if (status) return status;
    if (point->t <= now.t)
        return mns_fail_at(error, MNS_E_INVALID, "time", "a breakpoint at %.9g s would never be reached: it is %.9g s",
                           point->t, now.t);
    if (point->step && point->step <= now.step)
        return mns_fail_at(error, MNS_E_INVALID, "step",
                           "a breakpoint at step %" PRIu64 " would never be reached: the run is at step %" PRIu64,
                           point->step, now.step);
    return MNS_OK;
}

static MnsStatus read_breakpoint(const Meniscus__SetBreakpoint *from, Breakpoint *ret, MnsError *error)
{
    const char *name = from->name ? from->name : "", *condition = from->condition ? from->condition : "";
    *ret = (Breakpoint){.t = from->has_time ? from->time : NAN, .step = from->has_step ? from->step : 0};
    if (strlen(name) >= sizeof ret->name || strlen(condition) >= sizeof ret->condition)
        return mns_fail(error, MNS_E_INVALID,
                        "the name of a breakpoint has fewer than %d letters, its condition fewer than %d",
                        BREAKPOINT_NAME, BREAKPOINT_TEXT);
    memcpy(ret->name, name, strlen(name));
    memcpy(ret->condition, condition, strlen(condition));
    return MNS_OK;
}

static bool removes(const Meniscus__SetBreakpoint *request)
{
    return request->has_remove && request->remove;
}

static MnsStatus set_breakpoint(Run *run, const Meniscus__SetBreakpoint *request, const Breakpoint *point,
                                MnsError *error)
{
    const MnsStatus status = removes(request) ? breakpoints_remove(run->breakpoints, point->name, error)
                                              : breakpoints_set(run->breakpoints, run->document->c, point, error);
    if (!status) run_publish(run);
    return status;
}

void run_breakpoint_again(Run *run, const Meniscus__SetBreakpoint *request, uint64_t step)
{
    Breakpoint point;
    if (read_breakpoint(request, &point, NULL) || set_breakpoint(run, request, &point, NULL)) return;
    if (step < mns_sim_progress(run->sim).step) breakpoints_note(run->breakpoints, point.name, run->sim);
}

void run_breakpoint(Run *run, Order *order, const Meniscus__SetBreakpoint *request)
{
    MnsError error;
    Breakpoint point;
    MnsStatus status = read_breakpoint(request, &point, &error);
    if (!status && !removes(request)) status = check_breakpoint(mns_sim_progress(run->sim), &point, &error);
    if (!status) status = set_breakpoint(run, request, &point, &error);
    run_answer(run, order, status, &error);
}

/* The journal tells what came of it before the run goes on, so the solver waits for the file. It is the only one that the writer had to do,
 * see run.c. */
static void after_scheduled_output(Run *run, Order *order)
{
    MnsError failed;
    const MnsStatus status = writer_drain(run->outputs.writer, &failed);
    assert(order->filed);
    run_answer(run, order, order->status, &order->error);
    if (status) run_fault(run, &failed, true);
}

/* The order is with the writer unless there was no memory for the copy; it may be answered and gone by now, unless it was scheduled. A
 * failure of the file comes up at the next boundary, or here if the run stands still. */
static void after_output(Run *run, Order *order, bool scheduled, MnsStatus status, const MnsError *error)
{
    MnsError failed;
    if (status) run_answer(run, order, status, error);
    else if (scheduled) after_scheduled_output(run, order);
    else if (run->state != RUN_RUNNING && run->state != RUN_FAULT && writer_drain(run->outputs.writer, &failed))
        run_fault(run, &failed, true);
}

void run_checkpoint(Run *run, Order *order)
{
    const bool scheduled = order->scheduled;
    MnsError error;
    MnsStatus status;
    if (run->state == RUN_FAULT &&
        run->output_failed) { /* a file of its own: it need not wait for the one that failed, nor for the journal */
        order->rescues = true;
        status = outputs_rescue(&run->outputs, run->sim, run->document, order->path, &error);
        run_answer(run, order, status, &error);
        return;
    }
    if (run->state == RUN_FAULT &&
        run_is_broken(run)) /* it would be the newest, and whoever goes on from the newest would diverge again */
        status = mns_fail(&error, MNS_E_STATE,
                          "%s, and nobody could go on from a checkpoint of that; a snapshot shows the state: %.300s",
                          run_broken_why(run), run->fault.text);
    else status = outputs_checkpoint(&run->outputs, run->sim, run->document, order, &error);
    after_output(run, order, scheduled, status, &error);
}

static MnsStatus find_fields(size_t n, char *const *fields, uint64_t *ret, MnsError *error)
{
    for (size_t k = 0; k < n; k++) {
        const int field = mns_field_find(fields[k]);
        if (field < 0) return unknown_field("fields", fields[k], UINT64_MAX, error);
        *ret |= (uint64_t)1 << field;
    }
    return MNS_OK;
}

MnsStatus run_check_fields(size_t n, char *const *fields, MnsError *error)
{
    uint64_t mask = 0;
    return find_fields(n, fields, &mask, error);
}

MnsStatus run_snapshot_again(Run *run, const Meniscus__SnapshotNow *request, bool there, MnsError *error)
{
    uint64_t mask = 0;
    const MnsStatus status = find_fields(request->n_fields, request->fields, &mask, error);
    if (status) return status;
    if (!there) return outputs_snapshot(&run->outputs, run->sim, run->document, mask, NULL, error);
    outputs_know_snapshot(&run->outputs, mns_sim_progress(run->sim).step, mask);
    return MNS_OK;
}

void run_snapshot(Run *run, Order *order, size_t n, char *const *fields)
{
    const bool scheduled = order->scheduled;
    MnsError error;
    uint64_t mask = 0;
    MnsStatus status = find_fields(n, fields, &mask, &error);
    if (!status && run->state == RUN_FAULT && run->output_failed)
        status = mns_fail(&error, MNS_E_STATE, "an earlier output waits to be written; resume first: %.300s",
                          run->fault.text);
    if (!status) status = outputs_snapshot(&run->outputs, run->sim, run->document, mask, order, &error);
    after_output(run, order, scheduled, status, &error);
}
