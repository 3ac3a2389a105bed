/* SPDX-License-Identifier: BSD-3-Clause */
/* A request and its reply. After a lost connection the same request goes out under the same id, so it happens once: a daemon that
 * comes back after a crash knows from its run's journal what it has answered, and what that has not was never done. */
#include "client/lib/call.h"
#include "common/wire/frame.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <xxhash.h>

static const double greeting_s = 5; /* a daemon answers greetings at once, whatever it computes        */
static const double grace_s = 2;    /* beyond the deadline the daemon knows, for its answer to get here */

enum { ENDED_MAX = 2 }; /* daemons that end while they have a request: once is an accident */

static const MnsStatus statuses[] = {
    [MENISCUS__CODE__OK] = MNS_OK,
    [MENISCUS__CODE__INVALID_ARGUMENT] = MNS_E_INVALID,
    [MENISCUS__CODE__DEADLINE_EXCEEDED] = MNS_E_TIMEOUT,
    [MENISCUS__CODE__NOT_FOUND] = MNS_E_NOT_FOUND,
    [MENISCUS__CODE__ALREADY_EXISTS] = MNS_E_STATE,
    [MENISCUS__CODE__PERMISSION_DENIED] = MNS_E_DENIED,
    [MENISCUS__CODE__RESOURCE_EXHAUSTED] = MNS_E_LIMIT,
    [MENISCUS__CODE__FAILED_PRECONDITION] = MNS_E_STATE,
    [MENISCUS__CODE__ABORTED] = MNS_E_INTERRUPTED,
    [MENISCUS__CODE__OUT_OF_RANGE] = MNS_E_INVALID,
    [MENISCUS__CODE__UNIMPLEMENTED] = MNS_E_VERSION,
    [MENISCUS__CODE__INTERNAL] = MNS_E_INTERNAL,
    [MENISCUS__CODE__UNAVAILABLE] = MNS_E_UNAVAILABLE,
    [MENISCUS__CODE__DATA_LOSS] = MNS_E_CORRUPT,
    [MENISCUS__CODE__UNAUTHENTICATED] = MNS_E_DENIED,
};

MnsStatus call_random(uint8_t *data, size_t size, MnsError *error)
{
    if (getrandom(data, size, 0) == (ssize_t)size) return MNS_OK;
    return mns_fail(error, MNS_E_IO, "the system gives no random numbers for a request id");
}

/* Fill in the envelope. id: [MNS_REQUEST_ID_SIZE], borrowed. */
static void seal(Meniscus__Request *request, uint8_t *id, double timeout)
{
    request->has_major = request->has_id = true;
    request->major = MENISCUS__PROTOCOL_VERSION__PROTOCOL_MAJOR;
    request->id = (ProtobufCBinaryData){.len = MNS_REQUEST_ID_SIZE, .data = id};
    request->has_deadline_ms = timeout >= 0;
    if (request->has_deadline_ms) request->deadline_ms = (uint64_t)fmin(1e3 * timeout, 1e15);
}

/* Is this the reply to that request? Replies to earlier ones, given up, may still come. */
static bool answers(const Meniscus__Reply *reply, const Meniscus__Request *request)
{
    return reply->has_id && reply->id.len == request->id.len &&
           memcmp(reply->id.data, request->id.data, request->id.len) == 0;
}

/* Wait for the reply to a request that was sent. *ret = NULL: the connection was made anew, send again. */
static MnsStatus await(MnsClient *client, const Meniscus__Request *request, double deadline, Meniscus__Reply **ret,
                       Frames *frames, MnsError *error)
{
    for (;;) {
        const MnsStatus status = wire_receive(&client->wire, deadline, frames, error);
        *ret = NULL;
        if (status != MNS_OK || frames->n == 0) return status;
        zmq_msg_t *first = &frames->frame[0];
        *ret = meniscus__reply__unpack(NULL, zmq_msg_size(first), zmq_msg_data(first));
        if (*ret && answers(*ret, request)) return MNS_OK;
        const bool readable = *ret;
        if (readable) meniscus__reply__free_unpacked(*ret, NULL);
        frames_done(frames);
        if (!readable)
            return mns_fail(error, MNS_E_VERSION,
                            "cannot read the reply of %s; is it a meniscusd of this "
                            "version?",
                            client->wire.endpoint);
    }
}

