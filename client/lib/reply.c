/* SPDX-License-Identifier: BSD-3-Clause */
/* Replies as plain structs: text is borrowed from the message, which lives as long; arrays are copied, for
 * alignment. */
#include "client/lib/reply.h"
#include "common/wire/frame.h"
#include "common/wire/states.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

typedef struct OwnedReply {
    MnsReply reply; /* first, so that a pointer to it is a pointer to the whole */
    Meniscus__Reply *message;
    Arena arena;
} OwnedReply;

/* States are taken from messages by their number. */
STATES_HAVE_THE_NUMBERS_OF_THE_PROTOCOL(MNS_STATE_);
_Static_assert(MNS_STATE_COUNT == MNS_STATE_RECOVERING + 1, "all states are compared");

const char *mns_state_name(MnsState state)
{
    const ProtobufCEnumValue *value = protobuf_c_enum_descriptor_get_value(&meniscus__state__descriptor, (int)state);
    return value ? value->name : "UNKNOWN";
}

bool mns_state_parse(const char *name, MnsState *ret_state)
{
    for (int k = 0; k < MNS_STATE_COUNT; k++) {
        if (strcasecmp(name, mns_state_name((MnsState)k)) != 0) continue;
        *ret_state = (MnsState)k;
        return true;
    }
    return false;
}

static const char *text(const char *maybe)
{
    return maybe ? maybe : "";
}

const MnsValue *reply_values(Arena *arena, size_t n, Meniscus__Value *const *messages)
{
    MnsValue *values = arena_take(arena, n, sizeof *values);
    for (size_t k = 0; values && k < n; k++) {
        const Meniscus__Value *message = messages[k];
        values[k] = (MnsValue){.name = text(message->name),
                               .text = message->text,
                               .unit = text(message->unit),
                               .number = message->has_number ? message->number : (double)NAN};
    }
    return values;
}

/* Bytes of an array of that type and shape; 0 if they cannot be. */
static size_t array_bytes(const Meniscus__Array *message)
{
    size_t bytes = number_size(text(message->type));
    for (size_t d = 0; d < message->n_shape; d++)
        if (__builtin_mul_overflow(bytes, message->shape[d], &bytes)) return 0;
    return bytes;
}

static MnsStatus read_array(Arena *arena, const Meniscus__Array *message, zmq_msg_t *frame, MnsArray *ret,
                            MnsError *error)
{
    const size_t size = zmq_msg_size(frame);
    if (message->n_shape > sizeof ret->shape / sizeof *ret->shape || array_bytes(message) != size)
        return mns_fail(error, MNS_E_CORRUPT,
                        "array \"%s\" has %zu bytes, which do not fit its type %s and its %zu "
                        "dimensions",
                        text(message->name), size, text(message->type), message->n_shape);
    void *data = arena_take(arena, 1, size);
    if (!data) return mns_fail(error, MNS_E_MEMORY, "no memory for an array of %zu bytes", size);
    if (size) memcpy(data, zmq_msg_data(frame), size);
    *ret = (MnsArray){.name = text(message->name),
                      .unit = text(message->unit),
                      .type = message->type,
                      .n_dims = message->n_shape,
                      .size = size,
                      .data = data};
    for (size_t d = 0; d < message->n_shape; d++) ret->shape[d] = message->shape[d];
    return MNS_OK;
}

static MnsStatus read_arrays(OwnedReply *owned, Frames *frames, MnsError *error)
{
    const Meniscus__Reply *message = owned->message;
    MnsArray *arrays = arena_take(&owned->arena, message->n_arrays, sizeof *arrays);
    if (!arrays) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu arrays", message->n_arrays);
    for (size_t k = 0; k < message->n_arrays; k++) {
        const MnsStatus status =
            read_array(&owned->arena, message->arrays[k], &frames->frame[1 + k], &arrays[k], error);
        if (status != MNS_OK) return status;
    }
    owned->reply.arrays = arrays;
    owned->reply.n_arrays = message->n_arrays;
    return MNS_OK;
}

static double number(protobuf_c_boolean has, double value)
{
    return has ? value : (double)NAN;
}

static const MnsTimerInfo *read_timers(Arena *arena, const Meniscus__Status *message)
{
    MnsTimerInfo *timers = arena_take(arena, message->n_timers, sizeof *timers);
    for (size_t k = 0; timers && k < message->n_timers; k++) {
        const Meniscus__Timer *timer = message->timers[k];
        timers[k] = (MnsTimerInfo){.name = text(timer->name), .seconds = timer->seconds, .calls = timer->calls};
    }
    return timers;
}

static const MnsBreakpoint *read_breakpoints(Arena *arena, const Meniscus__Status *message)
{
    MnsBreakpoint *breakpoints = arena_take(arena, message->n_breakpoints, sizeof *breakpoints);
    for (size_t k = 0; breakpoints && k < message->n_breakpoints; k++) {
        const Meniscus__SetBreakpoint *from = message->breakpoints[k];
        breakpoints[k] = (MnsBreakpoint){.name = text(from->name),
                                         .condition = from->condition,
                                         .time = number(from->has_time, from->time),
                                         .step = from->step};
    }
    return breakpoints;
}

