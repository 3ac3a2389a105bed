/* SPDX-License-Identifier: BSD-3-Clause */
/* The thread that listens to the daemon. When the daemon goes away, it says so and looks for it until it is back. */
#include "client/dashboard/watcher.h"
#include "client/cli/output.h"
#include "client/dashboard/about.h"
#include "client/dashboard/diary.h"
#include <dirent.h>
#include <fnmatch.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

static const double tick_s = 0.05;  /* samples go to browsers at least this far apart */
static const double status_s = 1;   /* between looks at the status                     */
static const double patience_s = 5; /* for an answer that a daemon gives at once       */
static const double away_s = 0.4;   /* without a connection, after which the daemon is missed */
static const double repeat_s = 2;   /* after subscribing the last message comes again  */
enum { BATCH = 200 };               /* samples of one tick; more are in the history    */

/* What was heard of a topic. */
typedef struct Heard {
    uint64_t epoch, sequence; /* of the latest message: it comes again when somebody subscribes */
    bool since;               /* anything since subscribing */
} Heard;

typedef struct Watcher {
    Hub *hub;
    MnsClient *client;
    uint64_t epoch, version; /* of what was told last */
    char directory[4096];    /* of the run            */
    MnsState state;
    bool told;        /* all of what the daemon can do and what that case is, to the end */
    bool acquainted;  /* we have seen the daemon before */
    bool has_backlog; /* the run is new to us, and was under way before */
    Heard events, log;
    json_t *diary; /* texts of what was told from the log of the run: news that are old tell the last of them again */
    double subscribed;
    json_t *names; /* of the samples of this tick; NULL: none */
    json_t *units, *rows;
    uint64_t unsent; /* samples of this tick beyond BATCH */
    double looked;
} Watcher;

static double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static json_t *wall_clock(void)
{
    char text[32];
    struct tm utc;
    const time_t now = time(NULL);
    strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &utc));
    return json_string(text);
}

static void tell_daemon(Watcher *watcher, const MnsError *error)
{
    json_t *object = json_pack("{ss ss sb}", "topic", "daemon", "name", hub_daemon(watcher->hub), "alive", !error);
    if (error) json_object_update_new(object, output_failure(error, mns_status_hint(error->status), 0));
    hub_tell(watcher->hub, TELL_DAEMON, object);
}

/* --- samples ----------------------------------------------------------------------------------------------------------- */

static void flush(Watcher *watcher)
{
    if (!watcher->rows) return;
    hub_tell(watcher->hub, TELL_SAMPLES,
             json_pack("{ss so so so sI}", "topic", "samples", "names", watcher->names, "units", watcher->units, "rows",
                       watcher->rows, "unsent", (json_int_t)watcher->unsent));
    watcher->names = watcher->units = watcher->rows = NULL;
    watcher->unsent = 0;
}

static bool same_names(const json_t *names, const MnsTelemetry *message)
{
    if (json_array_size(names) != message->n_values) return false;
    for (size_t k = 0; k < message->n_values; k++)
        if (strcmp(json_string_value(json_array_get(names, k)), message->values[k].name) != 0) return false;
    return true;
}

static void take_sample(Watcher *watcher, const MnsTelemetry *message)
{
    hub_sample(watcher->hub, message->time, message->n_values, message->values);
    if (watcher->rows && !same_names(watcher->names, message)) flush(watcher);
    if (!watcher->rows) {
        watcher->rows = json_array();
        watcher->names = json_array();
        watcher->units = json_array();
        for (size_t k = 0; k < message->n_values; k++) {
            json_array_append_new(watcher->names, json_string(message->values[k].name));
            json_array_append_new(watcher->units, json_string(message->values[k].unit));
        }
    }
    if (json_array_size(watcher->rows) == BATCH) {
        watcher->unsent++;
        return;
    }
    json_t *row = json_array();
    json_array_append_new(row, output_number(message->time));
    for (size_t k = 0; k < message->n_values; k++) json_array_append_new(row, output_number(message->values[k].number));
    json_array_append_new(watcher->rows, row);
}

/* --- the run ----------------------------------------------------------------------------------------------------------- */

