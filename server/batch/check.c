/* SPDX-License-Identifier: BSD-3-Clause */
/* A case looked at before it is run: particles, memory, time and doubts, from the simulation itself and a few of its steps. */
#include "batch/check.h"

#include "base/clock.h"
#include "batch/outcome.h"
#include "common/case/file.h"
#include "common/case/find.h"
#include "common/case/name.h"
#include "common/host/text.h"
#include "run/document.h"
#include "run/environment.h"
#include "run/memory.h"
#include "run/outputs.h"
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <meniscus/exit.h>
#include <meniscus/sim.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct Check {
    char path[4096]; /* of the case file */
    char name[CASE_NAME_SIZE];
    CaseFile *file;
    Document *document;
    MnsSim *sim;
    size_t memory_free;
    const char *memory_is;
    double step_s;   /* wall-clock time of a step [s]; NAN: none was tried */
    char files[256]; /* what is doubtful about them; empty if nothing is */
} Check;

static MnsStatus lay_out(Check *check, MnsError *error)
{
    case_name_from_path(check->path, check->name);
    MnsStatus status = document_new(case_file_message(check->file), check->name, &check->document, error);
    MnsMaking making = {.memory = check->memory_free, .memory_is = check->memory_is};
    environment_compute_anew();
    if (!status) status = mns_sim_make(check->document->c, NULL, &making, &check->sim, error);
    if (status == MNS_E_INVALID || status == MNS_E_LIMIT || status == MNS_E_MEMORY)
        case_file_locate(check->file, error);
    return status;
}

/* The first step makes lists for the first time, and is not timed if there are others. */
static MnsStatus try_steps(Check *check, MnsError *error)
{
    enum { LEAST = 2, MOST = 50 };
    static const double patience = 1; /* [s] */
    const double end = check->document->c->end_time, begun = clock_now();
    double timed = begun, first = NAN;
    int n = 0;
    MnsStatus status = MNS_OK;
    for (int k = 0; !status && k < MOST && (k < LEAST || clock_now() - begun < patience); k++) {
        if (mns_sim_progress(check->sim).t >= end) break;
        status = mns_sim_step(check->sim, end, error);
        n = k;
        if (k > 0) continue;
        timed = clock_now();
        first = timed - begun;
    }
    check->step_s = n ? (clock_now() - timed) / n : first;
    return status;
}

/* Of the last step; where that was cut to end with the run, the mean of all. 0: none was tried. */
static double time_step(const Check *check)
{
    const MnsProgress now = mns_sim_progress(check->sim);
    return now.step && now.t >= check->document->c->end_time ? now.t / (double)now.step : now.dt;
}

/* Steps to the end, if all others are as long. */
static double steps_of(const Check *check)
{
    const MnsProgress now = mns_sim_progress(check->sim);
    const double left = check->document->c->end_time - now.t;
    return (double)now.step + (left > 0 && now.dt > 0 ? ceil(left / now.dt) : 0);
}

/* The series of the probes grows until the end. */
static void doubt_files(Check *check)
{
    const MnsCase *c = check->document->c;
    const size_t longest = outputs_longest();
    if (!c->n_probes || !(c->output.probe_interval > 0) || longest == SIZE_MAX) return;
    const double rows = 1 + fmin(steps_of(check), c->end_time / c->output.probe_interval);
    const double size = rows * (double)(sizeof(uint64_t) + (1 + c->n_probes) * sizeof(double));
    if (size < (double)longest) return;
    snprintf(check->files, sizeof check->files,
             "output.probe_interval: probes.hdf will have some %.3g rows and %.3g kB, and the limit on the size of "
             "files is %.6g kB, where the run ends; raise the limit (`ulimit -f`) or have fewer rows",
             rows, 1e-3 * size, 1e-3 * (double)longest);
}

static MnsStatus look(Check *check, const BatchOptions *options, MnsError *error)
{
    check->memory_free = memory_free("", &check->memory_is);
    MnsStatus status = case_find(options->name, check->path, error);
    if (!status)
        status = case_file_read_with(check->path, options->n_settings, (const char *const *)options->settings,
                                     &check->file, error);
    if (!status) status = lay_out(check, error);
    if (!status) status = outputs_fit(check->sim, error);
    if (!status) status = try_steps(check, error);
    if (!status) doubt_files(check);
    return status;
}

