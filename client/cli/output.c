/* SPDX-License-Identifier: BSD-3-Clause */
/* Replies as JSON with stable keys. A key that a reply may have is always there: null if there is nothing to say. */
#include "client/cli/output.h"
#include "common/host/screen.h"
#include "common/host/text.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

MnsStatus output_json(json_t *object, MnsError *error)
{
    if (!object) return mns_fail(error, MNS_E_MEMORY, "no memory for the output");
    char *line = json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(17)), *shown = line ? text_escaped(line) : NULL;
    json_decref(object);
    free(line);
    if (!shown) return mns_fail(error, MNS_E_MEMORY, "no memory for the output");
    puts(shown);
    free(shown);
    return screen_flush(error);
}

json_t *output_text(const char *text)
{
    char *valid = text ? text_valid(text) : NULL;
    json_t *string = valid ? json_string(valid) : text ? NULL : json_null();
    free(valid);
    return string;
}

json_t *output_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

/* A 64-bit pattern as 16 hex digits: JSON numbers cannot hold it. */
static json_t *hex(uint64_t value)
{
    return json_sprintf("%016" PRIx64, value);
}

json_t *output_values(size_t n, const MnsValue *values)
{
    json_t *object = json_object();
    for (size_t k = 0; k < n; k++) {
        const bool is_text = values[k].text && !isfinite(values[k].number);
        json_t *value = is_text ? output_text(values[k].text) : output_number(values[k].number);
        json_object_set_new(object, values[k].name, json_pack("{so ss}", "value", value, "unit", values[k].unit));
    }
    return object;
}

double output_element(const MnsArray *array, size_t k)
{
    if (strcmp(array->type, "<f8") == 0) return ((const double *)array->data)[k];
    if (strcmp(array->type, "<f4") == 0) return (double)((const float *)array->data)[k];
    if (strcmp(array->type, "<u8") == 0) return (double)((const uint64_t *)array->data)[k];
    if (strcmp(array->type, "<u4") == 0) return (double)((const uint32_t *)array->data)[k];
    return strcmp(array->type, "|u1") == 0 ? (double)((const uint8_t *)array->data)[k] : (double)NAN;
}

static json_t *element(const MnsArray *array, size_t k)
{
    const double value = output_element(array, k);
    return array->type[1] == 'f' || isnan(value) ? output_number(value) : json_integer((json_int_t)value);
}

/* The part of the array that begins at *k, from dimension d on. */
static json_t *nested(const MnsArray *array, size_t d, size_t *k)
{
    if (d == array->n_dims) return element(array, (*k)++);
    json_t *list = json_array();
    for (size_t i = 0; i < array->shape[d]; i++) json_array_append_new(list, nested(array, d + 1, k));
    return list;
}

json_t *output_array(const MnsArray *array)
{
    size_t k = 0;
    json_t *shape = json_array();
    for (size_t d = 0; d < array->n_dims; d++) json_array_append_new(shape, json_integer((json_int_t)array->shape[d]));
    return json_pack("{ss ss so so}", "unit", array->unit, "type", array->type, "shape", shape, "values",
                     nested(array, 0, &k));
}

json_t *output_reply(const MnsReply *reply)
{
    json_t *effect = reply->effect_step == MNS_NO_STEP ? json_null() : json_integer((json_int_t)reply->effect_step);
    json_t *version = reply->case_version ? json_integer((json_int_t)reply->case_version) : json_null();
    return json_pack("{ss sI so so so so so}", "state", mns_state_name(reply->state), "step", (json_int_t)reply->step,
                     "time", output_number(reply->time), "effect_step", effect, "daemon_epoch",
                     hex(reply->daemon_epoch), "message", output_text(reply->message), "case_version", version);
}

static json_t *timers(const MnsRunInfo *info)
{
    json_t *list = json_array();
    for (size_t k = 0; k < info->n_timers; k++)
        json_array_append_new(list, json_pack("{ss so sI}", "name", info->timers[k].name, "seconds",
                                              output_number(info->timers[k].seconds), "calls",
                                              (json_int_t)info->timers[k].calls));
    return list;
}

