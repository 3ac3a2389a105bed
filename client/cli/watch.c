/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus watch: progress and probes of a run until it ends. On a terminal a picture redrawn in place, elsewhere plain
 * lines, with -o json every message of the daemon as one line. */
#include "client/cli/command.h"
#include "client/cli/output.h"
#include "client/cli/watch_screen.h"
#include "common/host/screen.h"
#include <math.h>
#include <signal.h>
#include <time.h>

static const double tick_s = 0.1;   /* between looks at signals, and between redraws */
static const double silence_s = 2;  /* after which we ask whether the daemon is still there */
static const double patience_s = 1; /* for probes that we ask for */

typedef struct Watch {
    Invocation *in;
    Screen screen;
    bool follow;
    double deadline; /* of --timeout, by command_clock() [s]; INFINITY: none */
    bool changed;    /* there is something to draw */
    double quiet;    /* time without a message [s] */
} Watch;

/* How long it may still take, as a limit for a request [s]. */
static double time_left(const Watch *watch)
{
    return isinf(watch->deadline) ? -1 : fmax(0, watch->deadline - command_clock());
}

/* The first look, and a later one after silence: what telemetry may have been sent before we listened. */
static MnsStatus look(Watch *watch, bool first, MnsError *error)
{
    MnsReply *status_reply = NULL, *probes = NULL;
    mns_client_set_timeout(watch->in->client, time_left(watch));
    MnsStatus status = mns_client_status(watch->in->client, &status_reply, error);
    if (status != MNS_OK) return status;
    if (status_reply->info) screen_take_info(&watch->screen, status_reply->info);
    if (first && watch->in->json && status_reply->info) {
        json_t *object = json_pack("{ss}", "topic", "status");
        json_object_update_new(object, output_info(status_reply->info));
        status = output_json(object, error);
    }
    /* Signals wait meanwhile, and while the run is loaded or comes back after a crash, so would this question: others come after silence. */
    mns_client_set_timeout(watch->in->client,
                           watch->deadline < command_clock() + patience_s ? time_left(watch) : patience_s);
    if (status_reply->state != MNS_STATE_EMPTY && status_reply->state != MNS_STATE_RECOVERING &&
        mns_client_query_probes(watch->in->client, 0, NULL, &probes, NULL) == MNS_OK)
        screen_take_reply(&watch->screen, probes);
    mns_reply_free(probes);
    mns_reply_free(status_reply);
    watch->changed = true;
    return status;
}

/* Is the run over? */
static bool is_over(const Watch *watch)
{
    switch (watch->screen.state) {
    case MNS_STATE_DONE:
    case MNS_STATE_FAULT:
    case MNS_STATE_EMPTY:
    case MNS_STATE_STOPPING: return !watch->follow;
    default: return false;
    }
}

/* What a daemon says again to whoever comes late, and what was under way when we looked, is from before that look; an event may also tell
 * that the run went back to a checkpoint or its beginning, and what comes after it is from there. The daemon knows which. */
static MnsStatus find_old(Watch *watch, const MnsTelemetry *message, bool *ret_old, MnsError *error)
{
    MnsStatus status = MNS_OK;
    const Screen *screen = &watch->screen;
    if (message->step < screen->step && message->topic == MNS_TOPIC_EVENT) status = look(watch, false, error);
    *ret_old = message->step < screen->step;
    return status;
}

static MnsStatus take(Watch *watch, const MnsTelemetry *message, MnsError *error)
{
    bool old;
    const MnsStatus status = find_old(watch, message, &old, error);
    if (status != MNS_OK || old) return status;
    screen_take(&watch->screen, message);
    watch->quiet = 0;
    if (watch->in->json) return output_json(output_telemetry(message), error);
    if (message->topic == MNS_TOPIC_EVENT && *watch->screen.news) screen_say(&watch->screen, watch->screen.news);
    watch->changed |= watch->screen.is_terminal || message->topic == MNS_TOPIC_PROGRESS;
    return MNS_OK;
}

/* Messages of one tick. */
static MnsStatus listen_once(Watch *watch, MnsError *error)
{
    const double end = fmin(command_clock() + tick_s, watch->deadline);
    double left = end - command_clock();
    while (left > 0 && !is_over(watch)) {
        MnsTelemetry *message = NULL;
        MnsStatus status = mns_client_next(watch->in->client, left, &message, error);
        if (status == MNS_OK) status = take(watch, message, error);
        mns_telemetry_free(message);
        if (status != MNS_OK && status != MNS_E_TIMEOUT && status != MNS_E_INTERRUPTED) return status;
        left = end - command_clock();
    }
    watch->quiet += tick_s;
    if (command_clock() >= watch->deadline && !is_over(watch))
        return mns_fail(error, MNS_E_TIMEOUT, "the run had not ended after %g s", watch->in->timeout);
    return MNS_OK;
}

/* What an event has printed counts too. */
static MnsStatus draw(Watch *watch, MnsError *error)
{
    if (watch->changed && !watch->in->json) screen_draw(&watch->screen);
    watch->changed = false;
    return screen_flush(error);
}

/* Until the run ends or a signal comes; *ret_signal is 0 or the signal, which is pending no more. */
static MnsStatus loop(Watch *watch, const sigset_t *signals, int *ret_signal, MnsError *error)
{
    MnsStatus status = look(watch, true, error);
    const struct timespec at_once = {0};
    *ret_signal = 0;
    while (status == MNS_OK && !is_over(watch) && *ret_signal == 0) {
        status = draw(watch, error);
        if (status == MNS_OK) status = listen_once(watch, error);
        if (status == MNS_OK && watch->quiet > silence_s) {
            status = look(watch, false, error);
            watch->changed = watch->screen.is_terminal;
            watch->quiet = 0;
        }
        const int signal = sigtimedwait(signals, NULL, &at_once);
        if (signal > 0) *ret_signal = signal;
    }
    watch->changed |= status == MNS_OK;
    return status == MNS_OK ? draw(watch, error) : (draw(watch, NULL), status);
}

/* The signals are blocked, so that they are seen between two messages and the terminal is restored before they take
 * effect. */
static MnsStatus watch_run(Watch *watch, MnsError *error)
{
    sigset_t signals;
    int signal;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGHUP);
    sigprocmask(SIG_BLOCK, &signals, NULL);
    screen_init(&watch->screen, !watch->in->json);
    MnsStatus status = loop(watch, &signals, &signal, error);
    screen_done(&watch->screen);
    sigprocmask(SIG_UNBLOCK, &signals, NULL);
    if (signal) raise(signal);
    const bool failed = status == MNS_OK && watch->screen.state == MNS_STATE_FAULT;
    return failed ? command_fault(watch->in, error) : status;
}

MnsStatus command_watch(Invocation *in, MnsError *error)
{
    Watch watch = {.in = in,
                   .follow = options_get(&in->options, OPT_FOLLOW),
                   .deadline = in->timeout < 0 ? INFINITY : command_clock() + in->timeout};
    MnsStatus status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_subscribe(in->client, MNS_TOPIC_ALL & ~MNS_TOPIC_LOG, error);
    return status == MNS_OK ? watch_run(&watch, error) : status;
}
