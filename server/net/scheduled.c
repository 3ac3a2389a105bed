/* SPDX-License-Identifier: BSD-3-Clause */
/* Requests with at_step or at_time. */
#include "net/scheduled.h"

#include <math.h>

enum { STATES = 1 << RUN_READY | 1 << RUN_RUNNING | 1 << RUN_PAUSED | 1 << RUN_DONE }; /* in which a moment may come */

static MnsStatus check_command(const Run *run, const Meniscus__Request *request, MnsError *error)
{
    MnsStatus status;
    switch (request->command_case) {
    case MENISCUS__REQUEST__COMMAND_SET:
        status = handler_check_set(request->set, error);
        return status ? status : run_check_set(run, request->set, error);
    case MENISCUS__REQUEST__COMMAND_ROLLBACK:
        return run_check_rollback(run, request->rollback->has_version ? request->rollback->version : 0, error);
    case MENISCUS__REQUEST__COMMAND_SNAPSHOT:
        return run_check_fields(request->snapshot->n_fields, request->snapshot->fields, error);
    default: return MNS_OK;
    }
}

static MnsStatus check(const Run *run, Order *order, MnsError *error)
{
    Exchange *x = (Exchange *)order;
    char where[128];
    if (STATES & 1u << run_state(run)) return check_command(run, x->request, error);
    x->allowed = STATES;
    handler_states(STATES, where);
    return mns_fail(error, MNS_E_STATE, "cannot schedule a %s while %s; possible in %s: %s", x->handler->name,
                    run_state_name(run_state(run)), where, handler_way_out(x->handler, run_state(run)));
}

/* What goes together, and what does not. */
static MnsStatus check_manner(const Handler *handler, const Meniscus__Request *request, MnsError *error)
{
    const char *which = request->has_at_step ? "at_step" : "at_time";
    if (!(handler->traits & AT_MOMENT))
        return mns_fail_at(error, MNS_E_INVALID, which,
                           "%s cannot be scheduled; set, rollback, pause, checkpoint and snapshot can", handler->name);
    if (request->has_at_step && request->has_at_time)
        return mns_fail_at(error, MNS_E_INVALID, which, "at which of the two? Give at_step or at_time");
    if (request->has_if_step)
        return mns_fail_at(error, MNS_E_INVALID, "if_step",
                           "a command that is scheduled takes no if_step: %s says where it takes effect", which);
    if (request->has_at_time && !isfinite(request->at_time))
        return mns_fail_at(error, MNS_E_INVALID, which, "the time of a command is a finite number of seconds");
    return MNS_OK;
}

MnsStatus scheduled_read(const Handler *handler, Exchange *exchange, MnsError *error)
{
    const Meniscus__Request *request = exchange->request;
    Order *order = &exchange->order;
    const bool scheduled = request->has_at_step || request->has_at_time;
    if (!scheduled && request->has_no_wait && request->no_wait)
        return mns_fail_at(error, MNS_E_INVALID, "no_wait",
                           "no_wait is for what is scheduled, with at_step or at_time; all else is answered when done");
    const MnsStatus status = scheduled ? check_manner(handler, request, error) : MNS_OK;
    if (status || !scheduled) return status;
    order->scheduled = true;
    order->at = (Moment){request->has_at_step ? request->at_step : UINT64_MAX,
                         request->has_at_time ? request->at_time : INFINITY};
    order->check = check;
    return MNS_OK;
}
