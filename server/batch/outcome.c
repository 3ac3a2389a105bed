/* SPDX-License-Identifier: BSD-3-Clause */
/* What came of a run, as one JSON object with a number wherever there is one and null where there is none. */
#include "batch/outcome.h"
#include "base/log.h"
#include "common/host/screen.h"
#include "common/host/text.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <meniscus/exit.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A run that needed no step to be where it was asked to stop stands like any other that stopped there. */
static const char *state_name(const RunStatus *status)
{
    const bool stood = status->state == RUN_READY && status->progress.step > 0;
    return run_state_name(stood ? RUN_PAUSED : status->state);
}

static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *integer(uint64_t value)
{
    return json_integer((json_int_t)value);
}

json_t *outcome_text(const char *text)
{
    char *valid = text ? text_valid(text) : NULL;
    json_t *string = valid ? json_string(valid) : text ? NULL : json_null();
    free(valid);
    return string;
}

static json_t *probes_of(const Outcome *outcome)
{
    json_t *probes = json_object();
    const MnsCase *c = outcome->document ? outcome->document->c : NULL;
    for (size_t k = 0; c && k < c->n_probes; k++)
        json_object_set_new(
            probes, c->probes[k].name,
            json_pack("{s:o,s:s}", "value", number(outcome->probes[k]), "unit", mns_probe_unit(&c->probes[k])));
    return probes;
}

static json_t *outputs_of(const Outcome *outcome)
{
    json_t *outputs = json_array();
    char **names;
    size_t n;
    if (!outcome->directory[0] || rundir_list(outcome->directory, &names, &n, NULL)) return outputs;
    for (size_t k = 0; k < n; k++) {
        char path[4096 + 256];
        snprintf(path, sizeof path, "%s/%s", outcome->directory, names[k]);
        json_array_append_new(outputs, outcome_text(path));
        free(names[k]);
    }
    free(names);
    return outputs;
}

static json_t *timers_of(const RunStatus *status)
{
    json_t *timers = json_object();
    for (size_t k = 0; k < status->n_timers; k++)
        json_object_set_new(timers, status->timers[k].name, number(status->timers[k].seconds));
    return timers;
}

static json_t *hash_of(const RunStatus *status)
{
    return status->particles ? json_sprintf("%016" PRIx64, status->hash) : json_null();
}

static json_t *failure(MnsStatus status, const char *message, const char *path, const char *hint, int code)
{
    return json_pack("{ss so so ss si}", "status", mns_status_name(status), "message", outcome_text(message), "path",
                     outcome_text(path), "hint", hint, "exit_code", code);
}

#define GO_ON "give the same command again, with --resume auto to go on from the checkpoint if there is one"

const char *outcome_hint(MnsStatus status)
{
    switch (status) {
    case MNS_E_NOT_FOUND: return "check the name; the message says what there is";
    case MNS_E_STATE: return "mend what the message names and try again";
    case MNS_E_DIVERGED:
        return "look at the last snapshot, then run the case again with what the message advises, as with --set";
    case MNS_E_IO: return "see to the file or directory that the message names, then " GO_ON;
    case MNS_E_NO_SPACE:
        return "make room, or where a file is too large raise the limit on the size of files (`ulimit -f`); "
               "then " GO_ON;
    case MNS_E_INTERRUPTED: return GO_ON;
    default: return mns_status_hint(status);
    }
}

static const char *hint_for(const Outcome *outcome, MnsStatus status)
{
    if (status == MNS_E_STATE && !outcome->document) return "wait until the other run has ended, or give another --out";
    if (status == MNS_E_CORRUPT && !outcome->document)
        return "copy a whole checkpoint into a new directory and give that as --out, with --resume auto; or begin anew "
               "without --resume, which keeps what was there in `abandoned`";
    return outcome_hint(status);
}

json_t *outcome_failure(const MnsError *error, int code)
{
    if (!error->status) return json_null();
    /* A file that is not there is no name of a field or a probe. */
    const MnsStatus kind = code == MNS_EXIT_IO && error->status == MNS_E_NOT_FOUND ? MNS_E_IO : error->status;
    return failure(error->status, error->text, error->path, outcome_hint(kind), code);
}

/* Why the run is not whole, as every command of `meniscus` says it; null if it is. */
static json_t *error_of(const Outcome *outcome)
{
    const MnsError *cause = outcome->status.fault.status ? &outcome->status.fault : &outcome->error;
    if (cause->status)
        return failure(cause->status, cause->text, cause->path, hint_for(outcome, cause->status), outcome->code);
    if (outcome->code == MNS_EXIT_DONE) return json_null();
    return failure(MNS_E_INTERRUPTED, "a signal stopped the run, after a checkpoint", "",
                   outcome_hint(MNS_E_INTERRUPTED), outcome->code);
}