static const MnsScheduled *read_scheduled(Arena *arena, const Meniscus__Status *message)
{
    MnsScheduled *scheduled = arena_take(arena, message->n_scheduled, sizeof *scheduled);
    for (size_t k = 0; scheduled && k < message->n_scheduled; k++) {
        const Meniscus__Scheduled *from = message->scheduled[k];
        scheduled[k] = (MnsScheduled){.at_step = from->has_at_step ? from->at_step : MNS_NO_STEP,
                                      .at_time = number(from->has_at_time, from->at_time),
                                      .who = text(from->who),
                                      .what = text(from->what)};
        if (from->id.len == MNS_REQUEST_ID_SIZE) memcpy(scheduled[k].id, from->id.data, MNS_REQUEST_ID_SIZE);
    }
    return scheduled;
}

static const MnsStreamsNow *read_streams(Arena *arena, const Meniscus__StreamsNow *from)
{
    MnsStreamsNow *streams = from ? arena_take(arena, 1, sizeof *streams) : NULL;
    if (streams) *streams = (MnsStreamsNow){from->latest, from->lossless, from->memory_bytes, from->skipped};
    return streams;
}

static MnsRunInfo *read_info(Arena *arena, const Meniscus__Status *m)
{
    MnsRunInfo *info = arena_take(arena, 1, sizeof *info);
    if (!info) return NULL;
    *info = (MnsRunInfo){
        .state = (MnsState)m->state,
        .fault_status = call_reason(m->fault_reason),
        .case_name = text(m->case_name),
        .title = text(m->title),
        .run_directory = text(m->run_directory),
        .fault = text(m->fault),
        .version = text(m->version),
        .time = number(m->has_time, m->time),
        .end_time = number(m->has_end_time, m->end_time),
        .time_step = number(m->has_time_step, m->time_step),
        .eta_s = number(m->has_eta_s, m->eta_s),
        .wall_s = number(m->has_wall_s, m->wall_s),
        .steps_per_second = number(m->has_steps_per_second, m->steps_per_second),
        .ns_per_particle_step = number(m->has_ns_per_particle_step, m->ns_per_particle_step),
        .energy_excess = number(m->has_energy_excess, m->energy_excess),
        .step = m->step,
        .particles = m->particles,
        .fluid_particles = m->fluid_particles,
        .guarded = m->guarded,
        .uncorrected = m->uncorrected,
        .samples_dropped = m->samples_dropped,
        .recovery_step = m->has_recovery_step ? m->recovery_step : MNS_NO_STEP,
        .memory_bytes = m->memory_bytes,
        .state_hash = m->state_hash,
        .case_version = m->case_version,
        .lease_holder = text(m->lease_holder),
        .lease_s = number(m->has_lease_s, m->lease_s),
        .threads = m->threads,
        .n_timers = m->n_timers,
        .n_breakpoints = m->n_breakpoints,
        .n_scheduled = m->n_scheduled,
        .timers = read_timers(arena, m),
        .breakpoints = read_breakpoints(arena, m),
        .scheduled = read_scheduled(arena, m),
        .streams = read_streams(arena, m->streams),
    };
    const bool whole = info->timers && info->breakpoints && info->scheduled && (info->streams || !m->streams);
    return whole ? info : NULL;
}

static const MnsTopicInfo *read_parameters(Arena *arena, const Meniscus__Capabilities *message)
{
    MnsTopicInfo *topics = arena_take(arena, message->n_parameters, sizeof *topics);
    for (size_t k = 0; topics && k < message->n_parameters; k++) {
        const Meniscus__Parameter *from = message->parameters[k];
        topics[k] = (MnsTopicInfo){.name = text(from->path),
                                   .type = text(from->type),
                                   .unit = text(from->unit),
                                   .range = text(from->range),
                                   .value = text(from->value),
                                   .meaning = text(from->meaning),
                                   .takes_effect = text(from->takes_effect)};
    }
    return topics;
}

static const MnsTopicInfo *read_fields(Arena *arena, const Meniscus__Capabilities *message)
{
    MnsTopicInfo *topics = arena_take(arena, message->n_fields, sizeof *topics);
    for (size_t k = 0; topics && k < message->n_fields; k++) {
        const Meniscus__Field *from = message->fields[k];
        topics[k] = (MnsTopicInfo){.name = text(from->name),
                                   .type = "",
                                   .unit = text(from->unit),
                                   .range = "",
                                   .value = "",
                                   .meaning = text(from->meaning),
                                   .takes_effect = "",
                                   .components = from->components};
    }
    return topics;
}

