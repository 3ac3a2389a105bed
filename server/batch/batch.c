/* SPDX-License-Identifier: BSD-3-Clause */
/* One run from the command line. The run has its own threads; this one posts orders, shows progress and minds signals. */
#include "batch/batch.h"

#include "base/log.h"
#include "base/signals.h"
#include "batch/bar.h"
#include "batch/outcome.h"
#include "common/case/file.h"
#include "common/case/find.h"
#include "common/case/load.h"
#include "common/case/name.h"
#include "common/host/script.h"
#include <math.h>
#include <meniscus/exit.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* What the command line asks for, as a client would: for the journal. */
typedef struct BatchRequests {
    Meniscus__Request load, start, until, shutdown, pause;
    Meniscus__Load what;
    Meniscus__Start begin;
    Meniscus__RunUntil when;
    Meniscus__Shutdown leave;
    Meniscus__Pause halt;
} BatchRequests;

/* An order that knows the batch. */
typedef struct BatchOrder {
    Order order;
    struct Batch *batch;
    bool under_way; /* of the reserved ones */
} BatchOrder;

typedef struct Batch {
    const BatchOptions *options;
    CaseFile *file;
    char path[4096]; /* of the case file */
    char name[CASE_NAME_SIZE];
    char directory[RUNDIR_PATH];
    Run *run;
    Signals signals;
    Bar bar;
    size_t n_settings;
    RunSetting *settings; /* [n_settings] of the file */
    double probes[MNS_MAX_PROBES];
    BatchRequests requests;
    BatchOrder pause, checkpoint; /* of signals: there from the beginning, so that none is lost for lack of memory */
} Batch;

/* --- what the runner does for us --------------------------------------------------------------------------------------- */

static Batch *batch_of(Order *order)
{
    return ((BatchOrder *)order)->batch;
}

static void serve_load(Run *run, Order *order)
{
    const Batch *batch = batch_of(order);
    const RunLoad load = {.message = case_file_message(batch->file),
                          .name = batch->name,
                          .resume = batch->options->resume,
                          .overwrite = batch->options->overwrite,
                          .n_settings = batch->n_settings,
                          .settings = batch->settings};
    run_load(run, order, &load);
}

static void serve_go(Run *run, Order *order)
{
    run_go(run, order);
}

static void serve_until(Run *run, Order *order)
{
    run_until(run, order, batch_of(order)->options->until, false);
}

static void serve_wait(Run *run, Order *order)
{
    const RunWait wait = {1u << RUN_DONE | 1u << RUN_FAULT | 1u << RUN_PAUSED, INFINITY, UINT64_MAX};
    run_wait(run, order, &wait);
}

static void serve_pause(Run *run, Order *order)
{
    run_pause(run, order);
}

static void serve_checkpoint(Run *run, Order *order)
{
    MnsError error;
    if (run_sim(run)) run_checkpoint(run, order);
    else run_answer(run, order, mns_fail(&error, MNS_E_STATE, "there is no case yet"), &error);
}

static void serve_probes(Run *run, Order *order)
{
    const MnsSim *sim = run_sim(run);
    for (size_t k = 0; k < mns_sim_case(sim)->n_probes; k++) batch_of(order)->probes[k] = mns_sim_probe(sim, k);
    run_answer(run, order, MNS_OK, NULL);
}

static void serve_leave(Run *run, Order *order)
{
    run_leave(run, order, true);
}

/* --- orders, notes and signals ----------------------------------------------------------------------------------------- */

static BatchOrder new_order(Batch *batch, void (*serve)(Run *, Order *), const Meniscus__Request *request)
{
    return (BatchOrder){
        .order = {.serve = serve, .deadline = INFINITY, .request = request, .who = {WHO_BATCH, ROLE_ADMIN}},
        .batch = batch};
}

/* An order whose answer does not matter; ends: also the loading of the case. While it is under way another one of it would change nothing. */
static void post_aside(Batch *batch, BatchOrder *order, void (*serve)(Run *, Order *), const Meniscus__Request *request,
                       bool ends)
{
    if (order->under_way) return;
    *order = new_order(batch, serve, request);
    order->order.ends = ends;
    order->under_way = !run_post(batch->run, &order->order, NULL);
}

static void take_signal(Batch *batch)
{
    switch (signals_take(&batch->signals)) {
    case SIGNAL_NOTHING: break;
    case SIGNAL_CHECKPOINT: post_aside(batch, &batch->checkpoint, serve_checkpoint, NULL, false); break;
    case SIGNAL_LEAVE: post_aside(batch, &batch->pause, serve_pause, &batch->requests.pause, true); break;
    case SIGNAL_INSIST: _exit(MNS_EXIT_FAILED);
    }
}