bool watcher_is_settled(MnsState state)
{
    return state == MNS_STATE_READY || state == MNS_STATE_RUNNING || state == MNS_STATE_PAUSED ||
           state == MNS_STATE_DONE || state == MNS_STATE_FAULT;
}

/* What the daemon can do and what the case is, and the probes as they are now: telemetry tells of the next sample. */
static MnsStatus tell_about(Watcher *watcher, const MnsReply *status, MnsError *error)
{
    json_t *about = NULL;
    const MnsStatus failed = about_ask(watcher->client, status, &about, error);
    if (failed) return failed;
    hub_renew(watcher->hub);
    json_object_set_new(about, "generation", json_integer((json_int_t)hub_generation(watcher->hub)));
    hub_tell(watcher->hub, TELL_ABOUT, about);
    MnsReply *probes = NULL;
    /* Of a run that is loaded or comes back after a crash the answer would have to be waited for; it is news again when it is there. */
    if (watcher_is_settled(status->state) &&
        mns_client_query_probes(watcher->client, 0, NULL, &probes, NULL) == MNS_OK) {
        const MnsTelemetry sample = {.time = probes->time, .n_values = probes->n_values, .values = probes->values};
        take_sample(watcher, &sample);
    }
    mns_reply_free(probes);
    return MNS_OK;
}

/* Is it another run, or one that is new to us, rather than the same with something set? */
static bool is_other(const Watcher *watcher, const MnsReply *reply)
{
    return reply->daemon_epoch != watcher->epoch || strcmp(reply->info->run_directory, watcher->directory) != 0 ||
           reply->case_version < watcher->version;
}

static bool has_case(MnsState state)
{
    return state != MNS_STATE_EMPTY && state != MNS_STATE_LOADING && state != MNS_STATE_STOPPING;
}

/* By its size a browser knows whether there is more in the journal than it has read. */
static json_t *journal_bytes(const Watcher *watcher)
{
    char path[4200];
    struct stat info;
    snprintf(path, sizeof path, "%s/journal", watcher->directory);
    const bool known = *watcher->directory && !hub_is_far(watcher->hub) && stat(path, &info) == 0;
    return known ? json_integer((json_int_t)info.st_size) : json_null();
}

/* Is there a checkpoint to go back to? null where its files are not seen from here. */
static json_t *can_restore(const Watcher *watcher)
{
    DIR *dir = *watcher->directory && !hub_is_far(watcher->hub) ? opendir(watcher->directory) : NULL;
    bool found = false;
    if (!dir) return json_null();
    for (const struct dirent *entry; !found && (entry = readdir(dir));)
        found = fnmatch("checkpoint-*.hdf", entry->d_name, 0) == 0;
    closedir(dir);
    return json_boolean(found);
}

static MnsStatus look(Watcher *watcher, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = mns_client_status(watcher->client, &reply, error);
    if (!status && !reply->info) status = mns_fail(error, MNS_E_VERSION, "the daemon's status is empty");
    if (status) {
        mns_reply_free(reply);
        return status;
    }
    const bool other = is_other(watcher, reply);
    const bool news = !watcher->told || other || reply->case_version != watcher->version ||
                      has_case(reply->state) != has_case(watcher->state);
    if (other) {
        flush(watcher);
        hub_forget(watcher->hub);
        if (!watcher->acquainted && !hub_is_far(watcher->hub))
            watcher->diary = diary_tell(watcher->hub, reply->info->run_directory);
        watcher->acquainted = true; /* what comes from now on is heard */
    }
    watcher->epoch = reply->daemon_epoch;
    watcher->version = reply->case_version;
    watcher->state = reply->state;
    snprintf(watcher->directory, sizeof watcher->directory, "%s", reply->info->run_directory);
    hub_set_directory(watcher->hub, watcher->directory);
    json_t *told = output_info(reply->info);
    json_object_set_new(told, "topic", json_string("status"));
    json_object_set_new(told, "daemon_epoch", json_integer((json_int_t)reply->daemon_epoch));
    json_object_set_new(told, "journal_bytes", journal_bytes(watcher));
    json_object_set_new(told, "can_restore", can_restore(watcher));
    if (news) status = tell_about(watcher, reply, error);
    watcher->told = !status; /* what could not be asked is asked again with the next look */
    watcher->has_backlog = watcher->has_backlog || other;
    if (!status && watcher->has_backlog && watcher_is_settled(reply->state)) {
        if (reply->step) backlog_start(watcher->hub, reply->time);
        watcher->has_backlog = false;
    }
    hub_tell(watcher->hub, TELL_STATUS, told);
    watcher->looked = now_s();
    mns_reply_free(reply);
    return status;
}

