/* SPDX-License-Identifier: BSD-3-Clause */
/* What a daemon says of itself. */
#include "net/describe.h"

#include "base/clock.h"
#include "common/case/file.h"
#include "net/publish.h"
#include "net/subscribe.h"
#include <math.h>
#include <meniscus/sim.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef MENISCUS_COMMIT
#define MENISCUS_COMMIT ""
#endif
#ifdef __clang__
#define COMPILER "clang " __clang_version__
#else
#define COMPILER "gcc " __VERSION__
#endif

const char *describe_commit(void)
{
    return MENISCUS_COMMIT;
}

const char *describe_compiler(void)
{
    return COMPILER;
}

/* Room for n pointers; *ret_n counts those in it. */
static void *pointers(size_t n)
{
    return calloc(n + 1, sizeof(void *));
}

static void set_number(double value, protobuf_c_boolean *has, double *to)
{
    *has = isfinite(value);
    *to = value;
}

static void add_timers(Meniscus__Status *message, const RunStatus *status)
{
    message->timers = pointers(status->n_timers);
    for (size_t k = 0; message->timers && k < status->n_timers; k++) {
        Meniscus__Timer *timer = malloc(sizeof *timer);
        if (!timer) return;
        meniscus__timer__init(timer);
        timer->name = strdup(status->timers[k].name);
        timer->has_seconds = timer->has_calls = true;
        timer->seconds = status->timers[k].seconds;
        timer->calls = status->timers[k].calls;
        message->timers[message->n_timers++] = timer;
    }
}

static void add_breakpoints(Meniscus__Status *message, const RunStatus *status)
{
    message->breakpoints = pointers(status->n_breakpoints);
    for (size_t k = 0; message->breakpoints && k < status->n_breakpoints; k++) {
        const Breakpoint *from = &status->breakpoints[k];
        Meniscus__SetBreakpoint *point = malloc(sizeof *point);
        if (!point) return;
        meniscus__set_breakpoint__init(point);
        point->name = strdup(from->name);
        if (from->condition[0]) point->condition = strdup(from->condition);
        set_number(from->t, &point->has_time, &point->time);
        point->has_step = from->step > 0;
        point->step = from->step;
        message->breakpoints[message->n_breakpoints++] = point;
    }
}

static void add_scheduled(Meniscus__Status *message, const RunStatus *status)
{
    message->scheduled = pointers(status->n_scheduled);
    for (size_t k = 0; message->scheduled && k < status->n_scheduled; k++) {
        const RunScheduled *from = &status->scheduled[k];
        Meniscus__Scheduled *item = malloc(sizeof *item);
        if (!item) return;
        meniscus__scheduled__init(item);
        item->id.data = malloc(ORDER_ID);
        item->has_id = item->id.data != NULL;
        if (item->has_id) memcpy(item->id.data, from->id, item->id.len = ORDER_ID);
        item->has_at_step = from->at.step != UINT64_MAX;
        item->at_step = from->at.step;
        item->has_at_time = isfinite(from->at.t);
        item->at_time = from->at.t;
        item->who = strdup(from->who);
        item->what = strdup(from->what);
        message->scheduled[message->n_scheduled++] = item;
    }
}

static void add_numbers(Meniscus__Status *message, const RunStatus *status)
{
    message->has_step = message->has_particles = message->has_fluid_particles = message->has_guarded = true;
    message->has_uncorrected = true;
    message->has_samples_dropped = message->has_threads = message->has_memory_bytes = true;
    message->step = status->progress.step;
    message->particles = status->particles;
    message->fluid_particles = status->fluid_particles;
    message->guarded = status->progress.guarded;
    message->uncorrected = status->uncorrected;
    message->samples_dropped = status->samples_dropped;
    message->has_recovery_step = status->state == RUN_RECOVERING;
    message->recovery_step = status->recovery_step;
    message->threads = status->threads;
    message->memory_bytes = status->bytes;
    message->has_state_hash = status->hash != 0;
    message->state_hash = status->hash;
    set_number(status->progress.t, &message->has_time, &message->time);
    set_number(status->end_time, &message->has_end_time, &message->end_time);
    set_number(status->progress.dt, &message->has_time_step, &message->time_step);
    set_number(status->steps_per_second, &message->has_steps_per_second, &message->steps_per_second);
    set_number(status->ns_per_particle_step, &message->has_ns_per_particle_step, &message->ns_per_particle_step);
    set_number(status->energy_excess, &message->has_energy_excess, &message->energy_excess);
    set_number(status->eta, &message->has_eta_s, &message->eta_s);
    set_number(status->wall, &message->has_wall_s, &message->wall_s);
    set_number(status->age, &message->has_age_s, &message->age_s);
    const double left = status->lease.until - clock_now();
    if (status->lease.epoch && left > 0) {
        message->lease_holder = strdup(status->lease.holder);
        set_number(left, &message->has_lease_s, &message->lease_s);
    }
    message->has_case_version = status->version > 0;
    message->case_version = status->version;
}

static void add_streams(Meniscus__Status *message, const StreamTraffic *traffic)
{
    Meniscus__StreamsNow *streams = malloc(sizeof *streams);
    if (!streams) return;
    meniscus__streams_now__init(streams);
    streams->has_latest = streams->has_lossless = streams->has_memory_bytes = streams->has_skipped = true;
    for (int k = 0; k < TRAFFIC_STREAMS; k++) {
        *(stream_is_latest((StreamKind)k) ? &streams->latest : &streams->lossless) += traffic->open[k];
        streams->skipped += traffic->skipped[k];
    }
    streams->memory_bytes = traffic->memory + traffic->copies;
    message->streams = streams;
}

