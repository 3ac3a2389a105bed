/* SPDX-License-Identifier: BSD-3-Clause */
/* The run in motion: steps, what they are to reach, what ends them. */
#include "run/inside.h"

#include "base/clock.h"
#include <assert.h>
#include <math.h>
#include <string.h>

enum { HASH_STEPS = 100 }; /* a replay is compared with the journal this often */

/* --- goals ------------------------------------------------------------------------------------------------------------ */

void run_goal_end(Run *run, MnsStatus status, const MnsError *error)
{
    Order *order = run->goal.order;
    run->goal = (Goal){.on = false};
    if (!order) return;
    order->effect_step = mns_sim_progress(run->sim).step;
    run_answer(run, order, status, error);
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

/* Whatever comes after a crash, it stands here. */
static void note_halted(Run *run, RunState state)
{
    if (!run->goal.order) run_note_halted(run, state);
}

/* Of those that wait until the run is back. */
static void expire_waiting(Run *run, double now)
{
    MnsError error;
    mns_fail(&error, MNS_E_TIMEOUT, "the deadline passed before the run was back where it was; nothing was done");
    for (Order *order; (order = mailbox_remove_late(&run->mailbox, now));)
        run_answer_unserved(run, order, MNS_E_TIMEOUT, &error);
}

void run_expire(Run *run)
{
    const double now = clock_now();
    if (run->state == RUN_RECOVERING) expire_waiting(run, now);
    if (!(run_next_deadline(run) < now)) return;
    run_answer_late(run, now);
    run_expire_appointments(run, now);
    if (run->goal.order && run->goal.order->deadline < now)
        break_off(run, MNS_E_TIMEOUT, "paused: the deadline of the command passed before it was done");
}

void run_cancel(Run *run, Order *order, const uint8_t id[static ORDER_ID])
{
    MnsError error;
    Order *queued = mailbox_remove(&run->mailbox, id);
    if (!queued) queued = run_take_held(run, id);
    mns_fail(&error, MNS_E_INTERRUPTED, "cancelled");
    const bool is_goal = run->goal.order && !memcmp(run->goal.order->id, id, ORDER_ID);
    if (queued) run_answer_unserved(run, queued, MNS_E_INTERRUPTED, &error);
    if (is_goal) break_off(run, MNS_E_INTERRUPTED, "cancelled");
    const bool waited = run_answer_cancelled(run, id, &error), scheduled = run_cancel_appointment(run, id, &error);
    if (queued || is_goal || waited || scheduled || order->ended) run_answer(run, order, MNS_OK, NULL);
    else run_answer(run, order, mns_fail(&error, MNS_E_NOT_FOUND, "no command of that id is under way"), &error);
}

/* --- in and out of motion ---------------------------------------------------------------------------------------------- */

void run_fault(Run *run, const MnsError *error, bool output)
{
    run->fault = *error;
    run->output_failed = output;
    run->figures.faults[error->status]++;
    outputs_flush(&run->outputs, NULL);
    run_enter(run, RUN_FAULT, error->text);
    run_goal_end(run, error->status, error);
}

/* RUNNING, with the outputs of the first boundary. */
static void begin(Run *run, const char *text)
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
        run_answer_unserved(run, order, MNS_E_INTERRUPTED, &error);
}

void run_pause(Run *run, Order *order)
{
    run_call_off(run, order);
    if (run->state == RUN_RUNNING) break_off(run, MNS_E_INTERRUPTED, "paused on request");
    run_answer(run, order, MNS_OK, NULL);
}

bool run_is_broken(const Run *run)
{
    return run->fault.status && !run->output_failed && (run->fault.status != MNS_E_INVALID || run->astray);
}

const char *run_broken_why(const Run *run)
{
    return run->fault.status == MNS_E_DIVERGED ? "the simulation has diverged" : "a step was broken off half-way";
}

MnsStatus run_refuse_broken(const Run *run, MnsError *error)
{
    char name[256];
    if (!checkpoint_last(run->outputs.directory, name))
        return mns_fail(error, MNS_E_STATE, "%s; there is no checkpoint, so reset: %.300s", run_broken_why(run),
                        run->fault.text);
    return mns_fail(error, MNS_E_STATE, "%s; restore a checkpoint, the last is %s, or reset: %.300s",
                    run_broken_why(run), name, run->fault.text);
}