/* Look at all notes; true if the order has come back. */
static bool take_notes(Batch *batch, const Order *awaited)
{
    bool came = false;
    for (Note *note; (note = outbox_take(run_outbox(batch->run)));) {
        if (note->kind == NOTE_PROGRESS) bar_show(&batch->bar, note);
        if (note->kind != NOTE_ANSWER) note_free(note);
        else if (note->order == awaited) came = true;
        else ((BatchOrder *)note->order)->under_way = false;
    }
    return came;
}

/* Have the runner do something, and wait for it. request: for the journal; NULL if it only looks. */
static MnsStatus perform(Batch *batch, void (*serve)(Run *, Order *), const Meniscus__Request *request, MnsError *error)
{
    BatchOrder order = new_order(batch, serve, request);
    MnsStatus status = run_post(batch->run, &order.order, error);
    if (status) return status;
    struct pollfd wake[2] = {{.fd = run_outbox(batch->run)->wake, .events = POLLIN},
                             {.fd = batch->signals.fd, .events = POLLIN}};
    while (!take_notes(batch, &order.order)) {
        poll(wake, 2, -1);
        if (wake[1].revents & POLLIN) take_signal(batch);
    }
    status = order.order.status;
    if (status) *error = order.order.error;
    return status;
}

/* --- the case ---------------------------------------------------------------------------------------------------------- */

static MnsStatus list_settings(Batch *batch, MnsError *error)
{
    const size_t n = batch->options->n_settings;
    batch->settings = calloc(n + 1, sizeof *batch->settings);
    if (!batch->settings) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu settings", n);
    for (RunSetting *at = batch->settings; case_file_setting(batch->file, batch->n_settings, &at->path, &at->value);
         at++)
        batch->n_settings++;
    return MNS_OK;
}

static MnsStatus read_case(Batch *batch, MnsError *error)
{
    const BatchOptions *options = batch->options;
    MnsStatus status = case_find(options->name, batch->path, error);
    if (!status)
        status = case_file_read_with(batch->path, options->n_settings, (const char *const *)options->settings,
                                     &batch->file, error);
    if (!status) status = list_settings(batch, error);
    if (status) return status;
    case_name_from_path(batch->path, batch->name);
    const char *directory = options->directory;
    if (directory && strlen(directory) >= RUNDIR_PATH)
        return mns_fail(error, MNS_E_LIMIT, "the path of the run directory is too long: %.200s...", directory);
    if (directory) snprintf(batch->directory, sizeof batch->directory, "%s", directory);
    else snprintf(batch->directory, sizeof batch->directory, "./%s.run", batch->name);
    return MNS_OK;
}

static MnsStatus make_requests(Batch *batch, MnsError *error)
{
    BatchRequests *to = &batch->requests;
    const Meniscus__Request none = MENISCUS__REQUEST__INIT;
    to->load = to->start = to->until = to->shutdown = to->pause = none;
    meniscus__start__init(&to->begin);
    meniscus__run_until__init(&to->when);
    meniscus__shutdown__init(&to->leave);
    meniscus__pause__init(&to->halt);
    to->when.has_time = to->when.has_exact = to->leave.has_checkpoint = to->leave.checkpoint = true;
    to->when.time = batch->options->until;
    to->when.exact = false;
    to->load.command_case = MENISCUS__REQUEST__COMMAND_LOAD;
    to->load.load = &to->what;
    to->start.command_case = MENISCUS__REQUEST__COMMAND_START;
    to->start.start = &to->begin;
    to->until.command_case = MENISCUS__REQUEST__COMMAND_RUN_UNTIL;
    to->until.run_until = &to->when;
    to->shutdown.command_case = MENISCUS__REQUEST__COMMAND_SHUTDOWN;
    to->shutdown.shutdown = &to->leave;
    to->pause.command_case = MENISCUS__REQUEST__COMMAND_PAUSE;
    to->pause.pause = &to->halt;
    const MnsStatus status = load_init(&to->what, batch->file, error);
    to->what.name = batch->name;
    to->what.has_resume = true;
    to->what.resume = batch->options->resume;
    return status;
}

/* --- the run ----------------------------------------------------------------------------------------------------------- */

/* From a loaded case to where it shall stop. */
static MnsStatus go(Batch *batch, MnsError *error)
{
    RunStatus status;
    run_status(batch->run, &status);
    if (batch->signals.leaving || status.progress.t >= batch->options->until) return MNS_OK;
    const bool to_the_end = !(batch->options->until < status.end_time);
    const MnsStatus started = perform(batch, to_the_end ? serve_go : serve_until,
                                      to_the_end ? &batch->requests.start : &batch->requests.until, error);
    if (started == MNS_E_INVALID || started == MNS_E_LIMIT)
        return started; /* else it began, and the state says how it ended */
    if (batch->signals.leaving) return perform(batch, serve_pause, &batch->requests.pause, error);
    return perform(batch, serve_wait, NULL, error);
}

