/* SPDX-License-Identifier: BSD-3-Clause */
/* The command line of meniscusd: what to do, and nothing of how. */
#include "base/log.h"
#include "batch/batch.h"
#include <argp.h>
#include <math.h>
#include <meniscus/exit.h>
#include <stdlib.h>
#include <string.h>

const char *argp_program_version = "meniscusd " MENISCUS_VERSION;

enum { KEY_BATCH = 256, KEY_OUT, KEY_UNTIL, KEY_RESUME, KEY_LEVEL, KEY_SET, KEY_THREADS };

static const struct argp_option arguments[] = {
    {"batch", KEY_BATCH, "CASE", 0, "Run CASE to its end without a daemon, print what came of it, and exit", 1},
    {"out", KEY_OUT, "DIR", 0, "Run directory of --batch (./CASE.run)", 1},
    {"until", KEY_UNTIL, "T", 0, "Stop --batch with a checkpoint at the first step at or after T seconds", 1},
    {"output", 'o', "json", 0, "Print one JSON object at the end of --batch", 1},
    {"set", KEY_SET, "PATH=VALUE", 0, "Change an entry of the case; may be given often", 2},
    {"resume", KEY_RESUME, "auto", 0, "Go on from the newest whole checkpoint in the run directory, if there is one",
     2},
    {"threads", KEY_THREADS, "N", 0, "Threads of the solver, 0 for all processors (as the case says)", 2},
    {"log-level", KEY_LEVEL, "LEVEL", 0, "error, warning, notice, info or debug", 3},
    {0}};

typedef struct Options {
    BatchOptions batch;
    int level; /* -1: not given */
} Options;

static void add_setting(BatchOptions *batch, char *setting, struct argp_state *state)
{
    char **settings = reallocarray(batch->settings, batch->n_settings + 1, sizeof *settings);
    if (!settings) argp_failure(state, MNS_EXIT_FAILED, 0, "no memory");
    batch->settings = settings;
    batch->settings[batch->n_settings++] = setting;
}

/* A number of threads is an entry of the case like any other. */
static void add_threads(BatchOptions *batch, const char *number, struct argp_state *state)
{
    char *setting = malloc(strlen(number) + sizeof "threads=");
    if (!setting) argp_failure(state, MNS_EXIT_FAILED, 0, "no memory");
    else add_setting(batch, strcat(strcpy(setting, "threads="), number), state);
}

static double time_of(const char *text, struct argp_state *state)
{
    char *end;
    const double t = strtod(text, &end);
    if (end == text || *end || !(t >= 0) || isinf(t))
        argp_error(state, "--until takes a time in seconds, 0 or more; found \"%s\"", text);
    return t;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    Options *options = state->input;
    switch (key) {
    case KEY_BATCH: options->batch.name = text; break;
    case KEY_OUT: options->batch.directory = text; break;
    case KEY_UNTIL: options->batch.until = time_of(text, state); break;
    case KEY_SET: add_setting(&options->batch, text, state); break;
    case KEY_THREADS: add_threads(&options->batch, text, state); break;
    case 'o':
        if (strcmp(text, "json")) argp_error(state, "--output takes json; found \"%s\"", text);
        options->batch.json = true;
        break;
    case KEY_RESUME:
        if (strcmp(text, "auto")) argp_error(state, "--resume takes auto; found \"%s\"", text);
        options->batch.resume = true;
        break;
    case KEY_LEVEL:
        options->level = log_level_find(text);
        if (options->level < 0) argp_error(state, "there is no log level \"%s\"", text);
        break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

int main(int argc, char **argv)
{
    static const struct argp parser = {.options = arguments, .parser = parse, .doc = "Run fluid simulations."};
    Options options = {.batch.until = NAN, .level = -1};
    argp_err_exit_status = MNS_EXIT_USAGE;
    argp_parse(&parser, argc, argv, 0, NULL, &options);
    log_set_level(options.level >= 0 ? (LogLevel)options.level : LOG_WARNING);
    return batch_run(&options.batch);
}
