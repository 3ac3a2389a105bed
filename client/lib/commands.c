/* SPDX-License-Identifier: BSD-3-Clause */
/* Every command of the protocol but load, as a function. */
#include "client/lib/commands.h"
#include "common/wire/lease.h"
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

MnsStatus command_call(MnsClient *client, Meniscus__Request *request, MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Reply *message;
    Frames frames;
    MnsReply *reply = NULL;
    MnsStatus status = call_make(client, request, &message, &frames, error);
    if (status == MNS_OK) status = reply_new(message, &frames, &reply, error);
    if (status != MNS_OK) return status;
    if (ret_reply) *ret_reply = reply;
    else mns_reply_free(reply);
    return MNS_OK;
}

/* Send one command with the request that it began with. message: of the type that belongs to it in Request. */
static MnsStatus send(MnsClient *client, Meniscus__Request *request, Meniscus__Request__CommandCase command,
                      void *message, MnsReply **ret_reply, MnsError *error)
{
    request->command_case = command;
    memcpy(&request->load, &message, sizeof message); /* a union of pointers: whichever, it lies there */
    return command_call(client, request, ret_reply, error);
}

/* A command that says nothing but its name. */
static MnsStatus send_name(MnsClient *client, Meniscus__Request__CommandCase command, MnsReply **ret_reply,
                           MnsError *error)
{
    const ProtobufCFieldDescriptor *field =
        protobuf_c_message_descriptor_get_field(&meniscus__request__descriptor, (unsigned)command);
    const ProtobufCMessageDescriptor *type = field->descriptor;
    Meniscus__Request request = call_begin(client);
    ProtobufCMessage message;
    assert(type->sizeof_message == sizeof message);
    protobuf_c_message_init(type, &message);
    return send(client, &request, command, &message, ret_reply, error);
}

MnsStatus mns_client_start(MnsClient *client, MnsReply **ret_reply, MnsError *error)
{
    return send_name(client, MENISCUS__REQUEST__COMMAND_START, ret_reply, error);
}

MnsStatus mns_client_pause(MnsClient *client, MnsReply **ret_reply, MnsError *error)
{
    return send_name(client, MENISCUS__REQUEST__COMMAND_PAUSE, ret_reply, error);
}

MnsStatus mns_client_resume(MnsClient *client, MnsReply **ret_reply, MnsError *error)
{
    return send_name(client, MENISCUS__REQUEST__COMMAND_RESUME, ret_reply, error);
}

MnsStatus mns_client_reset(MnsClient *client, MnsReply **ret_reply, MnsError *error)
{
    return send_name(client, MENISCUS__REQUEST__COMMAND_RESET, ret_reply, error);
}

MnsStatus mns_client_checkpoint(MnsClient *client, MnsReply **ret_reply, MnsError *error)
{
    return send_name(client, MENISCUS__REQUEST__COMMAND_CHECKPOINT, ret_reply, error);
}

MnsStatus mns_client_status(MnsClient *client, MnsReply **ret_reply, MnsError *error)
{
    return send_name(client, MENISCUS__REQUEST__COMMAND_STATUS, ret_reply, error);
}

MnsStatus mns_client_capabilities(MnsClient *client, MnsReply **ret_reply, MnsError *error)
{
    return send_name(client, MENISCUS__REQUEST__COMMAND_CAPABILITIES, ret_reply, error);
}

MnsStatus mns_client_step(MnsClient *client, uint64_t count, MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__Step step = MENISCUS__STEP__INIT;
    step.has_count = true;
    step.count = count;
    return send(client, &request, MENISCUS__REQUEST__COMMAND_STEP, &step, ret_reply, error);
}

MnsStatus mns_client_run_until(MnsClient *client, double time, bool exact, MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__RunUntil until = MENISCUS__RUN_UNTIL__INIT;
    until.has_time = until.has_exact = true;
    until.time = time;
    until.exact = exact;
    return send(client, &request, MENISCUS__REQUEST__COMMAND_RUN_UNTIL, &until, ret_reply, error);
}

MnsStatus mns_client_stop(MnsClient *client, bool checkpoint, MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__Stop stop = MENISCUS__STOP__INIT;
    stop.has_checkpoint = true;
    stop.checkpoint = checkpoint;
    return send(client, &request, MENISCUS__REQUEST__COMMAND_STOP, &stop, ret_reply, error);
}

MnsStatus mns_client_restore(MnsClient *client, const char *checkpoint, MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__Restore restore = MENISCUS__RESTORE__INIT;
    restore.checkpoint = (char *)checkpoint;
    return send(client, &request, MENISCUS__REQUEST__COMMAND_RESTORE, &restore, ret_reply, error);
}