/* Run, look, leave. What is returned is why the run is not whole; a fault is in the outcome's status besides. */
static MnsStatus run_loaded(Batch *batch, Outcome *outcome, MnsError *error)
{
    MnsError left;
    MnsStatus status = go(batch, error);
    if (!status) status = perform(batch, serve_probes, NULL, error);
    memcpy(outcome->probes, batch->probes, sizeof outcome->probes);
    run_status(batch->run, &outcome->status);
    outcome->document = run_document(batch->run);
    memcpy(outcome->directory, batch->directory, sizeof outcome->directory);
    const MnsStatus leaving = perform(batch, serve_leave, &batch->requests.shutdown, &left);
    if (!status && leaving) *error = left;
    return status ? status : leaving;
}

static MnsStatus run_case(Batch *batch, Outcome *outcome, MnsError *error)
{
    const RunOptions options = {.directory = batch->directory, .threads = -1};
    MnsStatus status = run_new(&options, &batch->run, error);
    if (status) return status;
    bar_begin(&batch->bar);
    status = perform(batch, serve_load, &batch->requests.load, error);
    if (status == MNS_E_INVALID || status == MNS_E_LIMIT || status == MNS_E_MEMORY)
        case_file_locate(batch->file, error);
    if (!status) status = run_loaded(batch, outcome, error);
    else perform(batch, serve_leave, &batch->requests.shutdown, &(MnsError){.status = MNS_OK});
    bar_end(&batch->bar);
    run_join(batch->run);
    take_notes(batch, NULL);
    run_free(batch->run);
    return status;
}

static int exit_code(const Batch *batch, const Outcome *outcome)
{
    const MnsStatus fault = outcome->status.fault.status, status = fault ? fault : outcome->error.status;
    if (fault == MNS_E_INVALID)
        return MNS_EXIT_DIVERGED; /* a formula lost its value on the way: the flow cannot go on */
    switch (status) {
    case MNS_OK: return batch->signals.leaving && outcome->status.state != RUN_DONE ? MNS_EXIT_AGAIN : MNS_EXIT_DONE;
    case MNS_E_INTERRUPTED: return MNS_EXIT_AGAIN;
    case MNS_E_STATE: return outcome->document ? MNS_EXIT_FAILED : MNS_EXIT_AGAIN; /* another run has the directory */
    case MNS_E_DIVERGED: return MNS_EXIT_DIVERGED;
    case MNS_E_IO:
    case MNS_E_NO_SPACE:
    case MNS_E_CORRUPT: return MNS_EXIT_IO;
    case MNS_E_INVALID:
    case MNS_E_NOT_FOUND: return outcome->document ? MNS_EXIT_FAILED : MNS_EXIT_BAD_CASE;
    case MNS_E_LIMIT: return outcome->document ? MNS_EXIT_FAILED : MNS_EXIT_BAD_CASE;
    default: return MNS_EXIT_FAILED;
    }
}

void batch_misused(int code, int argc, char *const *argv, const MnsError *error)
{
    const MnsError usage = {.status = MNS_E_INVALID, .text = "the command line is wrong; standard error says what is"};
    if (!script_wants_json(argc, argv)) return;
    if (*error->text) outcome_print_refusal(error, outcome_hint(error->status), code);
    else outcome_print_refusal(&usage, "`meniscusd --help` lists the options", code);
}

static void finish(Batch *batch, Outcome *outcome)
{
    MnsError error;
    outcome->code = exit_code(batch, outcome);
    if (outcome_print(outcome, batch->options->json, &error)) {
        outcome_complain(batch->path, &error);
        outcome->code = MNS_EXIT_IO;
    }
}

int batch_run(const BatchOptions *options)
{
    Batch batch = {.options = options};
    Outcome outcome = {.document = NULL};
    signals_catch(&batch.signals);
    outcome.status.progress.t = outcome.status.end_time = outcome.status.wall = NAN;
    outcome.status.ns_per_particle_step = NAN;
    MnsStatus status = read_case(&batch, &outcome.error);
    if (!status) status = make_requests(&batch, &outcome.error);
    if (!status) status = run_case(&batch, &outcome, &outcome.error);
    if (!status) outcome.error.status = MNS_OK;
    if (status && !outcome.status.fault.status) /* of a fault, and of what was lost with it, the log has told */
        outcome_complain(batch.path, &outcome.error);
    finish(&batch, &outcome);
    outcome_done(&outcome);
    load_done(&batch.requests.what);
    free(batch.settings);
    case_file_free(batch.file);
    signals_done(&batch.signals);
    return outcome.code;
}
