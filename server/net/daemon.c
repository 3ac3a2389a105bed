/* SPDX-License-Identifier: BSD-3-Clause */
/* The daemon: what wakes it is a socket, a signal, or news of the run; then it looks after all three and sleeps again. */
#include "net/daemon.h"

#include "base/log.h"
#include "base/signals.h"
#include "common/case/file.h"
#include "common/case/find.h"
#include "common/case/load.h"
#include "common/case/name.h"
#include "common/host/open_files.h"
#include "common/host/places.h"
#include "common/wire/frame.h"
#include "net/comeback.h"
#include "net/crowd.h"
#include "net/describe.h"
#include "net/desk.h"
#include "net/handlers.h"
#include "net/notify.h"
#include <limits.h>
#include <math.h>
#include <meniscus/exit.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SOLVER_NICE = 10 }; /* the solver's threads yield to those that answer people */

typedef struct Daemon {
    const DaemonOptions *options;
    Endpoint endpoint;
    Desk *desk;
    Run *run;
    Http *http; /* NULL if it is not served                */
    Notify notify;
    CaseFile *file;       /* of --load; NULL without one        */
    MnsError bad_case;    /* why it cannot be read              */
    const Exchange *load; /* under way                         */
    Comeback comeback;
    Order unread;             /* that there was a run, which cannot be read */
    const Exchange *recovery; /* under way */
    Signals signals;
    bool leaving; /* the run has come to its end       */
    int code;
    char path[4096]; /* of the case of --load */
    char *asked;     /* the case of the command line, with its settings; NULL without one */
    char parent[RUNDIR_PATH];
    int held; /* lets go of it when closed; -1: it is not ours */
} Daemon;

static const Who OURSELVES = {WHO_DAEMON, ROLE_ADMIN};

/* --- requests of our own ----------------------------------------------------------------------------------------------- */

/* Post a copy of a request, whose reply nobody reads. NULL if that was not possible. */
static const Exchange *post(Daemon *daemon, const Meniscus__Request *request, const Lineage *lineage)
{
    MnsError error;
    const size_t size = meniscus__request__get_packed_size(request);
    uint8_t *packed = malloc(size + 1);
    if (!packed) return NULL;
    meniscus__request__pack(request, packed);
    Meniscus__Request *copy = meniscus__request__unpack(NULL, size, packed);
    free(packed);
    Exchange *exchange = copy ? exchange_new(copy, &OURSELVES) : NULL;
    if (exchange) exchange->order.lineage = lineage;
    if (exchange) exchange->order.leads = request->command_case == MENISCUS__REQUEST__COMMAND_LOAD;
    if (!exchange || !handle(daemon->run, exchange, &error)) return exchange;
    log_line(LOG_ERROR, "%s", error.text);
    exchange_free(exchange);
    return NULL;
}

static void post_shutdown(Daemon *daemon, bool checkpoint)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Shutdown shutdown = MENISCUS__SHUTDOWN__INIT;
    shutdown.has_checkpoint = true;
    shutdown.checkpoint = checkpoint;
    request.command_case = MENISCUS__REQUEST__COMMAND_SHUTDOWN;
    request.shutdown = &shutdown;
    notify_stopping();
    post(daemon, &request, NULL);
}

static void post_checkpoint(Daemon *daemon)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__CheckpointNow checkpoint = MENISCUS__CHECKPOINT_NOW__INIT;
    request.command_case = MENISCUS__REQUEST__COMMAND_CHECKPOINT;
    request.checkpoint = &checkpoint;
    post(daemon, &request, NULL);
}

static void post_start(Daemon *daemon)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Start start = MENISCUS__START__INIT;
    request.command_case = MENISCUS__REQUEST__COMMAND_START;
    request.start = &start;
    post(daemon, &request, NULL);
}

/* --- the case of the command line ---------------------------------------------------------------------------------------- */

