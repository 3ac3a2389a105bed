/* SPDX-License-Identifier: BSD-3-Clause */
/* Listening to a daemon. Messages of a topic are numbered; what is missing is counted, never guessed. */
#include "client/lib/endpoint.h"
#include "client/lib/reply.h"
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { QUEUE_MESSAGES = 10000, HEARTBEAT_MS = 2000, HEARTBEAT_TIMEOUT_MS = 6000 };

typedef struct OwnedTelemetry {
    MnsTelemetry telemetry; /* first, so that a pointer to it is a pointer to the whole */
    Meniscus__Telemetry *message;
    Arena arena;
} OwnedTelemetry;

static const char *const topics[] = {"event", "log", "progress", "probe"}; /* bit k of MnsTopic */
enum { TOPIC_COUNT = sizeof topics / sizeof *topics };

static MnsStatus listen_to(MnsClient *client, MnsError *error)
{
    char endpoint[MNS_ENDPOINT_SIZE];
    const MnsStatus status = endpoint_telemetry(client->wire.endpoint, endpoint, error);
    if (status != MNS_OK) return status;
    static const struct {
        int option, value;
    } options[] = {{ZMQ_LINGER, 0},
                   {ZMQ_RCVHWM, QUEUE_MESSAGES},
                   {ZMQ_HEARTBEAT_IVL, HEARTBEAT_MS},
                   {ZMQ_HEARTBEAT_TIMEOUT, HEARTBEAT_TIMEOUT_MS}};
    void *socket = zmq_socket(client->wire.context, ZMQ_SUB);
    for (size_t k = 0; socket && k < sizeof options / sizeof *options; k++)
        zmq_setsockopt(socket, options[k].option, &options[k].value, sizeof options[k].value);
    const int six = strchr(endpoint, '[') != NULL;
    if (socket) zmq_setsockopt(socket, ZMQ_IPV6, &six, sizeof six);
    if (!socket || !wire_secure(&client->wire, socket) || zmq_connect(socket, endpoint) != 0) {
        const int cause = errno;
        if (socket) zmq_close(socket);
        return mns_fail(error, MNS_E_UNAVAILABLE, "cannot listen to %s: %s", endpoint, zmq_strerror(cause));
    }
    client->telemetry = socket;
    return MNS_OK;
}

MnsStatus mns_client_subscribe(MnsClient *client, unsigned wanted, MnsError *error)
{
    if (wanted == 0 || wanted > MNS_TOPIC_ALL)
        return mns_fail(error, MNS_E_INVALID, "topics 0x%x; allowed are sums of MNS_TOPIC_*", wanted);
    if (!client->telemetry && listen_to(client, error) != MNS_OK) return error ? error->status : MNS_E_UNAVAILABLE;
    for (size_t k = 0; k < TOPIC_COUNT; k++)
        if (wanted & 1u << k) zmq_setsockopt(client->telemetry, ZMQ_SUBSCRIBE, topics[k], strlen(topics[k]));
    return MNS_OK;
}

/* How many messages of the topic did not arrive before this one. After a restart of the daemon numbers begin anew. */
static uint64_t count_lost(MnsClient *client, unsigned k, uint64_t epoch, uint64_t sequence)
{
    const bool known = client->heard[k].epoch == epoch && epoch != 0;
    const uint64_t last = client->heard[k].sequence;
    client->heard[k].epoch = epoch;
    client->heard[k].sequence = sequence;
    return known && sequence > last ? sequence - last - 1 : 0;
}

static double number(protobuf_c_boolean has, double value)
{
    return has ? value : (double)NAN;
}

static void read_progress(const Meniscus__Progress *progress, MnsTelemetry *to)
{
    to->state = (MnsState)progress->state;
    to->fraction = number(progress->has_fraction, progress->fraction);
    to->eta_s = number(progress->has_eta_s, progress->eta_s);
    to->steps_per_second = number(progress->has_steps_per_second, progress->steps_per_second);
    to->time_step = number(progress->has_time_step, progress->time_step);
    to->end_time = number(progress->has_end_time, progress->end_time);
}

static void read_event(const Meniscus__Event *event, MnsTelemetry *to)
{
    to->state = (MnsState)event->state;
    if (event->what) to->what = event->what;
    if (event->text) to->text = event->text;
}

