/* SPDX-License-Identifier: BSD-3-Clause */
/* The commands of the protocol. The table says all; the functions before it take the request apart. */
#include "net/handlers.h"

#include "common/case/name.h"
#include "common/wire/states.h"
#include "net/complete.h"
#include "net/here.h"
#include "net/look.h"
#include "net/scheduled.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- AT_STEP ----------------------------------------------------------------------------------------------------------- */

static void answer(Run *run, Exchange *x, MnsStatus status, const MnsError *error)
{
    run_answer(run, &x->order, status, error);
}

/* *ret: [n_settings], yours. */
static MnsStatus read_settings(const Meniscus__Load *load, RunSetting **ret, MnsError *error)
{
    RunSetting *settings = calloc(load->n_settings + 1, sizeof *settings);
    if (!settings) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu settings", load->n_settings);
    for (size_t k = 0; k < load->n_settings; k++) {
        const Meniscus__Assignment *from = load->settings[k];
        settings[k] = (RunSetting){from->path, from->value};
        if (from->path && from->value) continue;
        free(settings);
        return mns_fail(error, MNS_E_INVALID, "a setting needs a path and a value");
    }
    *ret = settings;
    return MNS_OK;
}

static void serve_load(Run *run, Exchange *x)
{
    const Meniscus__Load *from = x->request->load;
    MnsError error;
    RunSetting *settings = NULL;
    if (x->order.lineage) {
        run_recover(run, &x->order);
        return;
    }
    MnsStatus status = read_settings(from, &settings, &error);
    if (!status && !from->case_) status = mns_fail_at(&error, MNS_E_INVALID, "case", "load needs a case");
    const RunLoad load = {.message = from->case_,
                          .name = from->name ? from->name : CASE_NAMELESS,
                          .resume = from->has_resume && from->resume,
                          .n_settings = from->n_settings,
                          .settings = settings};
    if (status) answer(run, x, status, &error);
    else run_load(run, &x->order, &load);
    free(settings);
}

static void serve_go(Run *run, Exchange *x)
{
    run_go(run, &x->order);
}
static void serve_pause(Run *run, Exchange *x)
{
    run_pause(run, &x->order);
}
static void serve_step(Run *run, Exchange *x)
{
    const Lineage *lineage = x->order.lineage; /* it had set out before a crash: what is left of it */
    const uint64_t now = mns_sim_progress(run_sim(run)).step, count = x->request->step->count;
    const uint64_t done = lineage && lineage->begun && now > lineage->begun_step ? now - lineage->begun_step : 0;
    if (done && done >= count) answer(run, x, MNS_OK, NULL);
    else run_step(run, &x->order, count - done);
}

static void serve_until(Run *run, Exchange *x)
{
    const Meniscus__RunUntil *until = x->request->run_until;
    run_until(run, &x->order, until->has_time ? until->time : NAN, until->exact);
}

static void serve_stop(Run *run, Exchange *x)
{
    run_stop(run, &x->order, x->request->stop->has_checkpoint && x->request->stop->checkpoint);
}

static void serve_shutdown(Run *run, Exchange *x)
{
    run_leave(run, &x->order, x->request->shutdown->has_checkpoint && x->request->shutdown->checkpoint);
}

static void serve_reset(Run *run, Exchange *x)
{
    run_reset(run, &x->order);
}
static void serve_restore(Run *run, Exchange *x)
{
    run_restore(run, &x->order, x->request->restore->checkpoint);
}
static void serve_checkpoint(Run *run, Exchange *x)
{
    run_checkpoint(run, &x->order);
}

static void serve_snapshot(Run *run, Exchange *x)
{
    run_snapshot(run, &x->order, x->request->snapshot->n_fields, x->request->snapshot->fields);
}

/* Is one of those before it for the same entry? */
static bool is_repeated(const Meniscus__Set *set, size_t k)
{
    const char *path = set->assignments[k]->path;
    for (size_t i = 0; path && i < k; i++)
        if (set->assignments[i]->path && !strcmp(set->assignments[i]->path, path)) return true;
    return false;
}