/* After a lost connection: is the request given to whoever is there now? If that is a daemon that was started since, the one before has
 * ended, which is all that a shutdown wants, and what another request may have brought about: one that ends every daemon must not be
 * given to each that a supervisor starts. A wait brings nothing about. *ended: how many daemons ended while they had it. */
static MnsStatus may_repeat(MnsClient *client, const Meniscus__Request *request, int *ended, MnsError *error)
{
    const uint64_t before = client->epoch;
    const MnsStatus status = call_greet(client, wire_clock() + greeting_s, error);
    if (status != MNS_OK) return status;
    if (client->epoch == before || request->command_case == MENISCUS__REQUEST__COMMAND_WAIT) return MNS_OK;
    if (request->command_case == MENISCUS__REQUEST__COMMAND_SHUTDOWN)
        return mns_fail(error, MNS_E_UNAVAILABLE,
                        "the daemon at %s ended before it answered, and another was started; give the command again if "
                        "that shall end too",
                        client->wire.endpoint);
    if (++*ended < ENDED_MAX) return MNS_OK;
    return mns_fail(error, MNS_E_UNAVAILABLE,
                    "the daemon at %s ended %d times before it answered, perhaps because of this command, which is not "
                    "given to it again: see its log for why, and `meniscus status` for what took effect",
                    client->wire.endpoint, ENDED_MAX);
}

/* Send until there is a reply. The reply may be a refusal. */
static MnsStatus exchange(MnsClient *client, const Meniscus__Request *request, double deadline, Meniscus__Reply **ret,
                          Frames *frames, MnsError *error)
{
    const size_t size = meniscus__request__get_packed_size(request);
    MnsStatus status = wire_check_size(size, FRAME_MAX, error);
    if (status) return status;
    uint8_t *packed = malloc(size + 1);
    if (!packed) return mns_fail(error, MNS_E_MEMORY, "no memory for a request of %zu bytes", size);
    meniscus__request__pack(request, packed);
    int ended = 0;
    for (*ret = NULL; status == MNS_OK && !*ret;) {
        status = wire_send(&client->wire, packed, size, error);
        if (status == MNS_OK) status = await(client, request, deadline, ret, frames, error);
        if (status == MNS_OK && !*ret && request->command_case != MENISCUS__REQUEST__COMMAND_STATUS)
            status = may_repeat(client, request, &ended, error);
    }
    free(packed);
    return status;
}

MnsStatus call_reason(const char *reason)
{
    for (int k = MNS_OK + 1; reason && k <= MNS_E_INTERNAL; k++)
        if (strcmp(reason, mns_status_name((MnsStatus)k)) == 0) return (MnsStatus)k;
    return MNS_OK;
}

/* The reason is exact; codes are fewer. A reason nobody here knows comes from a newer daemon: the code has to do. */
MnsStatus call_status(Meniscus__Code code, const char *reason)
{
    const unsigned k = (unsigned)code;
    const MnsStatus exact = call_reason(reason);
    if (exact != MNS_OK) return exact;
    const MnsStatus status = k < sizeof statuses / sizeof *statuses ? statuses[k] : MNS_E_INTERNAL;
    return status == MNS_OK ? MNS_E_INTERNAL : status;
}

static MnsStatus refusal(const Meniscus__Reply *reply, MnsError *error)
{
    if (!reply->has_code)
        return mns_fail(
            error, MNS_E_VERSION,
            "the reply says neither that the command was done nor that it was refused; is it a meniscusd of "
            "this version?");
    const MnsStatus status = call_status(reply->code, reply->reason);
    const char *message = reply->message && *reply->message ? reply->message : "the daemon refused without a reason";
    return mns_fail_at(error, status, reply->path ? reply->path : "", "%s", message);
}