static int exit_code(MnsStatus status)
{
    switch (status) {
    case MNS_OK: return MNS_EXIT_DONE;
    case MNS_E_INVALID:
    case MNS_E_NOT_FOUND:
    case MNS_E_MEMORY: /* it takes more than there is */
    case MNS_E_LIMIT: return MNS_EXIT_BAD_CASE;
    case MNS_E_DIVERGED: return MNS_EXIT_DIVERGED;
    case MNS_E_NO_SPACE:
    case MNS_E_IO: return MNS_EXIT_IO;
    default: return MNS_EXIT_FAILED;
    }
}

/* --- what came of it ---------------------------------------------------------------------------------------------------- */

static const char *doubt(const Check *check, size_t k)
{
    size_t n = 0;
    while (n < k && check->sim && mns_sim_warning(check->sim, n)) n++;
    const char *text = n == k && check->sim ? mns_sim_warning(check->sim, k) : NULL;
    return text || n < k || !check->files[0] ? text : check->files;
}

static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *doubts_of(const Check *check)
{
    json_t *list = json_array();
    const char *text;
    for (size_t k = 0; (text = doubt(check, k)); k++) json_array_append_new(list, outcome_text(text));
    return list;
}

static json_t *as_json(const Check *check)
{
    const double steps = steps_of(check);
    return json_pack("{ss so sI sI sf so sf sI so sI sI so so}", "case", check->name, "file", outcome_text(check->path),
                     "particles", (json_int_t)mns_sim_particles(check->sim), "fluid_particles",
                     (json_int_t)mns_sim_fluid_particles(check->sim), "spacing", mns_sim_spacing(check->sim),
                     "time_step", number(time_step(check)), "end_time", check->document->c->end_time, "threads",
                     (json_int_t)mns_sim_threads(check->sim), "steps", number(steps), "memory_bytes",
                     (json_int_t)mns_sim_bytes(check->sim), "memory_free_bytes",
                     (json_int_t)(check->memory_free < INT64_MAX ? check->memory_free : INT64_MAX), "wall_s",
                     number(steps * check->step_s), "doubts", doubts_of(check));
}

static void print_duration(double seconds)
{
    if (seconds < 120) printf("%.2g s", seconds);
    else if (seconds < 7200) printf("%.0f minutes", seconds / 60);
    else printf("%.1f hours", seconds / 3600);
}

static size_t print_doubts(const Check *check)
{
    size_t n = 0;
    for (const char *text; (text = doubt(check, n)); n++) printf("  doubtful   %s\n", text_shown(text));
    return n;
}

static void print_lines(const Check *check)
{
    const size_t n = mns_sim_particles(check->sim);
    const double steps = steps_of(check);
    printf("%s: %zu particles, %zu of fluid, %.4g m apart\n", check->name, n, mns_sim_fluid_particles(check->sim),
           mns_sim_spacing(check->sim));
    printf("  memory     %.3g MB, and %.3g MB are %s\n", 1e-6 * (double)mns_sim_bytes(check->sim),
           1e-6 * (double)check->memory_free, check->memory_is);
    if (isfinite(check->step_s)) {
        printf("  time step  %.3g s, which makes some %.3g steps to t = %.6g s\n", time_step(check), steps,
               check->document->c->end_time);
        printf("  time       some ");
        print_duration(steps * check->step_s);
        printf(" with %d thread%s, without what is written (%.4g ns per particle and step)\n",
               mns_sim_threads(check->sim), mns_sim_threads(check->sim) == 1 ? "" : "s",
               1e9 * check->step_s / (double)n);
    }
    if (!print_doubts(check)) puts("  nothing is doubtful");
}

/* What is doubtful comes before the error, of which it may be the cause: in a file with both it stands there too. */
static void print_failure(const Check *check, const BatchOptions *options, const MnsError *error, int code)
{
    if (!options->json && print_doubts(check)) fflush(stdout);
    outcome_complain(check->path, error);
    if (options->json)
        outcome_print_json(json_pack("{so so}", "doubts", doubts_of(check), "error", outcome_failure(error, code)),
                           JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(17));
}

static void print_findings(const Check *check, const BatchOptions *options)
{
    if (options->json) outcome_print_json(as_json(check), JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(17));
    else print_lines(check);
}

int check_case(const BatchOptions *options)
{
    Check check = {.step_s = NAN};
    MnsError error = {.status = MNS_OK};
    environment_threads();
    const MnsStatus status = look(&check, options, &error);
    const int code = exit_code(status);
    if (status) print_failure(&check, options, &error, code);
    else print_findings(&check, options);
    mns_sim_free(check.sim);
    document_leave(check.document);
    case_file_free(check.file);
    return code;
}