MnsStatus handler_check_set(const Meniscus__Set *set, MnsError *error)
{
    if (set->n_assignments > ENTRIES_MAX)
        return mns_fail_at(error, MNS_E_LIMIT, "assignments", "at most %d entries can be set at a time, found %zu",
                           ENTRIES_MAX, set->n_assignments);
    for (size_t k = 1; k < set->n_assignments; k++)
        if (is_repeated(set, k))
            return mns_fail_at(error, MNS_E_INVALID, set->assignments[k]->path,
                               "the entry is there twice; they are set together, so give it one value");
    return MNS_OK;
}

static void serve_set(Run *run, Exchange *x)
{
    const Meniscus__Set *set = x->request->set;
    MnsError error;
    const MnsStatus status = handler_check_set(set, &error);
    if (status) answer(run, x, status, &error);
    else run_set(run, &x->order, set);
}

static void serve_rollback(Run *run, Exchange *x)
{
    const Meniscus__Rollback *rollback = x->request->rollback;
    run_rollback(run, &x->order, rollback->has_version ? rollback->version : 0);
}

static void serve_lease(Run *run, Exchange *x)
{
    const Meniscus__Lease *lease = x->request->lease;
    const LeaseWish wish = {.epoch = x->order.lease_epoch,
                            .ttl_ms = lease->has_ttl_ms ? lease->ttl_ms : 0,
                            .release = lease->has_release && lease->release,
                            .holder = lease->holder};
    run_lease(run, &x->order, &wish);
}

static void serve_query(Run *run, Exchange *x)
{
    const Meniscus__Query *query = x->request->query;
    const MnsSim *sim = run_sim(run);
    MnsStatus status;
    MnsError error;
    switch (query->what_case) {
    case MENISCUS__QUERY__WHAT_PROBES: status = look_probes(sim, query->probes, x, &error); break;
    case MENISCUS__QUERY__WHAT_POINTS: status = look_points(sim, query->points, x, &error); break;
    case MENISCUS__QUERY__WHAT_PARTICLES: status = look_particles(sim, query->particles, x, &error); break;
    default: status = mns_fail(&error, MNS_E_INVALID, "a query needs one of probes, points and particles");
    }
    answer(run, x, status, &error);
}

static void serve_wait(Run *run, Exchange *x)
{
    const Meniscus__Wait *from = x->request->wait;
    RunWait wait = {0, from->has_time ? from->time : INFINITY, from->has_step ? from->step : UINT64_MAX};
    MnsError error;
    bool known = true;
    for (size_t k = 0; k < from->n_states; k++) {
        known = known && (unsigned)from->states[k] < RUN_STATES;
        if (known) wait.states |= 1u << from->states[k];
    }
    if (!known || isnan(wait.t) || (!wait.states && !from->has_time && !from->has_step))
        answer(run, x, mns_fail(&error, MNS_E_INVALID, "wait needs a state, a time or a step to wait for"), &error);
    else run_wait(run, &x->order, &wait);
}

static void serve_breakpoint(Run *run, Exchange *x)
{
    run_breakpoint(run, &x->order, x->request->breakpoint);
}

/* Of the command to cancel; NULL if that is none. Zeros are the id of nothing: what the daemon does by itself has no other. */
static const uint8_t *cancelled_id(const Meniscus__Cancel *cancel)
{
    static const uint8_t zeros[ORDER_ID];
    if (!cancel->has_id || cancel->id.len != ORDER_ID) return NULL;
    return memcmp(cancel->id.data, zeros, ORDER_ID) ? cancel->id.data : NULL;
}

static void serve_cancel(Run *run, Exchange *x)
{
    const uint8_t *id = cancelled_id(x->request->cancel);
    MnsError error;
    if (id) run_cancel(run, &x->order, id);
    else
        answer(run, x,
               mns_fail_at(&error, MNS_E_INVALID, "id", "cancel needs the id of a command, %d bytes and not all zero",
                           ORDER_ID),
               &error);
}

/* --- the table --------------------------------------------------------------------------------------------------------- */