static bool is_told(const json_t *texts, const char *text)
{
    size_t k;
    json_t *told;
    json_array_foreach(texts, k, told) if (text && !strcmp(json_string_value(told), text)) return true;
    return false;
}

static MnsStatus take_news(Watcher *watcher, const MnsTelemetry *message, MnsError *error)
{
    Heard *heard = message->topic == MNS_TOPIC_EVENT ? &watcher->events : &watcher->log;
    /* Nobody knows when that was which happened before we listened. */
    const bool is_old = !heard->since && now_s() - watcher->subscribed < repeat_s;
    const bool is_known = message->daemon_epoch == heard->epoch && message->sequence <= heard->sequence;
    heard->since = true;
    if (is_known) return MNS_OK;
    heard->epoch = message->daemon_epoch;
    heard->sequence = message->sequence;
    if (is_old && is_told(watcher->diary, message->text)) return MNS_OK;
    json_t *told = output_telemetry(message);
    json_object_set_new(told, "when", is_old ? json_null() : wall_clock());
    hub_tell(watcher->hub, TELL_EVENT, told);
    if (message->topic != MNS_TOPIC_EVENT) return MNS_OK;
    hub_renew(watcher->hub);
    return look(watcher, error);
}

static MnsStatus take(Watcher *watcher, const MnsTelemetry *message, MnsError *error)
{
    switch (message->topic) {
    case MNS_TOPIC_PROBE: take_sample(watcher, message); return MNS_OK;
    case MNS_TOPIC_PROGRESS: hub_tell(watcher->hub, TELL_PROGRESS, output_telemetry(message)); return MNS_OK;
    default: return take_news(watcher, message, error);
    }
}

/* Messages of one tick, then what is due. */
static MnsStatus tick(Watcher *watcher, MnsError *error)
{
    const double end = now_s() + tick_s;
    MnsStatus status = MNS_OK;
    for (double left = tick_s; left > 0 && !status; left = end - now_s()) {
        MnsTelemetry *message = NULL;
        status = mns_client_next(watcher->client, left, &message, error);
        if (!status) status = take(watcher, message, error);
        mns_telemetry_free(message);
        if (status == MNS_E_TIMEOUT || status == MNS_E_INTERRUPTED || status == MNS_E_CORRUPT) status = MNS_OK;
    }
    flush(watcher);
    if (!status && mns_client_away(watcher->client) > away_s)
        status = mns_fail(error, MNS_E_UNAVAILABLE, "the daemon went away");
    if (!status && now_s() - watcher->looked > status_s) status = look(watcher, error);
    return status;
}

/* From the connection to its loss. */
static void attend(Watcher *watcher, MnsError *error)
{
    MnsStatus status = mns_client_open(hub_daemon(watcher->hub), &watcher->client, error);
    if (status) return;
    mns_client_set_timeout(watcher->client, patience_s);
    mns_client_set_reconnect(watcher->client, away_s);
    status = mns_client_subscribe(watcher->client, MNS_TOPIC_ALL, error);
    watcher->events.since = watcher->log.since = false;
    watcher->subscribed = now_s();
    if (!status) status = look(watcher, error);
    if (!status) tell_daemon(watcher, NULL);
    while (!status) status = tick(watcher, error);
    mns_client_close(watcher->client);
    watcher->client = NULL;
}

static void *live(void *arg)
{
    Watcher watcher = {.hub = arg};
    const struct timespec pause = {.tv_sec = 1};
    for (;;) {
        MnsError error = {0};
        attend(&watcher, &error);
        tell_daemon(&watcher, &error);
        nanosleep(&pause, NULL);
    }
    return NULL;
}

MnsStatus watcher_start(Hub *hub, MnsError *error)
{
    pthread_t thread;
    if (pthread_create(&thread, NULL, live, hub)) return mns_fail(error, MNS_E_LIMIT, "the system gives no thread");
    pthread_detach(thread);
    return MNS_OK;
}