MnsStatus mns_client_snapshot(MnsClient *client, size_t n, const char *const *fields, MnsReply **ret_reply,
                              MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__SnapshotNow snapshot = MENISCUS__SNAPSHOT_NOW__INIT;
    snapshot.n_fields = n;
    snapshot.fields = (char **)fields;
    return send(client, &request, MENISCUS__REQUEST__COMMAND_SNAPSHOT, &snapshot, ret_reply, error);
}

/* Split "path=value" into two strings within one that is yours; NULL if there is no "=" or no memory. */
static char *split(const char *text, Meniscus__Assignment *ret)
{
    char *copy = strchr(text, '=') > text ? strdup(text) : NULL;
    if (!copy) return NULL;
    char *equals = strchr(copy, '=');
    *equals = 0;
    meniscus__assignment__init(ret);
    ret->path = copy;
    ret->value = equals + 1;
    return copy;
}

MnsStatus mns_client_rollback(MnsClient *client, uint64_t version, MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__Rollback rollback = MENISCUS__ROLLBACK__INIT;
    rollback.has_version = true;
    rollback.version = version;
    return send(client, &request, MENISCUS__REQUEST__COMMAND_ROLLBACK, &rollback, ret_reply, error);
}

/* What comes of it is this client's lease from now on. */
static MnsStatus send_lease(MnsClient *client, Meniscus__Request *request, Meniscus__Lease *lease, MnsReply **ret_reply,
                            MnsError *error)
{
    MnsReply *reply;
    const MnsStatus status = send(client, request, MENISCUS__REQUEST__COMMAND_LEASE, lease, &reply, error);
    if (status != MNS_OK) return status;
    client->lease_epoch = reply->lease_epoch;
    if (ret_reply) *ret_reply = reply;
    else mns_reply_free(reply);
    return MNS_OK;
}

MnsStatus mns_client_lease(MnsClient *client, double seconds, const char *holder, MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__Lease lease = MENISCUS__LEASE__INIT;
    if (!lease_can_live(seconds))
        return mns_fail_at(error, MNS_E_INVALID, "ttl_ms", "a lease lives from %g to %g s; found %g",
                           1e-3 * LEASE_MS_MIN, 1e-3 * LEASE_MS_MAX, seconds);
    lease.has_ttl_ms = true;
    lease.ttl_ms = (uint64_t)(1e3 * seconds + 0.5);
    lease.holder = (char *)holder;
    return send_lease(client, &request, &lease, ret_reply, error);
}

MnsStatus mns_client_release(MnsClient *client, MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__Lease lease = MENISCUS__LEASE__INIT;
    lease.has_release = lease.release = true;
    return send_lease(client, &request, &lease, ret_reply, error);
}

MnsStatus mns_client_set(MnsClient *client, size_t n, const char *const *assignments, MnsReply **ret_reply,
                         MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__Assignment *items = calloc(n + 1, sizeof *items);
    Meniscus__Assignment **list = calloc(n + 1, sizeof *list);
    MnsStatus status = items && list ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "no memory for %zu assignments", n);
    size_t done = 0;
    for (; status == MNS_OK && done < n; done++) {
        list[done] = &items[done];
        if (!split(assignments[done], list[done])) break;
    }
    if (status == MNS_OK && done < n)
        status = mns_fail(error, MNS_E_INVALID, "\"%s\" is not an assignment; write PATH=VALUE, as in end_time=3",
                          assignments[done]);
    if (status == MNS_OK) {
        Meniscus__Set set = MENISCUS__SET__INIT;
        set.n_assignments = n;
        set.assignments = list;
        status = send(client, &request, MENISCUS__REQUEST__COMMAND_SET, &set, ret_reply, error);
    }
    for (size_t k = 0; k < done; k++) free(items[k].path);
    free(list);
    free(items);
    return status;
}

MnsStatus mns_client_get(MnsClient *client, size_t n, const char *const *paths, MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__Get get = MENISCUS__GET__INIT;
    get.n_paths = n;
    get.paths = (char **)paths;
    return send(client, &request, MENISCUS__REQUEST__COMMAND_GET, &get, ret_reply, error);
}

static MnsStatus query(MnsClient *client, Meniscus__Request *request, Meniscus__Query *what, MnsReply **ret_reply,
                       MnsError *error)
{
    return send(client, request, MENISCUS__REQUEST__COMMAND_QUERY, what, ret_reply, error);
}