void output_id(const uint8_t id[MNS_REQUEST_ID_SIZE], char ret[2 * MNS_REQUEST_ID_SIZE + 1])
{
    for (size_t k = 0; k < MNS_REQUEST_ID_SIZE; k++) snprintf(ret + 2 * k, 3, "%02x", id[k]);
}

static json_t *breakpoints(const MnsRunInfo *info)
{
    json_t *list = json_array();
    for (size_t k = 0; k < info->n_breakpoints; k++) {
        const MnsBreakpoint *at = &info->breakpoints[k];
        json_array_append_new(list,
                              json_pack("{so so so so}", "name", output_text(at->name), "time", output_number(at->time),
                                        "step", at->step ? json_integer((json_int_t)at->step) : json_null(), "when",
                                        output_text(at->condition)));
    }
    return list;
}

static json_t *scheduled(const MnsRunInfo *info)
{
    json_t *list = json_array();
    for (size_t k = 0; k < info->n_scheduled; k++) {
        const MnsScheduled *at = &info->scheduled[k];
        char id[2 * MNS_REQUEST_ID_SIZE + 1];
        output_id(at->id, id);
        json_array_append_new(
            list, json_pack("{ss so so so so}", "id", id, "at_step",
                            at->at_step == MNS_NO_STEP ? json_null() : json_integer((json_int_t)at->at_step), "at_time",
                            output_number(at->at_time), "who", output_text(at->who), "what", output_text(at->what)));
    }
    return list;
}

static json_t *streams(const MnsStreamsNow *at)
{
    return at ? json_pack("{sI sI sI sI}", "latest", (json_int_t)at->latest, "lossless", (json_int_t)at->lossless,
                          "memory_bytes", (json_int_t)at->memory_bytes, "skipped", (json_int_t)at->skipped)
              : json_null();
}

/* json_pack() takes far more pairs than fit on a screen; the keys come in groups. */
json_t *output_info(const MnsRunInfo *info)
{
    json_t *object =
        json_pack("{ss so so so so ss? ss}", "state", mns_state_name(info->state), "case", output_text(info->case_name),
                  "title", output_text(info->title), "run_directory", output_text(info->run_directory), "fault",
                  output_text(*info->fault ? info->fault : NULL), "fault_reason",
                  info->fault_status ? mns_status_name(info->fault_status) : NULL, "version", info->version);
    json_t *times = json_pack(
        "{so so so so so so so so}", "time", output_number(info->time), "end_time", output_number(info->end_time),
        "time_step", output_number(info->time_step), "eta_s", output_number(info->eta_s), "wall_s",
        output_number(info->wall_s), "steps_per_second", output_number(info->steps_per_second), "ns_per_particle_step",
        output_number(info->ns_per_particle_step), "energy_excess", output_number(info->energy_excess));
    json_t *counts =
        json_pack("{sI sI sI sI sI sI sI sI so}", "step", (json_int_t)info->step, "particles",
                  (json_int_t)info->particles, "fluid_particles", (json_int_t)info->fluid_particles, "guarded",
                  (json_int_t)info->guarded, "uncorrected", (json_int_t)info->uncorrected, "samples_dropped",
                  (json_int_t)info->samples_dropped, "memory_bytes", (json_int_t)info->memory_bytes, "threads",
                  (json_int_t)info->threads, "state_hash", info->state_hash ? hex(info->state_hash) : json_null());
    json_object_update_new(object, times);
    json_object_update_new(object, counts);
    json_object_set_new(object, "case_version",
                        info->case_version ? json_integer((json_int_t)info->case_version) : json_null());
    json_object_set_new(object, "recovery_step",
                        info->recovery_step == MNS_NO_STEP ? json_null()
                                                           : json_integer((json_int_t)info->recovery_step));
    json_object_set_new(object, "lease_holder", output_text(*info->lease_holder ? info->lease_holder : NULL));
    json_object_set_new(object, "lease_s", output_number(info->lease_s));
    json_object_set_new(object, "timers", timers(info));
    json_object_set_new(object, "breakpoints", breakpoints(info));
    json_object_set_new(object, "scheduled", scheduled(info));
    json_object_set_new(object, "streams", streams(info->streams));
    return object;
}

