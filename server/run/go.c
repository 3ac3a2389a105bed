/* SPDX-License-Identifier: BSD-3-Clause */
/* The run in motion: steps, what they are to reach, what ends them. */
#include "run/inside.h"

#include "base/clock.h"
#include "base/log.h"
#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double PROGRESS_INTERVAL = 0.2; /* [s], of the notes for people */

/* --- goals and waiters ------------------------------------------------------------------------------------------------- */

void run_goal_end(Run *run, MnsStatus status, const MnsError *error)
{
    Order *order = run->goal.order;
    run->goal = (Goal){.on = false};
    if (!order) return;
    order->effect_step = mns_sim_progress(run->sim).step;
    run_answer(run, order, status, error);
}

static bool wait_over(const Run *run, const RunWait *wait)
{
    if (wait->states & (1u << run->state)) return true;
    if (!run->sim) return false;
    const MnsProgress now = mns_sim_progress(run->sim);
    return now.t >= wait->t || now.step >= wait->step;
}

/* Answer and forget the waiters for whom over() is true. */
static void answer_some(Run *run, bool (*over)(const Run *, const Waiter *, const void *), const void *arg,
                        MnsStatus status, const MnsError *error)
{
    for (Waiter **list = &run->waiters; *list;) {
        Waiter *waiter = *list;
        if (!over(run, waiter, arg)) {
            list = &waiter->next;
            continue;
        }
        *list = waiter->next;
        run_answer(run, waiter->order, status, error);
        free(waiter);
    }
}

static bool is_over(const Run *run, const Waiter *waiter, const void *arg)
{
    (void)arg;
    return wait_over(run, &waiter->wait);
}

static bool is_late(const Run *run, const Waiter *waiter, const void *arg)
{
    (void)run;
    return waiter->order->deadline < *(const double *)arg;
}

static bool has_id(const Run *run, const Waiter *waiter, const void *arg)
{
    (void)run;
    return !memcmp(waiter->order->id, arg, ORDER_ID);
}

void run_answer_waiters(Run *run)
{
    if (run->waiters) answer_some(run, is_over, NULL, MNS_OK, NULL);
}

double run_next_deadline(const Run *run)
{
    double next = run->goal.order ? run->goal.order->deadline : INFINITY;
    for (const Waiter *waiter = run->waiters; waiter; waiter = waiter->next) next = fmin(next, waiter->order->deadline);
    return next;
}

/* Pause, with an end of the goal that is not its reaching. */
static void break_off(Run *run, MnsStatus status, const char *text)
{
    MnsError error;
    mns_fail(&error, status, "%s", text);
    outputs_flush(&run->outputs, NULL);
    run_enter(run, RUN_PAUSED, text);
    run_goal_end(run, status, &error);
}

void run_expire(Run *run)
{
    const double now = clock_now();
    if (!(run_next_deadline(run) < now)) return;
    MnsError late;
    mns_fail(&late, MNS_E_TIMEOUT, "the deadline passed before what was waited for came about");
    answer_some(run, is_late, &now, MNS_E_TIMEOUT, &late);
    if (run->goal.order && run->goal.order->deadline < now)
        break_off(run, MNS_E_TIMEOUT, "paused: the deadline of the command passed before it was done");
}

void run_wait(Run *run, Order *order, const RunWait *wait)
{
    MnsError error;
    Waiter *waiter = wait_over(run, wait) ? NULL : malloc(sizeof *waiter);
    if (waiter) {
        *waiter = (Waiter){.next = run->waiters, .wait = *wait, .order = order};
        run->waiters = waiter;
    } else if (wait_over(run, wait)) run_answer(run, order, MNS_OK, NULL);
    else run_answer(run, order, mns_fail(&error, MNS_E_MEMORY, "no memory for one more who waits"), &error);
}

void run_cancel(Run *run, Order *order, const uint8_t id[static ORDER_ID])
{
    MnsError error;
    const Waiter *before = run->waiters;
    Order *queued = mailbox_remove(&run->mailbox, id);
    mns_fail(&error, MNS_E_INTERRUPTED, "cancelled");
    const bool is_goal = run->goal.order && !memcmp(run->goal.order->id, id, ORDER_ID);
    bool found = queued || is_goal;
    if (queued) run_answer(run, queued, MNS_E_INTERRUPTED, &error);
    if (is_goal) break_off(run, MNS_E_INTERRUPTED, "cancelled");
    for (const Waiter *waiter = before; waiter && !found; waiter = waiter->next) found = has_id(run, waiter, id);
    answer_some(run, has_id, id, MNS_E_INTERRUPTED, &error);
    if (found) run_answer(run, order, MNS_OK, NULL);
    else run_answer(run, order, mns_fail(&error, MNS_E_NOT_FOUND, "no command of that id is under way"), &error);
}

/* --- in and out of motion ---------------------------------------------------------------------------------------------- */

void run_fault(Run *run, const MnsError *error, bool output)
{
    run->fault = *error;
    run->output_failed = output;
    outputs_flush(&run->outputs, NULL);
    run_enter(run, RUN_FAULT, error->text);
    run_goal_end(run, error->status, error);
}