enum {
    EMPTY = 1 << RUN_EMPTY,
    READY = 1 << RUN_READY,
    RUNNING = 1 << RUN_RUNNING,
    PAUSED = 1 << RUN_PAUSED,
    DONE = 1 << RUN_DONE,
    FAULT = 1 << RUN_FAULT,
    RECOVERING = 1 << RUN_RECOVERING,
    STILL = READY | PAUSED | DONE | FAULT, /* a case, not in motion */
    LOADED = STILL | RUNNING,
    ANY = (1 << RUN_STATES) - 1
};

/* States go over the wire, in sets too, with the numbers they have here. */
STATES_HAVE_THE_NUMBERS_OF_THE_PROTOCOL(RUN_);
_Static_assert(RUN_STATES == RUN_RECOVERING + 1, "all states are compared");

#define REQUEST(command) MENISCUS__REQUEST__COMMAND_##command

/* clang-format off */
static const Handler handlers[] = {
    /* request                    name            typed        where    role           states                    traits                          by                  then                */
    [REQUEST(STATUS)]       = { "status",       NULL,        HERE,    ROLE_VIEWER,   ANY,                      0,                              here_status,        NULL               },
    [REQUEST(CAPABILITIES)] = { "capabilities", NULL,        HERE,    ROLE_VIEWER,   ANY,                      0,                              here_capabilities,  NULL               },
    [REQUEST(GET)]          = { "get",          NULL,        HERE,    ROLE_VIEWER,   ANY,                      0,                              here_get,           NULL               },
    [REQUEST(LOAD)]         = { "load",         NULL,        AT_STEP, ROLE_ADMIN,    STILL | EMPTY,            CHANGES | LEASED,               serve_load,         complete_directory },
    [REQUEST(START)]        = { "start",        NULL,        AT_STEP, ROLE_OPERATOR, READY,                    MOTION | CHANGES | LEASED,      serve_go,           NULL               },
    [REQUEST(RESUME)]       = { "resume",       NULL,        AT_STEP, ROLE_OPERATOR, PAUSED | FAULT,           MOTION | CHANGES | LEASED,      serve_go,           NULL               },
    [REQUEST(STEP)]         = { "step",         NULL,        AT_STEP, ROLE_OPERATOR, READY | PAUSED,           MOTION | CHANGES | LEASED,      serve_step,         NULL               },
    [REQUEST(RUN_UNTIL)]    = { "run_until",    "run-until", AT_STEP, ROLE_OPERATOR, READY | PAUSED,           MOTION | CHANGES | LEASED,      serve_until,        NULL               },
    [REQUEST(PAUSE)]        = { "pause",        NULL,        AT_STEP, ROLE_OPERATOR, RUNNING | READY | PAUSED, URGENT | CHANGES | AT_MOMENT,   serve_pause,        NULL               },
    [REQUEST(STOP)]         = { "stop",         NULL,        AT_STEP, ROLE_OPERATOR, LOADED | RECOVERING,      URGENT | ENDS | CHANGES,        serve_stop,         complete_directory },
    [REQUEST(CANCEL)]       = { "cancel",       NULL,        AT_STEP, ROLE_OPERATOR, ANY,                      URGENT | ENDS | CHANGES,        serve_cancel,       NULL               },
    [REQUEST(SHUTDOWN)]     = { "shutdown",     NULL,        AT_STEP, ROLE_ADMIN,    ANY,                      URGENT | ENDS | LAST | CHANGES, serve_shutdown,     complete_directory },
    [REQUEST(RESET)]        = { "reset",        NULL,        AT_STEP, ROLE_OPERATOR, STILL,                    CHANGES | LEASED,               serve_reset,        complete_directory },
    [REQUEST(RESTORE)]      = { "restore",      NULL,        AT_STEP, ROLE_OPERATOR, STILL,                    CHANGES | LEASED,               serve_restore,      complete_directory },
    [REQUEST(CHECKPOINT)]   = { "checkpoint",   NULL,        AT_STEP, ROLE_OPERATOR, LOADED,                   CHANGES | AT_MOMENT | WRITES,   serve_checkpoint,   complete_file      },
    [REQUEST(SNAPSHOT)]     = { "snapshot",     NULL,        AT_STEP, ROLE_OPERATOR, LOADED,                   CHANGES | AT_MOMENT | WRITES,   serve_snapshot,     complete_file      },
    [REQUEST(SET)]          = { "set",          NULL,        AT_STEP, ROLE_OPERATOR, LOADED,                   CHANGES | LEASED | AT_MOMENT,   serve_set,          complete_set       },
    [REQUEST(ROLLBACK)]     = { "rollback",     NULL,        AT_STEP, ROLE_OPERATOR, LOADED,                   CHANGES | LEASED | AT_MOMENT,   serve_rollback,     NULL               },
    [REQUEST(LEASE)]        = { "lease",        NULL,        AT_STEP, ROLE_OPERATOR, ANY,                      CHANGES,                        serve_lease,        complete_lease     },
    [REQUEST(QUERY)]        = { "query",        NULL,        AT_STEP, ROLE_VIEWER,   LOADED,                   LARGE | LOOKS,                  serve_query,        NULL               },
    [REQUEST(WAIT)]         = { "wait",         NULL,        AT_STEP, ROLE_VIEWER,   ANY,                      LOOKS,                          serve_wait,         complete_wait      },
    [REQUEST(BREAKPOINT)]   = { "breakpoint",   NULL,        AT_STEP, ROLE_OPERATOR, LOADED,                   CHANGES | LEASED,               serve_breakpoint,   NULL               },
};
/* clang-format on */