static json_t *topic(const MnsTopicInfo *t)
{
    return json_pack("{ss ss ss so so so ss sI}", "name", t->name, "type", t->type, "unit", t->unit, "range",
                     output_text(t->range), "value", output_text(t->value), "meaning", output_text(t->meaning),
                     "takes_effect", t->takes_effect, "components", (json_int_t)t->components);
}

static json_t *topics(size_t n, const MnsTopicInfo *list)
{
    json_t *array = json_array();
    for (size_t k = 0; k < n; k++) json_array_append_new(array, topic(&list[k]));
    return array;
}

static json_t *names(size_t n, const char *const *list)
{
    json_t *array = json_array();
    for (size_t k = 0; k < n; k++) json_array_append_new(array, output_text(list[k]));
    return array;
}

json_t *output_capabilities(const MnsCapabilities *c)
{
    return json_pack("{ss ss ss ss so so so so so so}", "version", c->version, "build", c->build, "compiler",
                     c->compiler, "commit", c->commit, "commands", names(c->n_commands, c->commands), "topics",
                     names(c->n_topics, c->topics), "probes", names(c->n_probes, c->probes), "parameters",
                     topics(c->n_parameters, c->parameters), "fields", topics(c->n_fields, c->fields), "schemes",
                     topics(c->n_schemes, c->schemes));
}

static const char *topic_name(MnsTopic topic)
{
    switch (topic) {
    case MNS_TOPIC_EVENT: return "event";
    case MNS_TOPIC_LOG: return "log";
    case MNS_TOPIC_PROGRESS: return "progress";
    default: return "probe";
    }
}

json_t *output_telemetry(const MnsTelemetry *m)
{
    json_t *object =
        json_pack("{ss sI sI sI so}", "topic", topic_name(m->topic), "sequence", (json_int_t)m->sequence, "lost",
                  (json_int_t)m->lost, "step", (json_int_t)m->step, "time", output_number(m->time));
    json_t *more = NULL;
    if (m->topic == MNS_TOPIC_EVENT)
        more = json_pack("{ss so so}", "state", mns_state_name(m->state), "what", output_text(m->what), "text",
                         output_text(m->text));
    if (m->topic == MNS_TOPIC_LOG)
        more = json_pack("{sI so}", "level", (json_int_t)m->level, "text", output_text(m->text));
    if (m->topic == MNS_TOPIC_PROBE) more = json_pack("{so}", "values", output_values(m->n_values, m->values));
    if (m->topic == MNS_TOPIC_PROGRESS)
        more =
            json_pack("{ss so so so so so}", "state", mns_state_name(m->state), "fraction", output_number(m->fraction),
                      "eta_s", output_number(m->eta_s), "steps_per_second", output_number(m->steps_per_second),
                      "time_step", output_number(m->time_step), "end_time", output_number(m->end_time));
    if (more) json_object_update_new(object, more);
    return object;
}

json_t *output_failure(const MnsError *error, const char *hint, int code)
{
    return json_pack("{s{ss so so ss si}}", "error", "status", mns_status_name(error->status), "message",
                     output_text(error->text), "path", output_text(error->path), "hint", hint, "exit_code", code);
}

const char *output_unit(const char *unit)
{
    return strcmp(unit, "1") ? unit : "";
}

void output_print_values(size_t n, const MnsValue *values)
{
    int width = 0;
    for (size_t k = 0; k < n; k++)
        if ((int)strlen(values[k].name) > width) width = (int)strlen(values[k].name);
    for (size_t k = 0; k < n; k++) {
        const char *unit = output_unit(values[k].unit), *gap = *unit ? " " : "";
        if (values[k].text) printf("%-*s = %s%s%s\n", width, values[k].name, text_shown(values[k].text), gap, unit);
        else if (isnan(values[k].number)) printf("%-*s = none\n", width, values[k].name); /* as a front of no fluid */
        else printf("%-*s = %.6g%s%s\n", width, values[k].name, values[k].number, gap, unit);
    }
}