static const MnsTopicInfo *read_schemes(Arena *arena, const Meniscus__Capabilities *message)
{
    MnsTopicInfo *topics = arena_take(arena, message->n_schemes, sizeof *topics);
    for (size_t k = 0; topics && k < message->n_schemes; k++) {
        const Meniscus__SchemeInfo *from = message->schemes[k];
        topics[k] = (MnsTopicInfo){.name = text(from->name),
                                   .type = "",
                                   .unit = "",
                                   .range = "",
                                   .value = "",
                                   .meaning = text(from->description),
                                   .takes_effect = ""};
    }
    return topics;
}

static MnsCapabilities *read_capabilities(Arena *arena, const Meniscus__Capabilities *message)
{
    MnsCapabilities *capabilities = arena_take(arena, 1, sizeof *capabilities);
    if (!capabilities) return NULL;
    *capabilities = (MnsCapabilities){
        .version = text(message->version),
        .build = text(message->build),
        .compiler = text(message->compiler),
        .commit = text(message->commit),
        .n_commands = message->n_commands,
        .n_probes = message->n_probes,
        .n_topics = message->n_topics,
        .n_parameters = message->n_parameters,
        .n_fields = message->n_fields,
        .n_schemes = message->n_schemes,
        .commands = (const char *const *)message->commands,
        .probes = (const char *const *)message->probes,
        .topics = (const char *const *)message->topics,
        .parameters = read_parameters(arena, message),
        .fields = read_fields(arena, message),
        .schemes = read_schemes(arena, message),
    };
    return capabilities->parameters && capabilities->fields && capabilities->schemes ? capabilities : NULL;
}

static MnsOutputFile *read_output(Arena *arena, const Meniscus__OutputFile *message)
{
    MnsOutputFile *output = arena_take(arena, 1, sizeof *output);
    if (output) *output = (MnsOutputFile){.path = text(message->path), .step = message->step, .time = message->time};
    return output;
}

/* The part of the reply that depends on the command. @return false if there is no memory. */
static bool read_result(OwnedReply *owned)
{
    const Meniscus__Reply *message = owned->message;
    MnsReply *reply = &owned->reply;
    switch (message->result_case) {
    case MENISCUS__REPLY__RESULT_STATUS: return (reply->info = read_info(&owned->arena, message->status));
    case MENISCUS__REPLY__RESULT_VALUES:
        reply->n_values = message->values->n_values;
        return (reply->values = reply_values(&owned->arena, reply->n_values, message->values->values));
    case MENISCUS__REPLY__RESULT_OUTPUT: return (reply->output = read_output(&owned->arena, message->output));
    case MENISCUS__REPLY__RESULT_CAPABILITIES:
        return (reply->capabilities = read_capabilities(&owned->arena, message->capabilities));
    case MENISCUS__REPLY__RESULT_LEASE:
        reply->lease_epoch = message->lease->epoch;
        reply->lease_s = 1e-3 * (double)message->lease->ttl_ms;
        return true;
    case MENISCUS__REPLY__RESULT_WAIT: reply->state_reached = message->wait->state_reached; return true;
    default: return true;
    }
}

static MnsStatus read_reply(OwnedReply *owned, Frames *frames, MnsError *error)
{
    const Meniscus__Reply *message = owned->message;
    owned->reply = (MnsReply){.message = text(message->message),
                              .state = (MnsState)message->state,
                              .daemon_epoch = message->daemon_epoch,
                              .step = message->step,
                              .effect_step = message->has_effect_step ? message->effect_step : MNS_NO_STEP,
                              .time = message->time,
                              .case_version = message->case_version};
    if (!read_result(owned)) return mns_fail(error, MNS_E_MEMORY, "no memory for a reply");
    return read_arrays(owned, frames, error);
}

MnsStatus reply_new(Meniscus__Reply *message, Frames *frames, MnsReply **ret, MnsError *error)
{
    OwnedReply *owned = calloc(1, sizeof *owned);
    MnsStatus status = MNS_OK;
    if (owned) {
        owned->message = message;
        status = read_reply(owned, frames, error);
    } else {
        meniscus__reply__free_unpacked(message, NULL);
        status = mns_fail(error, MNS_E_MEMORY, "no memory for a reply");
    }
    frames_done(frames);
    if (status == MNS_OK) *ret = &owned->reply;
    else mns_reply_free(owned ? &owned->reply : NULL);
    return status;
}

void mns_reply_free(MnsReply *reply)
{
    if (!reply) return;
    OwnedReply *owned = (OwnedReply *)reply;
    meniscus__reply__free_unpacked(owned->message, NULL);
    arena_done(&owned->arena);
    free(owned);
}

const MnsArray *mns_reply_array(const MnsReply *reply, const char *name)
{
    for (size_t k = 0; k < reply->n_arrays; k++)
        if (strcmp(reply->arrays[k].name, name) == 0) return &reply->arrays[k];
    return NULL;
}