void run_go(Run *run, Order *order)
{
    MnsError error;
    MnsStatus status = MNS_OK;
    assert(run->sim);
    if (run_is_held_up(run)) {
        run_recover_again(run, order);
        return;
    }
    if (run->state == RUN_FAULT && run->astray)
        status = mns_fail(
            &error, MNS_E_STATE,
            "the run did not come back to where it was before the crash, and what was commanded there would be "
            "lost; end the daemon and start it again, or restore or reset: %.300s",
            run->fault.text);
    else if (run->state == RUN_FAULT && run_is_broken(run)) status = run_refuse_broken(run, &error);
    else if (run->state == RUN_FAULT && run->output_failed) status = writer_retry(run->outputs.writer, &error);
    if (!status) begin(run, run->state == RUN_READY ? "started" : "resumed");
    if (!status && run->state == RUN_FAULT) { /* the very first output failed */
        error = run->fault;
        status = error.status;
    }
    run_answer(run, order, status, &error);
}

static void go_for(Run *run, Order *order, Goal goal, const char *text)
{
    run_note_begun(run, order);
    goal.on = true;
    goal.order = order;
    run->goal = goal;
    begin(run, text);
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
    const double now = mns_sim_progress(run->sim).t, end = run->document->c->end_time;
    MnsError error;
    if (!(t >= now && t <= end))
        run_answer(
            run, order,
            mns_fail_at(&error, MNS_E_INVALID, "time",
                        "the time to run to must lie between the present time, %.9g s, and the end time, %.9g s, "
                        "which can be set; found %.9g",
                        now, end, t),
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
    const bool early = run->goal.on && mns_sim_progress(run->sim).t < run->goal.t && isfinite(run->goal.t);
    run_hash(run);
    note_halted(run, RUN_DONE);
    run_enter(run, RUN_DONE, "the end time is reached");
    if (early) /* somebody moved the end meanwhile */
        mns_fail(&error, MNS_E_INTERRUPTED, "the end time, %.9g s, came before the time to run to, %.9g s",
                 run->document->c->end_time, run->goal.t);
    run_goal_end(run, early ? MNS_E_INTERRUPTED : MNS_OK, &error);
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
        run_hash(run);
        run_enter(run, RUN_PAUSED, "what was asked for is done");
        run_goal_end(run, MNS_OK, NULL);
    } else if (point) {
        char text[128];
        snprintf(text, sizeof text, "paused at breakpoint %s", point->name);
        note_halted(run, RUN_PAUSED);
        break_off(run, MNS_E_INTERRUPTED, text);
    }
}

MnsStatus run_step_once(Run *run, double limit, bool *ret_output, MnsError *error)
{
    const double started = clock_now();
    run->hashed = *ret_output = false;
    const MnsStatus status = mns_sim_step(run->sim, limit, error);
    const double now = clock_now();
    run_beat(run);
    if (status) { /* what there is to be seen of it, whole, for whoever comes later; no checkpoint: nobody would go on from it */
        outputs_snapshot(&run->outputs, run->sim, run->document, mns_sim_state_fields(run->sim), NULL, NULL);
        return status;
    }
    meter_step(&run->meter, mns_sim_progress(run->sim), mns_sim_particles(run->sim), now - started, now);
    run_count_step(run, now - started);
    run_publish_step(run);
    run_tell_warnings(run);
    if (mns_sim_progress(run->sim).step % HASH_STEPS == 0) run_hash(run);
    *ret_output = true;
    return outputs_take(&run->outputs, run->sim, run->document, error);
}

void run_advance(Run *run)
{
    MnsError error;
    bool output;
    const MnsProgress before = mns_sim_progress(run->sim);
    const double end = run->document->c->end_time;
    if (before.t >= end || goal_reached(run)) {
        arrive(run, before);
        return;
    }
    const double limit = fmin(run->goal.exact ? run->goal.t : INFINITY, agenda_limit(&run->agenda));
    MnsStatus status = run_step_once(run, fmin(limit, end), &output, &error);
    if (!status) status = run_bound_way_back(run, &error);
    if (status == MNS_E_DIVERGED && !output) run_hash(run); /* a replay has to diverge to the same */
    if (status) run_fault(run, &error, output);
    if (status && !output) return;
    run_offer(run, true);
    if (!status) arrive(run, before);
    run_show(run);
    run_tell_progress_at_times(run);
}