static MnsStatus note_asked(Daemon *daemon, MnsError *error)
{
    const DaemonOptions *options = daemon->options;
    size_t size;
    char whole[PATH_MAX];
    FILE *text = open_memstream(&daemon->asked, &size);
    if (!text) return mns_fail(error, MNS_E_MEMORY, "no memory for the command line");
    fprintf(text, "%s\n", realpath(daemon->path, whole) ? whole : daemon->path);
    for (size_t k = 0; k < options->n_settings; k++) fprintf(text, "%s\n", options->settings[k]);
    if (!fclose(text)) return MNS_OK;
    return mns_fail(error, MNS_E_MEMORY, "no memory for the command line");
}

static MnsStatus read_case(Daemon *daemon, MnsError *error)
{
    const DaemonOptions *options = daemon->options;
    MnsStatus status = case_find(options->load, daemon->path, error);
    if (!status) status = note_asked(daemon, error);
    if (!status)
        status = case_file_read_with(daemon->path, options->n_settings, (const char *const *)options->settings,
                                     &daemon->file, error);
    return status;
}

static void post_load(Daemon *daemon)
{
    char name[CASE_NAME_SIZE];
    case_name_from_path(daemon->path, name);
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Load load;
    if (load_init(&load, daemon->file, NULL)) return;
    load.name = name;
    load.has_resume = true;
    load.resume = daemon->options->resume;
    request.command_case = MENISCUS__REQUEST__COMMAND_LOAD;
    request.load = &load;
    daemon->load = post(daemon, &request, NULL);
    load_done(&load);
}

/* The case of the command line is loaded, or the daemon has no purpose. */
static void after_load(Daemon *daemon, Order *order)
{
    daemon->load = NULL;
    if (!order->status && daemon->options->start) post_start(daemon);
    if (!order->status || order->status == MNS_E_INTERRUPTED) return; /* somebody has called it off */
    const bool bad = order->status == MNS_E_INVALID || order->status == MNS_E_LIMIT;
    const bool taken = order->status == MNS_E_STATE; /* the run directory, by another run */
    if (bad) case_file_locate(daemon->file, &order->error);
    log_line(LOG_ERROR, "%s", order->error.text);
    daemon->code = bad ? MNS_EXIT_BAD_CASE : taken ? MNS_EXIT_FAILED : MNS_EXIT_IO;
    post_shutdown(daemon, false);
}

/* --- after a crash ------------------------------------------------------------------------------------------------------ */

static void post_recovery(Daemon *daemon)
{
    Meniscus__Request request;
    Meniscus__Load load;
    comeback_request(&daemon->comeback, &request, &load);
    log_line(LOG_NOTICE, "going on with %s, which was not ended", daemon->comeback.directory);
    daemon->recovery = post(daemon, &request, &daemon->comeback.lineage);
    if (daemon->recovery)
        comeback_scheduled(&daemon->comeback, desk_answers(daemon->desk)); /* before anything sets it in motion */
    Meniscus__Request *resume = daemon->recovery ? comeback_resume(&daemon->comeback) : NULL;
    if (resume)
        post(daemon, resume, &daemon->comeback.lineage); /* now, so that a pause that comes meanwhile calls it off */
    request_free(resume);
    if (daemon->recovery && daemon->options->start && daemon->comeback.lineage.untouched) post_start(daemon);
    Meniscus__Request *rest = daemon->recovery ? comeback_rest(&daemon->comeback) : NULL;
    if (rest)
        answers_take_alone(desk_answers(daemon->desk), &OURSELVES, rest,
                           &daemon->comeback.lineage); /* before its sender asks again */
}

static void give_up(Daemon *daemon, const MnsError *why, int code)
{
    log_line(LOG_ERROR, "%s", why->text);
    daemon->code = code;
    post_shutdown(daemon, false);
}

static void serve_unread(Run *run, Order *order)
{
    run_unread(run, order, &order->error);
}