static MnsStatus read_item(OwnedTelemetry *owned, MnsError *error)
{
    const Meniscus__Telemetry *from = owned->message;
    MnsTelemetry *to = &owned->telemetry;
    switch (from->item_case) {
    case MENISCUS__TELEMETRY__ITEM_EVENT: read_event(from->event, to); break;
    case MENISCUS__TELEMETRY__ITEM_LOG:
        to->level = from->log->level;
        if (from->log->text) to->text = from->log->text;
        break;
    case MENISCUS__TELEMETRY__ITEM_PROGRESS: read_progress(from->progress, to); break;
    case MENISCUS__TELEMETRY__ITEM_PROBES:
        to->n_values = from->probes->n_values;
        to->values = reply_values(&owned->arena, to->n_values, from->probes->values);
        return to->values ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "no memory for %zu probe values", to->n_values);
    default: return mns_fail(error, MNS_E_VERSION, "a telemetry message of a kind this client does not know");
    }
    return MNS_OK;
}

static MnsStatus read_message(MnsClient *client, unsigned k, Meniscus__Telemetry *message, MnsTelemetry **ret,
                              MnsError *error)
{
    OwnedTelemetry *owned = calloc(1, sizeof *owned);
    if (!owned) {
        meniscus__telemetry__free_unpacked(message, NULL);
        return mns_fail(error, MNS_E_MEMORY, "no memory for a telemetry message");
    }
    owned->message = message;
    owned->telemetry = (MnsTelemetry){.topic = (MnsTopic)(1u << k),
                                      .daemon_epoch = message->daemon_epoch,
                                      .sequence = message->sequence,
                                      .lost = count_lost(client, k, message->daemon_epoch, message->sequence),
                                      .step = message->step,
                                      .time = message->time,
                                      .what = "",
                                      .text = "",
                                      .fraction = NAN,
                                      .eta_s = NAN,
                                      .steps_per_second = NAN,
                                      .time_step = NAN,
                                      .end_time = NAN};
    const MnsStatus status = read_item(owned, error);
    if (status == MNS_OK) *ret = &owned->telemetry;
    else mns_telemetry_free(&owned->telemetry);
    return status;
}

/* Index of a topic frame, or TOPIC_COUNT. */
static unsigned find_topic(zmq_msg_t *frame)
{
    unsigned k = 0;
    while (k < TOPIC_COUNT &&
           (zmq_msg_size(frame) != strlen(topics[k]) || memcmp(zmq_msg_data(frame), topics[k], strlen(topics[k])) != 0))
        k++;
    return k;
}

static MnsStatus read_frames(MnsClient *client, Frames *frames, MnsTelemetry **ret, MnsError *error)
{
    const unsigned k = frames->n == 2 ? find_topic(&frames->frame[0]) : TOPIC_COUNT;
    Meniscus__Telemetry *message = NULL;
    if (k < TOPIC_COUNT)
        message = meniscus__telemetry__unpack(NULL, zmq_msg_size(&frames->frame[1]), zmq_msg_data(&frames->frame[1]));
    if (!message) return mns_fail(error, MNS_E_CORRUPT, "a telemetry message of %d frames cannot be read", frames->n);
    return read_message(client, k, message, ret, error);
}

MnsStatus mns_client_next(MnsClient *client, double timeout_s, MnsTelemetry **ret_telemetry, MnsError *error)
{
    if (!client->telemetry)
        return mns_fail(error, MNS_E_STATE, "nothing is subscribed; call mns_client_subscribe() first");
    zmq_pollitem_t item = {.socket = client->telemetry, .events = ZMQ_POLLIN};
    const long timeout_ms = timeout_s < 0 ? -1 : (long)fmin(1e9, ceil(1e3 * timeout_s));
    if (zmq_poll(&item, 1, timeout_ms) < 0) return mns_fail(error, MNS_E_INTERRUPTED, "interrupted by a signal");
    Frames frames;
    if (!frames_receive(&frames, client->telemetry))
        return mns_fail(error, MNS_E_TIMEOUT, "no telemetry within %g s", timeout_s);
    const MnsStatus status = read_frames(client, &frames, ret_telemetry, error);
    frames_done(&frames);
    return status;
}

void mns_telemetry_free(MnsTelemetry *telemetry)
{
    if (!telemetry) return;
    OwnedTelemetry *owned = (OwnedTelemetry *)telemetry;
    meniscus__telemetry__free_unpacked(owned->message, NULL);
    arena_done(&owned->arena);
    free(owned);
}
