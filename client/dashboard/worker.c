/* SPDX-License-Identifier: BSD-3-Clause */
/* A thread for each command under way, as some take hours. */
#include "client/cli/output.h"
#include "client/dashboard/journal.h"
#include "client/dashboard/watcher.h"
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

static const double quick_s = 60; /* for commands that cannot rightly take longer */

typedef struct Work {
    Hub *hub;
    uint64_t browser;
    Ask ask;
} Work;

json_t *worker_refusal(uint64_t id, const MnsError *error)
{
    json_t *answer = json_pack("{ss sI}", "topic", "reply", "id", (json_int_t)id);
    json_object_update_new(answer, output_failure(error, mns_status_hint(error->status), 0));
    return answer;
}

static json_t *success(const Ask *ask, const MnsReply *reply)
{
    json_t *answer = output_reply(reply);
    json_object_set_new(answer, "topic", json_string("reply"));
    json_object_set_new(answer, "id", json_integer((json_int_t)ask->id));
    json_object_set_new(answer, "path", reply->output ? json_string(reply->output->path) : json_null());
    json_object_set_new(answer, "lease_epoch",
                        reply->lease_epoch ? json_integer((json_int_t)reply->lease_epoch) : json_null());
    return answer;
}

/* How far what was ended on request has come. */
static json_t *broken_off(const Ask *ask, MnsClient *client, const MnsError *error)
{
    MnsReply *now = NULL;
    json_t *answer = worker_refusal(ask->id, error);
    mns_client_set_timeout(client, quick_s);
    if (mns_client_status(client, &now, NULL)) return answer;
    json_object_update_new(answer, json_pack("{ss sI so}", "state", mns_state_name(now->state), "step",
                                             (json_int_t)now->step, "time", output_number(now->time)));
    mns_reply_free(now);
    return answer;
}

static MnsStatus command(const Work *work, json_t **ret, MnsError *error)
{
    MnsClient *client = NULL;
    MnsReply *reply = NULL;
    MnsStatus status = mns_client_open(hub_daemon(work->hub), &client, error);
    const bool is_motion = work->ask.kind == ASK_STEP || work->ask.kind == ASK_RUN_UNTIL;
    const bool is_long = is_motion || work->ask.kind == ASK_LOAD;
    if (!status && !is_long) mns_client_set_timeout(client, quick_s);
    if (!status) mns_client_set_lease(client, work->ask.lease);
    if (!status) status = ask_call(&work->ask, client, &reply, error);
    if (!status) *ret = success(&work->ask, reply);
    if (status == MNS_E_INTERRUPTED && is_motion) {
        *ret = broken_off(&work->ask, client, error);
        status = MNS_OK;
    }
    mns_reply_free(reply);
    mns_client_close(client);
    return status;
}

static MnsStatus journal(const Work *work, json_t **ret, MnsError *error)
{
    char directory[4096];
    hub_directory(work->hub, directory);
    if (!*directory) return mns_fail(error, MNS_E_STATE, "there is no case, and so no journal");
    if (hub_is_far(work->hub))
        return mns_fail(error, MNS_E_NOT_FOUND,
                        "the journal is a file on the machine of the daemon: `meniscus log %.300s` prints it there",
                        directory);
    const MnsStatus status = journal_shown(directory, ret, error);
    if (status) return status;
    json_object_set_new(*ret, "topic", json_string("reply"));
    json_object_set_new(*ret, "id", json_integer((json_int_t)work->ask.id));
    return MNS_OK;
}

static void *live(void *arg)
{
    Work *work = arg;
    MnsError error = {0};
    json_t *answer = NULL;
    const MnsStatus status =
        work->ask.kind == ASK_JOURNAL ? journal(work, &answer, &error) : command(work, &answer, &error);
    hub_answer(work->hub, work->browser, status ? worker_refusal(work->ask.id, &error) : answer);
    hub_end_command(work->hub);
    ask_done(&work->ask);
    free(work);
    return NULL;
}

/* Takes the ask if it begins. */
static MnsStatus begin(Hub *hub, uint64_t browser, const Ask *ask, MnsError *error)
{
    pthread_t thread;
    Work *work = calloc(1, sizeof *work);
    if (!work) return mns_fail(error, MNS_E_MEMORY, "no memory for a command");
    *work = (Work){.hub = hub, .browser = browser, .ask = *ask};
    const int cause = pthread_create(&thread, NULL, live, work);
    if (!cause) {
        pthread_detach(thread);
        return MNS_OK;
    }
    free(work);
    return mns_fail(error, MNS_E_MEMORY, "no thread for a command: %s", strerror(cause));
}

MnsStatus worker_start(Hub *hub, uint64_t browser, Ask *ask, MnsError *error)
{
    const bool may = hub_begin_command(hub);
    const MnsStatus status =
        may ? begin(hub, browser, ask, error)
            : mns_fail(error, MNS_E_LIMIT, "%d commands are under way already; wait for one to end", HUB_COMMANDS);
    if (!status) return MNS_OK;
    if (may) hub_end_command(hub);
    ask_done(ask);
    return status;
}