/* So that people far away can see what is wrong: started again and again the daemon would say it to nobody, and be given up. */
static void stay(Daemon *daemon, const MnsError *why)
{
    log_line(LOG_ERROR, "%s", why->text);
    daemon->unread = (Order){.serve = serve_unread, .deadline = INFINITY, .error = *why};
    run_post(daemon->run, &daemon->unread, NULL);
}

static void refuse_case(Daemon *daemon)
{
    give_up(daemon, &daemon->bad_case, MNS_EXIT_BAD_CASE);
}

/* Whoever began anew would lose what the run has, and forget it by the next crash. A service says so and stays; who came for one case may give the
 * same command again, if another has the directory. */
static void after_recovery(Daemon *daemon, const Order *order)
{
    MnsError why;
    daemon->recovery = NULL;
    if (!order->status) return;
    mns_fail(&why, order->status, "no run is gone on with: %.400s%s", order->error.text,
             order->status == MNS_E_NO_SPACE ? "; make room and start the daemon again, and nothing is lost" : "");
    if (order->status == MNS_E_INTERRUPTED) log_line(LOG_ERROR, "%s", why.text); /* somebody has called it off */
    else if (daemon->bad_case.status) refuse_case(daemon);
    else if (daemon->options->load) give_up(daemon, &why, order->status == MNS_E_STATE ? MNS_EXIT_AGAIN : MNS_EXIT_IO);
    else stay(daemon, &why);
}

/* The same command line goes on with the run that a crash has ended, whatever has become of the case file; another one is for another
 * case. */
static void post_first(Daemon *daemon)
{
    const Comeback *comeback = &daemon->comeback;
    const bool asked = daemon->options->load != NULL;
    if (comeback->due && asked && !comeback->same)
        log_line(LOG_NOTICE, "%s was not ended; it is left for the case of --load. Without --load it is gone on with",
                 comeback->directory);
    const bool back = comeback->due && (!asked || comeback->same);
    if (back && daemon->bad_case.status) log_line(LOG_WARNING, "%s", daemon->bad_case.text);
    if (back) post_recovery(daemon);
    else if (daemon->bad_case.status) refuse_case(daemon);
    else if (asked) post_load(daemon);
}

/* --- what happens -------------------------------------------------------------------------------------------------------- */

static void take_signal(Daemon *daemon)
{
    switch (signals_take(&daemon->signals)) {
    case SIGNAL_NOTHING: break;
    case SIGNAL_CHECKPOINT: post_checkpoint(daemon); break;
    case SIGNAL_LEAVE: post_shutdown(daemon, true); break;
    case SIGNAL_INSIST: _exit(MNS_EXIT_FAILED);
    }
}

static void take_answer(Daemon *daemon, Order *order)
{
    if (order == &daemon->unread) return;
    Exchange *exchange = (Exchange *)order;
    /* A shutdown that was too late, or for another step, has done nothing: the run goes on, and so do we. */
    const bool last = exchange->handler && exchange->handler->traits & LAST && order->state == RUN_STOPPING;
    if (exchange == daemon->load) after_load(daemon, order);
    else if (exchange == daemon->recovery) after_recovery(daemon, order);
    else if (order->status && !exchange->n_senders) log_line(LOG_WARNING, "%s", order->error.text);
    if (last && !daemon->leaving && order->status)
        daemon->code = MNS_EXIT_IO; /* of others it is only told that we leave */
    if (last) {
        daemon->leaving = true;
        endpoint_leave(&daemon->endpoint); /* before anybody knows */
    }
    answers_reply(desk_answers(daemon->desk), exchange);
}

static void show(Daemon *daemon, const Note *note)
{
    char text[256];
    snprintf(text, sizeof text, "%s at t = %.5g s, step %lu", run_state_name(note->state), note->t,
             (unsigned long)note->step);
    if (note->kind == NOTE_EVENT || note->kind == NOTE_PROGRESS)
        notify_status(&daemon->notify, note->kind == NOTE_EVENT, text);
    desk_tell(daemon->desk, note);
}