static json_t *as_json(const Outcome *outcome)
{
    const RunStatus *status = &outcome->status;
    const MnsProgress *at = &status->progress;
    json_t *object = json_object();
    json_object_set_new(object, "state", json_string(state_name(status)));
    json_object_set_new(object, "case", outcome_text(status->case_name));
    json_object_set_new(object, "run_directory", outcome_text(outcome->directory));
    json_object_set_new(object, "t", number(at->t));
    json_object_set_new(object, "end_time", number(status->end_time));
    json_object_set_new(object, "steps", integer(at->step));
    json_object_set_new(object, "time_step", number(at->dt));
    json_object_set_new(object, "particles", integer(status->particles));
    json_object_set_new(object, "fluid_particles", integer(status->fluid_particles));
    json_object_set_new(object, "threads", integer(status->threads));
    json_object_set_new(object, "wall_s", number(status->wall));
    json_object_set_new(object, "ns_per_particle_step", number(status->ns_per_particle_step));
    json_object_set_new(object, "guarded", integer(at->guarded));
    json_object_set_new(object, "uncorrected", integer(status->uncorrected));
    json_object_set_new(object, "energy_excess", number(status->energy_excess));
    json_object_set_new(object, "escaped_share", number(status->losses.escaped_share));
    json_object_set_new(object, "least_coverage", number(status->losses.least_coverage));
    json_object_set_new(object, "rebuilds", integer(at->rebuilds));
    json_object_set_new(object, "state_hash", hash_of(status));
    json_object_set_new(object, "probes", probes_of(outcome));
    json_object_set_new(object, "outputs", outputs_of(outcome));
    json_object_set_new(object, "timers", timers_of(status));
    json_object_set_new(object, "fault", outcome_text(status->fault.status ? status->fault.text : NULL));
    json_object_set_new(object, "error", error_of(outcome));
    json_object_set_new(object, "exit_code", json_integer(outcome->code));
    return object;
}

/* A number without a unit is one by itself. */
static void print_probe(const char *name, double value, const char *unit)
{
    printf("  %-24s %.9g%s%s\n", name, value, strcmp(unit, "1") ? " " : "", strcmp(unit, "1") ? unit : "");
}

static const double COVERED = 0.75; /* sum of W V: what has no less has no voids */

static void print_lines(const Outcome *outcome)
{
    const RunStatus *status = &outcome->status;
    if (!outcome->document) return;
    printf("%s: %s at t = %.9g s, step %" PRIu64 ", %zu particles\n", status->case_name, state_name(status),
           status->progress.t, status->progress.step, status->particles);
    printf("  %.1f s of wall-clock time, ", status->wall);
    if (isfinite(status->ns_per_particle_step)) /* else there was no step */
        printf("%.1f ns per particle and step, ", status->ns_per_particle_step);
    printf("%u threads, state %016" PRIx64 "\n", status->threads, status->hash);
    const MnsCase *c = outcome->document->c;
    for (size_t k = 0; k < c->n_probes; k++)
        print_probe(c->probes[k].name, outcome->probes[k], mns_probe_unit(&c->probes[k]));
    if (status->progress.guarded) printf("  kept from walls %" PRIu64 " times\n", status->progress.guarded);
    if (status->uncorrected)
        printf("  densities off by more than the case allows after %" PRIu64 " steps\n", status->uncorrected);
    if (status->energy_excess > 0)
        printf("  energy made of nothing: %.2g %% of the largest of kinetic energy and change of potential energy\n",
               100 * status->energy_excess);
    if (status->losses.escaped_share > 0)
        printf("  outside of the domain or deep in walls: %.2g %% of the fluid particles\n",
               100 * status->losses.escaped_share);
    if (status->losses.least_coverage < COVERED)
        printf("  voids: a place had %.2g of the fluid that would fill it\n", status->losses.least_coverage);
    printf("  files in %s\n", outcome->directory);
    if (outcome->code == MNS_EXIT_AGAIN) printf("  to go on: %s\n", outcome_hint(MNS_E_INTERRUPTED));
    else if (!strcmp(state_name(status), run_state_name(RUN_PAUSED)))
        puts("  to go on: give the same command again, with --resume auto and without --until or with a later one");
}

int outcome_print_json(json_t *object, size_t flags)
{
    char *line = object ? json_dumps(object, flags) : NULL, *shown = line ? text_escaped(line) : NULL;
    const int failed = shown ? puts(shown) : EOF;
    json_decref(object);
    free(line);
    free(shown);
    return failed < 0 ? failed : 0;
}

static int print_json(json_t *object)
{
    return outcome_print_json(object, JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(17));
}

MnsStatus outcome_print(const Outcome *outcome, bool json, MnsError *error)
{
    if (!json) print_lines(outcome);
    else if (print_json(as_json(outcome)) && !ferror(stdout))
        return mns_fail(error, MNS_E_MEMORY, "no memory for the output");
    return screen_flush(error);
}

void outcome_print_refusal(const MnsError *error, const char *hint, int code)
{
    print_json(
        json_pack("{so si}", "error", failure(error->status, error->text, error->path, hint, code), "exit_code", code));
    fflush(stdout);
}

void outcome_complain(const char *path, const MnsError *error)
{
    const size_t n = strlen(path);
    const bool in_file = n && !strncmp(error->text, path, n) && error->text[n] == ':';
    const bool placed = in_file || !strncmp(error->text, "--set ", 6);
    if (placed) fprintf(stderr, "%s\n", text_shown(error->text));
    else fprintf(stderr, "%s: %s\n", log_program(), text_shown(error->text));
}

void outcome_done(Outcome *outcome)
{
    document_leave(outcome->document);
}
