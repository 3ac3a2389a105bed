/* SPDX-License-Identifier: BSD-3-Clause */
/* Back to where a run was before a crash: from its newest whole checkpoint, with all that was commanded since, at the steps at
 * which it was. Between two steps the runner serves who may not be kept waiting, see run.c; all others wait in the mailbox. */
#include "run/inside.h"

#include "base/clock.h"
#include "base/log.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static const double TURN = 0.05; /* [s] between two looks at who has no time for all this */

static bool is_snapshot(const Meniscus__Request *request)
{
    return request && request->command_case == MENISCUS__REQUEST__COMMAND_SNAPSHOT;
}

/* At the checkpoint's own step it is there, if there is a checkpoint. */
static bool is_there(const Run *run, const LineageEntry *entry)
{
    return entry->step == run->recovery.checkpoint && entry->step > 0;
}

/* The outputs of a boundary at which the run set out, as of the first. */
static MnsStatus set_out_again(Run *run, MnsError *error)
{
    if (!outputs_behind(&run->outputs, mns_sim_progress(run->sim).t)) return MNS_OK;
    return outputs_take(&run->outputs, run->sim, run->document, error);
}

static MnsStatus do_again(Run *run, const LineageEntry *entry, double *limit, MnsError *error)
{
    const Meniscus__Request *request = entry->request;
    if (entry->scheduled) return MNS_OK; /* it shortens steps, and what came of it is an entry of its own */
    if (entry->adopted) return run_adopt_again(run, entry->adopted, error);
    if (request && request->command_case == MENISCUS__REQUEST__COMMAND_SET)
        return run_set_again(run, request->set, error);
    if (request && request->command_case == MENISCUS__REQUEST__COMMAND_BREAKPOINT) {
        run_breakpoint_again(run, request->breakpoint, entry->step);
        return MNS_OK;
    }
    if (is_snapshot(request)) return run_snapshot_again(run, request->snapshot, is_there(run, entry), error);
    const bool exact =
        request && request->command_case == MENISCUS__REQUEST__COMMAND_RUN_UNTIL && request->run_until->exact;
    if (lineage_is_limit(request)) *limit = exact ? request->run_until->time : INFINITY;
    const MnsStatus status = lineage_sets_out(request) ? set_out_again(run, error) : MNS_OK;
    /* To the present time no step is taken, but conditions are looked at. */
    const MnsProgress now = mns_sim_progress(run->sim);
    const bool until = request && request->command_case == MENISCUS__REQUEST__COMMAND_RUN_UNTIL;
    if (until && request->run_until->time <= now.t) (void)breakpoints_reached(run->breakpoints, run->sim, now);
    return status;
}

/* What was commanded up to this step, as much of it as a turn has time for: there may be very much, and somebody who wants the run ended.
 * *ret_all: that is all of it; *ret_output: what failed is a file. */
static MnsStatus do_some_again(Run *run, uint64_t step, bool *ret_all, bool *ret_output, MnsError *error)
{
    Recovery *recovery = &run->recovery;
    const Lineage *lineage = recovery->lineage;
    const double until = clock_now() + TURN;
    MnsStatus status = MNS_OK;
    *ret_all = false;
    while (!status && !*ret_all && clock_now() < until) {
        *ret_all = recovery->next == lineage->n || lineage->entries[recovery->next].step > step;
        if (*ret_all) break;
        run_beat(run);
        const LineageEntry *entry = &lineage->entries[recovery->next];
        if (lineage_needs(lineage, recovery->next, recovery->checkpoint))
            status = do_again(run, entry, &recovery->limit, error);
        *ret_output = is_snapshot(entry->request) || lineage_sets_out(entry->request);
        recovery->next += !status;
    }
    return status;
}

static MnsStatus step_again(Run *run, bool *ret_output, MnsError *error)
{
    const double end = run->document->c->end_time;
    const MnsProgress now = mns_sim_progress(run->sim);
    const double limit = fmin(run->recovery.limit, lineage_limit(run->recovery.lineage, now.step, now.t));
    if (now.t >= end)
        return mns_fail(error, MNS_E_INTERNAL, "the end time was reached before step %" PRIu64 " of the journal",
                        run->recovery.lineage->step);
    const MnsStatus status = run_step_once(run, fmin(limit, end), ret_output, error);
    if (!status) (void)breakpoints_reached(run->breakpoints, run->sim, now); /* whom they halted has gone on */
    return status;
}

/* Of a file that cannot be written the rest of the way is kept, for when there is room. */
static void fail(Run *run, const MnsError *error, bool output)
{
    MnsError why = *error;
    if (output)
        mns_fail(&why, error->status, "%.400s. The run is not back where it was before the crash; resume goes on",
                 error->text);
    else run->recovery.lineage = NULL;
    run->astray = true;
    run_hash(run);
    run_fault(run, &why, output);
}

bool run_is_held_up(const Run *run)
{
    return run->state == RUN_FAULT && run->recovery.lineage;
}

void run_hold(Run *run, Order *order)
{
    Order **end = &run->recovery.held;
    while (*end) end = &(*end)->next;
    order->next = NULL;
    *end = order;
}

static Order *take_held(Order **at)
{
    Order *order = *at;
    *at = order->next;
    order->next = NULL;
    return order;
}

Order *run_take_held(Run *run, const uint8_t id[static ORDER_ID])
{
    Order **at = &run->recovery.held;
    while (*at && memcmp((*at)->id, id, ORDER_ID) != 0) at = &(*at)->next;
    return *at ? take_held(at) : NULL;
}