static void take_notes(Daemon *daemon)
{
    for (Note *note; (note = outbox_take(run_outbox(daemon->run)));) {
        if (note->kind == NOTE_ANSWER) {
            take_answer(daemon, note->order); /* and with it the note */
            continue;
        }
        if (note->kind == NOTE_SCHEDULED) {
            answers_scheduled(desk_answers(daemon->desk), (Exchange *)note->order);
            continue;
        }
        show(daemon, note);
        note_free(note);
    }
}

static void serve(Daemon *daemon)
{
    const int fds[2] = {run_outbox(daemon->run)->wake, daemon->signals.fd};
    const long tick = daemon->notify.watchdog > 0 ? (long)(250 * daemon->notify.watchdog) + 1 : 5000;
    while (!daemon->leaving) {
        const unsigned ready = desk_poll(daemon->desk, fds, tick);
        if (ready & 2) take_signal(daemon);
        desk_receive(daemon->desk);
        take_notes(daemon);
        notify_look(&daemon->notify, daemon->run);
    }
    run_join(daemon->run);
    take_notes(daemon);
}

/* --- beginning and end --------------------------------------------------------------------------------------------------- */

/* Where runs get their directories: made now, so that a place that cannot be used is known before anybody loads a case, and
 * written from the root, so that replies mean the same wherever who reads them is. */
static MnsStatus make_parent(Daemon *daemon, MnsError *error)
{
    size_t made;
    char whole[PATH_MAX];
    const MnsStatus status = rundir_make(daemon->parent, &made, error);
    if (status) return status;
    if (!realpath(daemon->parent, whole) || strlen(whole) >= sizeof daemon->parent)
        return mns_fail(error, MNS_E_IO, "cannot find the way from the root to '%.300s'; choose another --state-dir",
                        daemon->parent);
    memcpy(daemon->parent, whole, strlen(whole) + 1);
    return MNS_OK;
}

/* Two daemons would each take the other's run for one that a crash has ended. A full disk is no reason to stay away from the runs that are to
 * be mended. */
static MnsStatus hold_parent(Daemon *daemon, MnsError *error)
{
    const MnsStatus status = rundir_hold(daemon->parent, &daemon->held, error);
    if (status != MNS_E_NO_SPACE) return status;
    log_line(LOG_WARNING, "%s; who else uses the directory is not known", error->text);
    return MNS_OK;
}

static MnsStatus find_parent(Daemon *daemon, MnsError *error)
{
    const char *given = daemon->options->state_dir;
    if (!given) return places_state(daemon->options->at.name, daemon->parent, sizeof daemon->parent, error);
    if (*given && strlen(given) < sizeof daemon->parent) {
        snprintf(daemon->parent, sizeof daemon->parent, "%s", given);
        return MNS_OK;
    }
    return mns_fail_at(error, MNS_E_INVALID, "state-dir",
                       "--state-dir takes the path of a directory, of 1 to %zu bytes; found %zu",
                       sizeof daemon->parent - 1, strlen(given));
}

static void serve_leave(Run *run, Order *order)
{
    run_leave(run, order, false);
}

static MnsStatus serve_http(Daemon *daemon, MnsError *error)
{
    if (!daemon->http) return MNS_OK;
    const HttpSources sources = {.name = daemon->options->at.name,
                                 .commit = describe_commit(),
                                 .compiler = describe_compiler(),
                                 .directory = daemon->parent,
                                 .run = daemon->run,
                                 .traffic = desk_traffic(daemon->desk)};
    return http_serve(daemon->http, &sources, error);
}

static MnsStatus begin(Daemon *daemon, MnsError *error)
{
    notify_begin(&daemon->notify);
    MnsStatus status = make_parent(daemon, error);
    if (!status) status = hold_parent(daemon, error);
    if (status) return status;
    const RunOptions options = {.parent = daemon->parent,
                                .nice = SOLVER_NICE,
                                .threads = daemon->options->threads,
                                .stream_memory = daemon->options->stream_memory / 2,
                                .asked = daemon->asked,
                                .beat_interval = daemon->notify.watchdog / 4,
                                .figures = http_figures(daemon->http)};
    status = run_new(&options, &daemon->run, error);
    if (status) return status;
    status = desk_new(&daemon->endpoint, daemon->run, &daemon->desk, error);
    if (!status) status = serve_http(daemon, error);
    if (!status) return MNS_OK;
    desk_free(daemon->desk);
    Order leave = {.serve = serve_leave, .deadline = INFINITY};
    run_post(daemon->run, &leave, NULL);
    run_join(daemon->run);
    run_free(daemon->run);
    return status;
}

