/* SPDX-License-Identifier: BSD-3-Clause */
/* Scheduled orders: accepted at one boundary, in effect at a later one. The journal has both: what is accepted outlives a crash. */
#include "run/inside.h"

#include "base/clock.h"
#include "base/log.h"
#include <inttypes.h>
#include <math.h>
#include <string.h>

/* What has been passed never comes, and neither does what is after the end. */
static MnsStatus check_ahead(const Run *run, const Order *order, MnsError *error)
{
    const MnsProgress now = mns_sim_progress(run->sim);
    const double end = run->document->c->end_time;
    if (order->at.step < now.step)
        return mns_fail_at(error, MNS_E_INVALID, "at_step",
                           "step %" PRIu64 " is past: the run is at step %" PRIu64 "; nothing was done", order->at.step,
                           now.step);
    if (order->at.t < now.t || (isfinite(order->at.t) && order->at.t > end))
        return mns_fail_at(error, MNS_E_INVALID, "at_time",
                           "the time of a command must lie between the present time, %.9g s, and the end time, %.9g s, "
                           "which can be set; found %.9g; nothing was done",
                           now.t, end, order->at.t);
    return MNS_OK;
}

/* Could it take effect now, but for the moment? */
static MnsStatus check_new(Run *run, Order *order, MnsError *error)
{
    MnsStatus status = run_check_moment(run, order, error);
    if (!status) status = order->check(run, order, error);
    if (!status) status = check_ahead(run, order, error);
    return status ? status : run_journal_ready(run, order, error);
}

/* Accepted before a crash: the run must be where it was then. */
static MnsStatus check_old(const Run *run, MnsError *error)
{
    if (run->state == RUN_READY || run->state == RUN_PAUSED || run->state == RUN_DONE) return MNS_OK;
    if (run->state == RUN_EMPTY && run->recovery.lineage)
        return mns_fail(error, MNS_E_STATE,
                        "the run for which this is scheduled is not back; it stays scheduled for when the daemon is "
                        "started again and comes back to it");
    return mns_fail(error, MNS_E_INTERRUPTED,
                    "the run for which this was scheduled has ended, or did not come back to where it was");
}

void run_appoint(Run *run, Order *order)
{
    MnsError error;
    const bool old = order->lineage != NULL;
    MnsStatus status = old ? check_old(run, &error) : check_new(run, order, &error);
    if (!status) status = agenda_add(&run->agenda, order, &error);
    if (status) {
        run_answer(run, order, status, &error);
        return;
    }
    order->appointed = true;
    order->lineage = NULL; /* from here on it is as if it had just been given */
    if (!old) run_note_scheduled(run, order);
}

/* In FAULT the case is not complete, or its files are not. */
const Order *run_due(const Run *run)
{
    const bool whole =
        run->state == RUN_READY || run->state == RUN_RUNNING || run->state == RUN_PAUSED || run->state == RUN_DONE;
    return whole ? agenda_due(&run->agenda, mns_sim_progress(run->sim)) : NULL;
}

/* In FAULT the journal may be what has failed. */
bool run_announces(const Run *run)
{
    for (const Order *order = run->agenda.first; order && run->state != RUN_FAULT; order = order->next)
        if (!order->announced) return true;
    return false;
}

/* Whoever hears of it and asks for the status finds it there. */
void run_announce(Run *run)
{
    Order *order = run->agenda.first;
    while (order && order->announced) order = order->next; /* those behind it are new, too */
    for (Order *new = order; new; new = new->next) new->announced = true;
    run_publish(run);
    for (; order; order = order->next) {
        run_describe_scheduled(order, order->notice.text, sizeof order->notice.text);
        run_tell(run, NOTE_EVENT, LOG_INFORMATION, "scheduled", order->notice.text);
        order->notice.kind = NOTE_SCHEDULED;
        order->notice.order = order;
        outbox_put(&run->outbox, &order->notice);
    }
}

void run_describe_scheduled(const Order *order, char *ret, size_t size)
{
    const Meniscus__Request *request = order->request;
    size_t n = (size_t)snprintf(ret, size, "%s", history_request(request));
    const bool sets = request->command_case == MENISCUS__REQUEST__COMMAND_SET;
    for (size_t k = 0; sets && k < request->set->n_assignments && n < size; k++)
        n += (size_t)snprintf(ret + n, size - n, "%s %.100s = %.100s", k ? "," : "", request->set->assignments[k]->path,
                              request->set->assignments[k]->value);
    if (request->command_case == MENISCUS__REQUEST__COMMAND_ROLLBACK && n < size)
        n += (size_t)snprintf(ret + n, size - n, " to version %" PRIu64, request->rollback->version);
    if (n >= size) return;
    if (request->has_at_step) snprintf(ret + n, size - n, ", at step %" PRIu64, order->at.step);
    else snprintf(ret + n, size - n, ", at t = %.9g s", order->at.t);
}

void run_tell_undone(Run *run, const Order *order, const MnsError *why)
{
    char what[256], text[640];
    run_describe_scheduled(order, what, sizeof what);
    snprintf(text, sizeof text, "%s, was not done: %.300s", what, why->text);
    run_tell(run, NOTE_LOG, LOG_WARNING, "scheduled", text);
}

/* Answer one that was taken out, and has no effect. */
static void drop(Run *run, Order *order, const MnsError *why)
{
    order->effect_step = mns_sim_progress(run->sim).step;
    run_answer(run, order, why->status, why);
}

bool run_cancel_appointment(Run *run, const uint8_t id[static ORDER_ID], const MnsError *why)
{
    Order *order = agenda_take_id(&run->agenda, id);
    if (!order) return false;
    drop(run, order, why);
    run_publish(run);
    return true;
}

void run_expire_appointments(Run *run, double now)
{
    MnsError why;
    mns_fail(&why, MNS_E_TIMEOUT, "the deadline passed before the command could take effect; nothing was done");
    bool any = false;
    for (Order *order; (order = agenda_take_late(&run->agenda, now)); any = true) drop(run, order, &why);
    if (any) run_publish(run);
}

void run_drop_appointments(Run *run, const char *text)
{
    MnsError why;
    mns_fail(&why, MNS_E_INTERRUPTED, "%s", text);
    for (Order *order; (order = agenda_take_first(&run->agenda));) drop(run, order, &why);
}