Meniscus__Status *describe_status(const RunStatus *status, const StreamTraffic *streams)
{
    Meniscus__Status *message = malloc(sizeof *message);
    if (!message) return NULL;
    meniscus__status__init(message);
    message->has_state = true;
    message->state = (Meniscus__State)status->state;
    message->version = strdup(MENISCUS_VERSION);
    if (status->fault.status) message->fault = strdup(status->fault.text);
    if (status->fault.status) message->fault_reason = strdup(mns_status_name(status->fault.status));
    if (streams) add_streams(message, streams);
    if (!status->particles) return message;
    message->case_name = strdup(status->case_name);
    message->title = strdup(status->title);
    message->run_directory = strdup(status->directory);
    add_numbers(message, status);
    add_timers(message, status);
    add_breakpoints(message, status);
    add_scheduled(message, status);
    return message;
}

/* One more in a list with room for it. Only what is there counts: whoever packs the list looks at each. */
static void add_text(char **to, size_t *ret_n, const char *text)
{
    to[*ret_n] = strdup(text);
    *ret_n += to[*ret_n] != NULL;
}

/* A list that ends with NULL. */
static void add_texts(char ***to, size_t *ret_n, const char *const *list)
{
    size_t n = 0;
    while (list[n]) n++;
    *to = pointers(n);
    for (size_t k = 0; *to && k < n; k++) add_text(*to, ret_n, list[k]);
}

/* Of a case that is loaded, those that it could have; without one, all. */
static void add_parameters(Meniscus__Capabilities *message, const Document *document)
{
    size_t n;
    const CaseParameter *table = case_parameters(&n);
    message->parameters = pointers(n);
    for (size_t k = 0; message->parameters && k < n; k++) {
        const char *unit;
        if (document && case_message_steers(document->message, table[k].path, NULL)) continue;
        Meniscus__Parameter *parameter = malloc(sizeof *parameter);
        if (!parameter) return;
        meniscus__parameter__init(parameter);
        parameter->path = strdup(table[k].path);
        parameter->type = strdup(table[k].type);
        parameter->unit = strdup(table[k].unit);
        parameter->range = strdup(table[k].range);
        parameter->meaning = strdup(table[k].meaning);
        parameter->takes_effect = strdup("from the next step"); /* all of them: `set` is served between two steps */
        if (document) case_message_get(document->message, table[k].path, &parameter->value, &unit, NULL);
        message->parameters[message->n_parameters++] = parameter;
    }
}

/* Of those that there are in the case; 0: there is no case, and all are listed. */
static void add_fields(Meniscus__Capabilities *message, uint64_t there)
{
    const MnsFieldInfo *table = mns_fields();
    message->fields = pointers(MNS_MAX_FIELDS);
    for (size_t k = 0; message->fields && k < MNS_MAX_FIELDS && table[k].name; k++) {
        if (there && !(there >> k & 1)) continue;
        Meniscus__Field *field = malloc(sizeof *field);
        if (!field) return;
        meniscus__field__init(field);
        field->name = strdup(table[k].name);
        field->unit = strdup(table[k].unit);
        field->meaning = strdup(table[k].meaning);
        field->has_components = true;
        field->components = (uint32_t)table[k].components;
        message->fields[message->n_fields++] = field;
    }
}

static void add_probes(Meniscus__Capabilities *message, const MnsCase *c)
{
    message->probes = pointers(c->n_probes);
    for (size_t k = 0; message->probes && k < c->n_probes; k++)
        add_text(message->probes, &message->n_probes, c->probes[k].name);
}

static void add_schemes(Meniscus__Capabilities *message)
{
    enum { SCHEMES = 16, TEXT = 1 << 15 };
    char *text = malloc(TEXT);
    const char *name;
    message->schemes = pointers(SCHEMES);
    for (size_t k = 0; text && message->schemes && k < SCHEMES && (name = mns_scheme_describe(k, text, TEXT)); k++) {
        Meniscus__SchemeInfo *scheme = malloc(sizeof *scheme);
        if (!scheme) break;
        meniscus__scheme_info__init(scheme);
        scheme->name = strdup(name);
        scheme->description = strdup(text);
        message->schemes[message->n_schemes++] = scheme;
    }
    free(text);
}

Meniscus__Capabilities *describe_capabilities(const char *const *commands, const Document *document, uint64_t fields)
{
    Meniscus__Capabilities *message = malloc(sizeof *message);
    if (!message) return NULL;
    meniscus__capabilities__init(message);
    message->version = strdup(MENISCUS_VERSION);
    char build[256];
    snprintf(build, sizeof build, "%s, C17, %s%s%s", COMPILER, mns_level(), *MENISCUS_COMMIT ? ", commit " : "",
             MENISCUS_COMMIT);
    message->build = strdup(build);
    message->compiler = strdup(COMPILER);
    if (*MENISCUS_COMMIT) message->commit = strdup(MENISCUS_COMMIT);
    add_texts(&message->commands, &message->n_commands, commands);
    add_parameters(message, document);
    add_fields(message, fields);
    if (document) add_probes(message, document->c);
    add_schemes(message);
    add_texts(&message->topics, &message->n_topics, publisher_topics());
    return message;
}
