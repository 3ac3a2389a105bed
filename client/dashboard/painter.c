/* SPDX-License-Identifier: BSD-3-Clause */
/* The thread that fetches particles. Each question costs the solver a copy between two steps, so only what somebody waits for is asked,
 * nothing is asked twice of the same step, and never more often than was agreed, however many browsers there are. */
#include "client/cli/output.h"
#include "client/dashboard/watcher.h"
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double patience_s = 30; /* for a step to end                             */
static const double idle_s = 0.1;    /* between looks while nothing moves             */
static const double refused_s = 2;   /* before what was refused is asked again        */

/* What the daemon has refused, and is not asked for yet. */
typedef struct Refused {
    Wish wish;
    double until;
} Refused;

typedef struct Painter {
    Hub *hub;
    MnsClient *client;
    double interval;
    size_t turn; /* wishes are served one after the other */
    Refused refused[HUB_BROWSERS];
    size_t n_refused; /* ever: the latest take the place of the oldest */
} Painter;

static double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void rest(double seconds)
{
    if (seconds <= 0) return;
    const struct timespec pause = {.tv_sec = (time_t)seconds, .tv_nsec = (long)(1e9 * (seconds - floor(seconds)))};
    nanosleep(&pause, NULL);
}

static bool is_refused(const Painter *painter, const Wish *wish)
{
    for (size_t k = 0; k < painter->n_refused && k < HUB_BROWSERS; k++)
        if (painter->refused[k].until > now_s() && wish_equal(&painter->refused[k].wish, wish)) return true;
    return false;
}

/* Tell those who wait for it, and leave the daemon alone with it for a while. */
static void refuse(Painter *painter, const Wish *wish, const MnsError *error)
{
    painter->refused[painter->n_refused++ % HUB_BROWSERS] = (Refused){.wish = *wish, .until = now_s() + refused_s};
    json_t *object = json_pack("{ss ss sI sb}", "topic", "refused", "field", wish->field, "limit",
                               (json_int_t)wish->limit, "walls", (int)wish->walls);
    if (object) json_object_update_new(object, output_failure(error, mns_status_hint(error->status), 0));
    hub_tell(painter->hub, TELL_PASSING, object);
}

static bool is_gone(MnsStatus status)
{
    return status == MNS_E_UNAVAILABLE || status == MNS_E_VERSION;
}

static MnsStatus paint(Painter *painter, const Wish *wish, const MnsRunInfo *info, uint64_t generation, MnsError *error)
{
    const char *fields[3] = {"position", "phase", wish->field};
    const uint64_t all = wish->walls ? info->particles : info->fluid_particles;
    const MnsParticleQuery query = {.n_fields = strcmp(wish->field, "phase") != 0 ? 3 : 2,
                                    .fields = fields,
                                    .walls = wish->walls,
                                    .every = frame_every(all, wish->limit),
                                    .limit = UINT64_C(2) * FRAME_MOST};
    MnsReply *reply = NULL;
    Frame *frame = NULL;
    MnsStatus status = mns_client_query_particles(painter->client, &query, &reply, error);
    if (!status) status = frame_new(wish, (FrameKey){generation, reply->step}, query.every, all, reply, &frame, error);
    mns_reply_free(reply);
    if (!status) hub_show(painter->hub, frame);
    return status;
}

/* Serve the next demand that the run has something new for. *ret_painted: there was one. */
static MnsStatus serve(Painter *painter, size_t n, const Demand *demands, bool *ret_painted, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = MNS_OK;
    *ret_painted = false;
    /* Before the status: what changes in between is painted again. */
    const uint64_t generation = hub_generation(painter->hub);
    status = mns_client_status(painter->client, &reply, error);
    if (status) return status;
    const bool has = reply->info && watcher_is_settled(reply->state);
    /* A status is a little old; what is asked of a run in motion is answered at the next step, which is a new one. */
    const bool moves = reply->state == MNS_STATE_RUNNING;
    for (size_t k = 0; has && k < n && !*ret_painted && !status; k++) {
        const Demand *demand = &demands[(painter->turn + k) % n];
        if (is_refused(painter, &demand->wish)) continue;
        if (!moves && demand->has && key_equal(demand->have, (FrameKey){generation, reply->step})) continue;
        painter->turn += k + 1;
        *ret_painted = true;
        status = paint(painter, &demand->wish, reply->info, generation, error);
        if (status && !is_gone(status)) refuse(painter, &demand->wish, error);
    }
    mns_reply_free(reply);
    return status;
}

/* One round: wait for a demand, serve it, keep the pace. What the daemon refuses costs the others nothing; only one that is gone is left. */
static MnsStatus round_once(Painter *painter, MnsError *error)
{
    Demand demands[HUB_BROWSERS];
    const size_t n = hub_await_demands(painter->hub, demands);
    if (!n) return MNS_OK;
    const double began = now_s();
    bool painted;
    const MnsStatus status = serve(painter, n, demands, &painted, error);
    if (is_gone(status)) return status;
    rest(began + (painted && !status ? painter->interval : idle_s) - now_s());
    return MNS_OK;
}

static void *live(void *arg)
{
    Painter *painter = arg;
    for (;;) {
        MnsError error = {0};
        Demand demands[HUB_BROWSERS];
        while (!hub_await_demands(painter->hub, demands)) {}
        MnsStatus status = mns_client_open(hub_daemon(painter->hub), &painter->client, &error);
        if (!status) mns_client_set_timeout(painter->client, patience_s);
        while (!status) status = round_once(painter, &error);
        mns_client_close(painter->client);
        painter->client = NULL;
        rest(1);
    }
    return NULL;
}

MnsStatus painter_start(Hub *hub, double frames_per_second, MnsError *error)
{
    pthread_t thread;
    Painter *painter = calloc(1, sizeof *painter);
    if (!painter) return mns_fail(error, MNS_E_MEMORY, "no memory for a thread");
    *painter = (Painter){.hub = hub, .interval = 1 / frames_per_second};
    if (pthread_create(&thread, NULL, live, painter)) {
        free(painter);
        return mns_fail(error, MNS_E_LIMIT, "the system gives no thread");
    }
    pthread_detach(thread);
    return MNS_OK;
}