MnsStatus mns_client_query_probes(MnsClient *client, size_t n, const char *const *names, MnsReply **ret_reply,
                                  MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__ProbeQuery probes = MENISCUS__PROBE_QUERY__INIT;
    probes.n_names = n;
    probes.names = (char **)names;
    Meniscus__Query what = MENISCUS__QUERY__INIT;
    what.what_case = MENISCUS__QUERY__WHAT_PROBES;
    what.probes = &probes;
    return query(client, &request, &what, ret_reply, error);
}

MnsStatus mns_client_query_points(MnsClient *client, const char *field, size_t n, int dim, const double *points,
                                  MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    if (dim != 2 && dim != 3)
        return mns_fail(error, MNS_E_INVALID, "points of %d coordinates; a case has 2 or 3 dimensions", dim);
    Meniscus__PointQuery message = MENISCUS__POINT_QUERY__INIT;
    message.field = (char *)field;
    message.n_points = n * (size_t)dim;
    message.points = (double *)points;
    Meniscus__Query what = MENISCUS__QUERY__INIT;
    what.what_case = MENISCUS__QUERY__WHAT_POINTS;
    what.points = &message;
    return query(client, &request, &what, ret_reply, error);
}

MnsStatus mns_client_query_particles(MnsClient *client, const MnsParticleQuery *from, MnsReply **ret_reply,
                                     MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    if (from->dim != 0 && from->dim != 2 && from->dim != 3)
        return mns_fail(error, MNS_E_INVALID, "a box in %d dimensions; a case has 2 or 3", from->dim);
    Meniscus__ParticleQuery particles = MENISCUS__PARTICLE_QUERY__INIT;
    particles.n_min = particles.n_max = (size_t)from->dim;
    particles.min = (double *)from->min;
    particles.max = (double *)from->max;
    particles.n_fields = from->n_fields;
    particles.fields = (char **)from->fields;
    particles.has_limit = from->limit > 0;
    particles.limit = from->limit;
    particles.has_walls = true;
    particles.walls = from->walls;
    particles.has_every = from->every > 0;
    particles.every = from->every;
    Meniscus__Query what = MENISCUS__QUERY__INIT;
    what.what_case = MENISCUS__QUERY__WHAT_PARTICLES;
    what.particles = &particles;
    return query(client, &request, &what, ret_reply, error);
}

MnsStatus mns_client_wait(MnsClient *client, unsigned states, double time, uint64_t step, MnsReply **ret_reply,
                          MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__State list[MNS_STATE_COUNT];
    Meniscus__Wait wait = MENISCUS__WAIT__INIT;
    wait.states = list;
    for (unsigned k = 0; k < MNS_STATE_COUNT; k++)
        if (states & 1u << k) list[wait.n_states++] = (Meniscus__State)k;
    if (time < 0) return mns_fail_at(error, MNS_E_INVALID, "time", "a time to wait for is 0 s or more; found %g", time);
    wait.has_time = !isnan(time);
    wait.time = time;
    wait.has_step = step != MNS_NO_STEP;
    wait.step = step;
    return send(client, &request, MENISCUS__REQUEST__COMMAND_WAIT, &wait, ret_reply, error);
}

MnsStatus mns_client_breakpoint(MnsClient *client, const MnsBreakpoint *breakpoint, MnsReply **ret_reply,
                                MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__SetBreakpoint message = MENISCUS__SET_BREAKPOINT__INIT;
    message.name = (char *)breakpoint->name;
    message.condition = (char *)breakpoint->condition;
    message.has_time = !isnan(breakpoint->time);
    message.time = breakpoint->time;
    message.has_step = breakpoint->step > 0;
    message.step = breakpoint->step;
    message.has_remove = message.remove = !message.condition && !message.has_time && !message.has_step;
    return send(client, &request, MENISCUS__REQUEST__COMMAND_BREAKPOINT, &message, ret_reply, error);
}

MnsStatus mns_client_cancel(MnsClient *client, const uint8_t id[MNS_REQUEST_ID_SIZE], MnsReply **ret_reply,
                            MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__Cancel cancel = MENISCUS__CANCEL__INIT;
    cancel.has_id = true;
    cancel.id = (ProtobufCBinaryData){.len = MNS_REQUEST_ID_SIZE, .data = (uint8_t *)id};
    return send(client, &request, MENISCUS__REQUEST__COMMAND_CANCEL, &cancel, ret_reply, error);
}

MnsStatus mns_client_shutdown(MnsClient *client, bool checkpoint, MnsReply **ret_reply, MnsError *error)
{
    Meniscus__Request request = call_begin(client);
    Meniscus__Shutdown shutdown = MENISCUS__SHUTDOWN__INIT;
    shutdown.has_checkpoint = true;
    shutdown.checkpoint = checkpoint;
    return send(client, &request, MENISCUS__REQUEST__COMMAND_SHUTDOWN, &shutdown, ret_reply, error);
}