void run_begin(Run *run, const char *text)
{
    meter_begin(&run->meter, mns_sim_progress(run->sim), clock_now());
    run_enter(run, RUN_RUNNING, text);
    MnsError error;
    const double t = mns_sim_progress(run->sim).t;
    if (outputs_behind(&run->outputs, t) && outputs_take(&run->outputs, run->sim, run->document, &error))
        run_fault(run, &error, true);
}

void run_call_off(Run *run, const Order *by)
{
    MnsError error;
    mns_fail(&error, MNS_E_INTERRUPTED, "called off by a later pause or stop");
    for (Order *order; (order = mailbox_remove_motion(&run->mailbox, by->number));)
        run_answer(run, order, MNS_E_INTERRUPTED, &error);
}

void run_pause(Run *run, Order *order)
{
    run_call_off(run, order);
    if (run->state == RUN_RUNNING) break_off(run, MNS_E_INTERRUPTED, "paused on request");
    run_answer(run, order, MNS_OK, NULL);
}

void run_go(Run *run, Order *order)
{
    MnsError error;
    MnsStatus status = MNS_OK;
    assert(run->sim);
    if (run->state == RUN_FAULT && !run->output_failed)
        status = mns_fail(&error, MNS_E_STATE, "the simulation has diverged; restore a checkpoint or reset: %.300s",
                          run->fault.text);
    else if (run->state == RUN_FAULT) status = writer_retry(run->outputs.writer, &error);
    if (!status) run_begin(run, run->state == RUN_READY ? "started" : "resumed");
    if (!status && run->state == RUN_FAULT) { /* the very first output failed */
        error = run->fault;
        status = error.status;
    }
    run_answer(run, order, status, &error);
}

static void go_for(Run *run, Order *order, Goal goal, const char *text)
{
    goal.on = true;
    goal.order = order;
    run->goal = goal;
    run_begin(run, text);
}

void run_step(Run *run, Order *order, uint64_t n)
{
    const uint64_t now = mns_sim_progress(run->sim).step;
    MnsError error;
    if (!n)
        run_answer(run, order, mns_fail_at(&error, MNS_E_INVALID, "count", "the number of steps must be at least 1"),
                   &error);
    else go_for(run, order, (Goal){.t = INFINITY, .step = n > UINT64_MAX - now ? UINT64_MAX : now + n}, "stepping");
}

void run_until(Run *run, Order *order, double t, bool exact)
{
    const double now = mns_sim_progress(run->sim).t;
    MnsError error;
    if (!(t >= now) || isinf(t))
        run_answer(run, order,
                   mns_fail_at(&error, MNS_E_INVALID, "time",
                               "the time to run to must be a number at or after the present time, %.9g s; found %.9g",
                               now, t),
                   &error);
    else go_for(run, order, (Goal){.t = t, .step = UINT64_MAX, .exact = exact}, "running to a time");
}

/* --- one step ---------------------------------------------------------------------------------------------------------- */

/* The end: everything is on disk before anybody hears that it is done. */
static void finish(Run *run)
{
    MnsError error;
    if (outputs_finish(&run->outputs, run->sim, run->document, &error)) {
        run_fault(run, &error, true);
        return;
    }
    run_enter(run, RUN_DONE, "the end time is reached");
    run_goal_end(run, MNS_OK, NULL);
}

static bool goal_reached(const Run *run)
{
    const MnsProgress now = mns_sim_progress(run->sim);
    return run->goal.on && (now.t >= run->goal.t || now.step >= run->goal.step);
}

/* What this boundary means: the end, the goal, a breakpoint, or nothing. */
static void arrive(Run *run, MnsProgress before)
{
    const Breakpoint *point = breakpoints_reached(run->breakpoints, run->sim, before);
    if (mns_sim_progress(run->sim).t >= run->document->c->end_time) finish(run);
    else if (goal_reached(run)) {
        outputs_flush(&run->outputs, NULL);
        run_enter(run, RUN_PAUSED, "what was asked for is done");
        run_goal_end(run, MNS_OK, NULL);
    } else if (point) {
        char text[128];
        snprintf(text, sizeof text, "paused at breakpoint %s", point->name);
        break_off(run, MNS_E_INTERRUPTED, text);
    }
}

void run_advance(Run *run)
{
    MnsError error;
    const MnsProgress before = mns_sim_progress(run->sim);
    const double end = run->document->c->end_time, started = clock_now();
    if (before.t >= end || goal_reached(run)) {
        arrive(run, before);
        return;
    }
    const MnsStatus status = mns_sim_step(run->sim, run->goal.exact ? fmin(run->goal.t, end) : end, &error);
    const double now = clock_now();
    run_beat(run);
    if (status) { /* what there is to be seen of it, whole, for whoever comes later; no checkpoint: nobody would go on from it */
        outputs_snapshot(&run->outputs, run->sim, run->document, mns_state_fields(), NULL, NULL);
        run_fault(run, &error, false);
        return;
    }
    meter_step(&run->meter, mns_sim_progress(run->sim), mns_sim_particles(run->sim), now - started, now);
    run_publish_step(run);
    if (outputs_take(&run->outputs, run->sim, run->document, &error)) run_fault(run, &error, true);
    else arrive(run, before);
    if (now - run->progress >= PROGRESS_INTERVAL) run_tell_progress(run);
    run_answer_waiters(run);
}