void run_release_held(Run *run)
{
    MnsError error;
    while (run->recovery.held) {
        Order *order = take_held(&run->recovery.held);
        const MnsStatus status = mailbox_post(&run->mailbox, order, &error);
        if (status) run_answer_unserved(run, order, status, &error);
    }
}

void run_drop_held(Run *run, const char *why)
{
    MnsError error;
    mns_fail(&error, MNS_E_INTERRUPTED, "%s", why);
    while (run->recovery.held) run_answer_unserved(run, take_held(&run->recovery.held), MNS_E_INTERRUPTED, &error);
}

/* What is scheduled or was under way comes with the lineage, and waits itself. */
MnsStatus run_refuse_held_up(const Order *order, MnsError *error)
{
    switch (order->request->command_case) {
    case MENISCUS__REQUEST__COMMAND_SET:
    case MENISCUS__REQUEST__COMMAND_ROLLBACK:
    case MENISCUS__REQUEST__COMMAND_BREAKPOINT:
    case MENISCUS__REQUEST__COMMAND_CHECKPOINT:
        return mns_fail(error, MNS_E_STATE,
                        "the run is not back where it was before the crash, as a file could not be written; make room "
                        "and resume, then ask again");
    default: return MNS_OK;
    }
}

void run_recover_again(Run *run, Order *order)
{
    MnsError error;
    MnsStatus status = writer_retry(run->outputs.writer, &error);
    if (!status) {
        const Lineage *lineage = run->recovery.lineage;
        const bool rests = lineage->state == RUN_READY || lineage->state == RUN_PAUSED;
        run->astray = false;
        run_release_held(run);
        run_enter(run, RUN_RECOVERING, "going on with the way back");
        /* What was under way, or a run that was RUNNING, has an order of its own that sets it in motion; else this one does, behind all that is scheduled. */
        if (rests && !lineage->begun) {
            status = mailbox_post(&run->mailbox, order, &error);
            if (!status) return;
        }
    }
    run_answer(run, order, status, &error);
}

static void restore_lease(Run *run, const Lineage *lineage)
{
    struct timespec wall;
    clock_gettime(CLOCK_REALTIME, &wall);
    const double left = lineage_lease_left(lineage, (double)wall.tv_sec + 1e-9 * (double)wall.tv_nsec);
    const LineageLease *lease = &lineage->lease;
    run->lease = (Lease){.epoch = lease->epoch, .until = clock_now() + left, .ttl_ms = (uint32_t)lease->ttl_ms};
    if (lease->holder) snprintf(run->lease.holder, sizeof run->lease.holder, "%s", lease->holder);
}

static void arrive(Run *run)
{
    MnsError error;
    const Lineage *lineage = run->recovery.lineage;
    const RunState state = lineage->state;
    /* Rows that came after this step before the crash may be others now, if something is commanded first. */
    if (run_remember(run, lineage, &error) || outputs_begin_line(&run->outputs, &error)) {
        fail(run, &error, false);
        return;
    }
    if (outputs_settle(&run->outputs, &error)) { /* whoever is told that it is back finds its files */
        fail(run, &error, true);
        return;
    }
    run->recovery.lineage = NULL;
    outputs_flush(&run->outputs, NULL);
    run_hash(run);
    run_enter(run, state == RUN_READY || state == RUN_DONE ? state : RUN_PAUSED, "back where it was");
}

void run_recover_on(Run *run)
{
    MnsError error;
    bool output = false, all;
    const uint64_t step = mns_sim_progress(run->sim).step;
    MnsStatus status = do_some_again(run, step, &all, &output, &error);
    const bool there = !status && all && step >= run->recovery.lineage->step;
    if (!status && all && !there) status = step_again(run, &output, &error);
    if (status) fail(run, &error, output);
    else if (there) arrive(run);
    else run_tell_progress_at_times(run);
    run_show(run);
}

static void set_out(Run *run, const Lineage *lineage)
{
    const MnsProgress now = mns_sim_progress(run->sim);
    char text[128];
    run->recovery.checkpoint = now.step;
    /* The journal may end before the checkpoint, as nobody commanded anything since. */
    if (lineage->step > now.step)
        snprintf(text, sizeof text, "doing again what came after the checkpoint, to step %" PRIu64, lineage->step);
    else snprintf(text, sizeof text, "nothing is known that came after the checkpoint of step %" PRIu64, now.step);
    run_tell(run, NOTE_LOG, LOG_NOTICE, "recovering", text);
}

void run_recover(Run *run, Order *order)
{
    const Lineage *lineage = order->lineage;
    const RunLoad load = {
        .message = lineage->original, .name = lineage->name, .directory = lineage->directory, .resume = true};
    run->recovery = (Recovery){.lineage = lineage, .limit = INFINITY};
    run_load(run, order, &load);
    run_commit(run);                                          /* and from here on the order is whoever's gave it */
    if (run->state != RUN_EMPTY) restore_lease(run, lineage); /* also where the way back breaks off */
    run_publish(run);
    if (run->state == RUN_RECOVERING) set_out(run, lineage);
    else if (run->state != RUN_EMPTY) {
        run->recovery.lineage = NULL; /* the journal cannot be written */
        run->astray = true;
    }
}

void run_unread(Run *run, Order *order, const MnsError *why)
{
    if (run->state == RUN_EMPTY) run->fault = *why;
    run_publish(run);
    run_answer(run, order, MNS_OK, NULL);
}

bool run_is_unread(const Run *run)
{
    return run->state == RUN_EMPTY && run->fault.status;
}