/* Was the run that was loaded last asked for as now? */
static bool asked_before(Daemon *daemon)
{
    char directory[RUNDIR_PATH];
    bool same;
    return daemon->asked && !rundir_current(daemon->parent, daemon->asked, directory, &same, NULL) && same;
}

static int refused(const MnsError *error, int code)
{
    log_line(LOG_ERROR, "%s", error->text);
    return code;
}

/* What people should do about it: call the program otherwise, or mend a file or an address. */
static int code_of_place(MnsStatus status)
{
    if (status == MNS_E_INVALID || status == MNS_E_LIMIT) return MNS_EXIT_USAGE;
    return status == MNS_E_IO ? MNS_EXIT_IO : MNS_EXIT_FAILED;
}

static int serve_locked(Daemon *daemon)
{
    MnsError error;
    MnsStatus status = http_open(&daemon->options->http, &daemon->http, &error);
    if (status) return refused(&error, code_of_place(status));
    status = begin(daemon, &error);
    const bool disk = status == MNS_E_IO || status == MNS_E_NO_SPACE;
    if (status == MNS_E_STATE && daemon->held < 0) return refused(&error, MNS_EXIT_AGAIN);
    if (status) return refused(&error, disk ? MNS_EXIT_IO : MNS_EXIT_FAILED);
    status = comeback_begin(&daemon->comeback, daemon->parent, daemon->asked, desk_answers(daemon->desk), &error);
    const bool gone = status == MNS_E_NOT_FOUND; /* it may be elsewhere, and starting again would not bring it */
    if (status && daemon->options->load && !gone) give_up(daemon, &error, MNS_EXIT_IO);
    else if (status) stay(daemon, &error);
    else post_first(daemon);
    const Endpoint *at = &daemon->endpoint;
    log_line(LOG_INFORMATION, "listening at %s%s%s%s%s", at->control, at->tcp_control[0] ? " and " : "",
             at->tcp_control, at->far_control[0] ? " and, for those who have a key, at " : "", at->far_control);
    notify_ready();
    serve(daemon);
    http_stop(daemon->http);
    desk_end_streams(daemon->desk);
    run_free(daemon->run);
    desk_free(daemon->desk);
    comeback_done(&daemon->comeback);
    return daemon->code;
}

static void forget_case(Daemon *daemon)
{
    case_file_free(daemon->file);
    free(daemon->asked);
}

int daemon_run(const DaemonOptions *options)
{
    MnsError error;
    Daemon daemon = {.options = options, .code = MNS_EXIT_DONE, .held = -1};
    MnsStatus status = find_parent(&daemon, &error);
    if (status) return refused(&error, code_of_place(status));
    if (options->load && read_case(&daemon, &daemon.bad_case) && !asked_before(&daemon)) {
        forget_case(&daemon);
        return refused(&daemon.bad_case, MNS_EXIT_BAD_CASE);
    }
    status = endpoint_open(&options->at, &daemon.endpoint, &error);
    if (status) {
        forget_case(&daemon);
        return refused(&error, code_of_place(status));
    }
    crowd_begin(&daemon.endpoint, open_files_raise(INT_MAX));
    signals_catch(&daemon.signals);
    const int code = serve_locked(&daemon);
    http_free(daemon.http);
    if (daemon.held >= 0) close(daemon.held);
    endpoint_close(&daemon.endpoint);
    forget_case(&daemon);
    signals_done(&daemon.signals);
    return code;
}