const Handler *handler_find(Meniscus__Request__CommandCase command)
{
    const size_t k = (size_t)command;
    return k < sizeof handlers / sizeof *handlers && handlers[k].name ? &handlers[k] : NULL;
}

_Static_assert(sizeof handlers / sizeof *handlers < HANDLER_NAMES, "the list of names has room for all");

void handler_names(const char *ret[static HANDLER_NAMES])
{
    size_t n = 0;
    for (size_t k = 0; k < sizeof handlers / sizeof *handlers; k++)
        if (handlers[k].name) ret[n++] = handlers[k].name;
    ret[n] = NULL;
}

void handler_states(unsigned states, char ret[static 128])
{
    ret[0] = 0;
    for (int state = 0; state < RUN_STATES; state++)
        if (states & 1u << state) {
            if (ret[0]) strcat(ret, ", ");
            strcat(ret, run_state_name((RunState)state));
        }
}

const char *handler_way_out(const Handler *handler, RunState state)
{
    const bool goes = handler->serve == serve_go; /* start and resume: what they are for is there already */
    switch (state) {
    case RUN_EMPTY: return "load a case first, as in `meniscus load dambreak2d`";
    case RUN_READY: return "start it first";
    case RUN_RUNNING: return goes ? "it runs already" : "pause it first";
    case RUN_PAUSED: return "resume goes on, reset begins anew";
    case RUN_DONE: return "a later end_time lets it go on, reset begins anew";
    case RUN_FAULT: return "resume goes on if that is possible, and says what is if not";
    case RUN_STOPPING: return "start the daemon again";
    default: return "wait until it is ready"; /* it loads, or comes back after a crash */
    }
}

static const char *way_out(const Run *run, const Handler *handler)
{
    if (!run_is_unread(run)) return handler_way_out(handler, run_state(run));
    return "a run that a crash has ended is not gone on with, and `meniscus status` says why; mend that and start the "
           "daemon "
           "again, or load a case beside it";
}

static void serve_at_step(Run *run, Order *order)
{
    Exchange *x = (Exchange *)order;
    const Handler *handler = x->handler;
    char where[128];
    MnsError error;
    if (handler->states & 1u << run_state(run) || order->ended) { /* what it was to end may have been all there was */
        handler->serve(run, x);
        return;
    }
    x->allowed = handler->states;
    handler_states(handler->states, where);
    const char *name = handler->typed ? handler->typed : handler->name;
    answer(run, x,
           mns_fail(&error, MNS_E_STATE, "cannot %s while %s; possible in %s: %s", name, run_state_name(run_state(run)),
                    where, way_out(run, handler)),
           &error);
}