static MnsStatus check_arrays(const Meniscus__Reply *reply, Frames *frames, MnsError *error)
{
    if (reply->n_arrays != (size_t)(frames->n - 1))
        return mns_fail(error, MNS_E_CORRUPT, "the reply announces %zu arrays and has %d; ask again", reply->n_arrays,
                        frames->n - 1);
    for (size_t k = 0; k < reply->n_arrays; k++) {
        const Meniscus__Array *array = reply->arrays[k];
        zmq_msg_t *frame = &frames->frame[1 + k];
        if (array->has_xxh64 && XXH64(zmq_msg_data(frame), zmq_msg_size(frame), 0) == array->xxh64) continue;
        return mns_fail(error, MNS_E_CORRUPT, "array \"%s\" came damaged: its checksum does not match; ask again",
                        array->name ? array->name : "");
    }
    return MNS_OK;
}

/* id: [MNS_REQUEST_ID_SIZE]; timeout [s], negative: none; grace [s]: how much later the answer may get here. */
static MnsStatus call_as(MnsClient *client, Meniscus__Request *request, uint8_t *id, double timeout, double grace,
                         Meniscus__Reply **ret_reply, Frames *ret_frames, MnsError *error)
{
    const double deadline = timeout < 0 ? INFINITY : wire_clock() + timeout + grace;
    seal(request, id, timeout);
    MnsStatus status = exchange(client, request, deadline, ret_reply, ret_frames, error);
    if (status != MNS_OK) return status;
    const bool done =
        (*ret_reply)->has_code && (*ret_reply)->code == MENISCUS__CODE__OK; /* OK is what is absent, too */
    status = done ? check_arrays(*ret_reply, ret_frames, error) : refusal(*ret_reply, error);
    if (status == MNS_OK) return MNS_OK;
    meniscus__reply__free_unpacked(*ret_reply, NULL);
    frames_done(ret_frames);
    return status;
}

MnsStatus call_greet(MnsClient *client, double deadline, MnsError *error)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__GetStatus greeting = MENISCUS__GET_STATUS__INIT;
    request.command_case = MENISCUS__REQUEST__COMMAND_STATUS;
    request.status = &greeting;
    Meniscus__Reply *reply;
    Frames frames;
    uint8_t id[MNS_REQUEST_ID_SIZE];
    MnsStatus status = call_random(id, sizeof id, error);
    const double timeout = fmax(0, deadline - wire_clock());
    if (status == MNS_OK) status = call_as(client, &request, id, timeout, 0, &reply, &frames, error);
    if (status == MNS_E_TIMEOUT)
        return mns_fail(error, MNS_E_UNAVAILABLE, "%s is open, but nobody answers there", client->wire.endpoint);
    if (status != MNS_OK) return status;
    client->epoch = reply->daemon_epoch;
    meniscus__reply__free_unpacked(reply, NULL);
    frames_done(&frames);
    return MNS_OK;
}

Meniscus__Request call_begin(MnsClient *client)
{
    Meniscus__Request request = client->next;
    client->next = (Meniscus__Request)MENISCUS__REQUEST__INIT;
    return request;
}

MnsStatus call_make(MnsClient *client, Meniscus__Request *request, Meniscus__Reply **ret_reply, Frames *ret_frames,
                    MnsError *error)
{
    uint8_t id[MNS_REQUEST_ID_SIZE];
    const MnsStatus status = request->has_id ? MNS_OK : call_random(id, sizeof id, error);
    if (status != MNS_OK) return status;
    if (request->has_id) memcpy(id, client->next_id, sizeof id);
    request->has_lease_epoch = client->lease_epoch > 0;
    request->lease_epoch = client->lease_epoch;
    return call_as(client, request, id, client->timeout, grace_s, ret_reply, ret_frames, error);
}