static const Meniscus__Reply *seal(Order *order)
{
    Exchange *x = (Exchange *)order;
    exchange_seal(x);
    return x->reply;
}

static bool is_conditional(const Meniscus__Request *request)
{
    return request->has_if_step || (request->has_if_version && request->if_version);
}

/* A cancel ends what it names, and nothing if that is no id. With a condition on the step or the version none does, as what is
 * being loaded is at none yet. */
static void note_end(const Handler *handler, const Meniscus__Request *request, Order *order)
{
    order->ends = handler->traits & ENDS && !is_conditional(request);
    order->ends_any = order->ends && request->command_case != REQUEST(CANCEL);
    if (order->ends_any || !order->ends) return;
    const uint8_t *id = cancelled_id(request->cancel);
    order->ends = id != NULL;
    if (id) memcpy(order->ends_id, id, ORDER_ID);
}

/* After a crash: for the step or version it names, or for a state worth keeping. */
static bool waits_for_the_run(const Meniscus__Request *request)
{
    const bool stops = request->command_case == REQUEST(STOP);
    return is_conditional(request) || (stops && request->stop->has_checkpoint && request->stop->checkpoint);
}

MnsStatus handler_check_role(const Handler *handler, const Who *who, MnsError *error)
{
    if (!handler) return mns_fail(error, MNS_E_VERSION, "this daemon does not know the command");
    if (who->role >= handler->role) return MNS_OK;
    return mns_fail(error, MNS_E_DENIED, "%s takes the role %s, and \"%s\" is %s", handler->name,
                    role_name(handler->role), who->name, role_name(who->role));
}

MnsStatus handle(Run *run, Exchange *exchange, MnsError *error)
{
    const Meniscus__Request *request = exchange->request;
    const Handler *handler = handler_find(request->command_case);
    MnsStatus status = handler_check_role(handler, &exchange->order.who, error);
    if (status) return status;
    if (handler->where == HERE && (request->has_if_step || request->has_if_version)) {
        const char *which = request->has_if_step ? "if_step" : "if_version";
        return mns_fail_at(error, MNS_E_INVALID, which,
                           "%s takes no %s: it is answered at whatever step the run is, and says at which",
                           handler->name, which);
    }
    if (request->has_lease_epoch && !request->lease_epoch)
        return mns_fail_at(error, MNS_E_INVALID, "lease_epoch",
                           "no lease has the epoch 0; leave it away, or give that of the lease that was taken");
    status = scheduled_read(handler, exchange, error);
    if (status) return status;
    exchange->handler = handler;
    const bool met = exchange->order.lineage && handler->traits & MOTION; /* when it set out, before a crash */
    exchange->order.conditional = request->has_if_step && !met;
    exchange->order.if_step = request->if_step;
    exchange->order.if_version = request->has_if_version && !met ? request->if_version : 0;
    exchange->order.lease_epoch = request->has_lease_epoch ? request->lease_epoch : 0;
    exchange->order.leased = handler->traits & LEASED;
    /* What is scheduled keeps its place among the others, and after a crash comes behind the load that brings the run back. */
    exchange->order.urgent = handler->traits & URGENT && !exchange->order.scheduled;
    exchange->order.motion = handler->traits & MOTION;
    exchange->order.looks = handler->traits & LOOKS;
    exchange->order.writes = handler->traits & WRITES && !exchange->order.scheduled;
    exchange->order.serve = serve_at_step;
    exchange->order.seal = seal;
    exchange->order.meanwhile = handler->traits & ENDS && !waits_for_the_run(exchange->request);
    if (handler->traits & CHANGES || exchange->order.scheduled) exchange->order.request = exchange->request;
    note_end(handler, exchange->request, &exchange->order);
    exchange->at_step = handler->where == AT_STEP;
    if (handler->where == AT_STEP) return run_post(run, &exchange->order, error);
    handler->serve(run, exchange);
    return MNS_OK;
}
