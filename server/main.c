/* SPDX-License-Identifier: BSD-3-Clause */
/* The command line of meniscusd: what to do, and nothing of how. */
#include "base/log.h"
#include "batch/batch.h"
#include "batch/check.h"
#include "batch/history_print.h"
#include "batch/machine.h"
#include "batch/replay.h"
#include "batch/schemes.h"
#include "common/host/open_files.h"
#include "common/host/process.h"
#include "net/daemon.h"
#include "net/gate.h"
#include "net/gate_keeper.h"
#include "run/environment.h"
#include "run/quota.h"
#include <argp.h>
#include <errno.h>
#include <math.h>
#include <meniscus/exit.h>
#include <meniscus/sim.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *argp_program_version = "meniscusd " MENISCUS_VERSION;

enum {
    KEY_BATCH = 256,
    KEY_OUT,
    KEY_UNTIL,
    KEY_OVERWRITE,
    KEY_CHECK,
    KEY_RESUME,
    KEY_LEVEL,
    KEY_SET,
    KEY_THREADS,
    KEY_STATE,
    KEY_TCP,
    KEY_LISTEN,
    KEY_KEYS,
    KEY_HTTP,
    KEY_TOKEN,
    KEY_PLAIN,
    KEY_LIVENESS,
    KEY_STREAMS,
    KEY_QUOTA,
    KEY_LOAD,
    KEY_START,
    KEY_SCHEMES,
    KEY_MACHINE,
    KEY_LOG,
    KEY_REPLAY,
    KEY_VERIFY
};

static const struct argp_option arguments[] = {
    {"name", 'n', "NAME", 0, "Name by which clients find the daemon (default)", 1},
    {"state-dir", KEY_STATE, "DIR", 0, "Where runs keep their files (~/.local/state/meniscus/NAME)", 1},
    {"tcp", KEY_TCP, "PORT", 0, "Listen on 127.0.0.1 too: commands at PORT, telemetry and data after it", 1},
    {"listen", KEY_LISTEN, "tcp://ADDRESS:PORT", 0,
     "Listen at any address as --tcp does at this machine's, for those who have a key: see `meniscus help keys`", 1},
    {"keys", KEY_KEYS, "DIR", 0, "Where the keys of --listen are ($MENISCUS_KEYS, or ~/.config/meniscus/keys)", 1},
    {"http", KEY_HTTP, "[ADDRESS:]PORT", 0,
     "Serve /metrics for Prometheus, /healthz and /readyz at this port of 127.0.0.1 or of another address", 1},
    {"http-token", KEY_TOKEN, "FILE", 0,
     "File with the word that requests of --http need; without it, this machine alone is served", 1},
    {"http-plain", KEY_PLAIN, 0, 0,
     "Let --http serve other machines: on the way there, all can be read, the word of --http-token too", 1},
    {"http-liveness", KEY_LIVENESS, 0, 0,
     "Answer /healthz of --http to other machines without the word of --http-token; to this one it always is", 1},
    {"stream-memory", KEY_STREAMS, "MIB", 0, "Memory that streams of data may hold, in MiB (256)", 1},
    {"quota", KEY_QUOTA, "NAME=VIEWER[,OPERATOR]", 0,
     "How much one key may hold of what clients share, as in streams=64,128; may be given often", 1},
    {"load", KEY_LOAD, "CASE", 0,
     "Load a case at the start: a file, or the name of one that came along; after a crash or a signal the same command "
     "line goes "
     "on with the run it had",
     1},
    {"start", KEY_START, 0, 0, "Set the case of --load in motion", 1},
    {"batch", KEY_BATCH, "CASE", 0, "Run CASE to its end without a daemon, print what came of it, and exit", 2},
    {"out", KEY_OUT, "DIR", 0, "Run directory of --batch (./CASE.run)", 2},
    {"overwrite", KEY_OVERWRITE, 0, 0,
     "Delete the files of the run that is in the directory of --batch, instead of keeping them", 2},
    {"check", KEY_CHECK, "CASE", 0, "Read and lay out CASE, print what it takes and what is doubtful, and exit", 2},
    {"until", KEY_UNTIL, "T", 0, "Stop --batch with a checkpoint at the first step at or after T seconds", 2},
    {"schemes", KEY_SCHEMES, 0, 0, "Print the schemes and their equations, and exit", 2},
    {"machine", KEY_MACHINE, 0, 0, "Print the instructions this machine would compute with, and exit", 2},
    {"log", KEY_LOG, "DIR", 0, "Print the journal of a run directory, and exit; with --verify only whether it is whole",
     2},
    {"replay", KEY_REPLAY, "DIR", 0,
     "Do the run of a directory again, from its journal, compare the states with --verify, and exit", 2},
    {"verify", KEY_VERIFY, 0, 0, "See --log and --replay", 2},
    {"output", 'o', "json", 0,
     "Print one JSON object at the end of --batch, or for --schemes, --machine, --log, --replay", 2},
    {"set", KEY_SET, "PATH=VALUE", 0, "Change an entry of the case; may be given often", 3},
    {"resume", KEY_RESUME, "auto", 0, "Go on from the newest whole checkpoint in the run directory, if there is one",
     3},
    {"threads", KEY_THREADS, "N", 0,
     "Threads of the solver, 0 for all processors it may use; without a case, of those loaded later that do not say "
     "(as the case "
     "says)",
     3},
    {"log-level", KEY_LEVEL, "LEVEL", 0, "error, warning, notice, info or debug", 3},
    {0}};

typedef struct Options {
    BatchOptions batch;
    DaemonOptions daemon;
    bool schemes, machine, verify;
    const char *log, *replay; /* run directories */
    const char *check;        /* a case */
    size_t n_settings;
    char **settings;
    char threads[32];
    bool resume;
    int level; /* -1: not given */
} Options;

static void add_setting(Options *options, char *setting, struct argp_state *state)
{
    char **settings = reallocarray(options->settings, options->n_settings + 1, sizeof *settings);
    if (!settings) argp_failure(state, MNS_EXIT_FAILED, 0, "no memory");
    options->settings = settings;
    options->settings[options->n_settings++] = setting;
}

/* An entry of the case like any other, and the default of those that a daemon is given later. */
static void set_threads(Options *options, const char *text, struct argp_state *state)
{
    enum { MOST = 1024 }; /* as the schema of the case says */
    char *end;
    const long n = strtol(text, &end, 10);
    if (*text < '0' || *text > '9' || *end || n > MOST)
        argp_error(state, "--threads takes a number from 0 to %d; found \"%s\"", MOST, text);
    options->daemon.threads = (int)n;
}

/* Half of it are copies of fields, made between two steps. */
static size_t memory_of(const char *text, struct argp_state *state)
{
    enum { LEAST = 16, MOST = 1 << 20 };
    char *end;
    const long n = strtol(text, &end, 10);
    if (*text < '0' || *text > '9' || *end || n < LEAST || n > MOST)
        argp_error(state, "--stream-memory takes a number of MiB from %d to %d; found \"%s\"", LEAST, MOST, text);
    return (size_t)n << 20;
}

/* Here, and in the process that those with a key go through. */
static void set_quota(const char *text, struct argp_state *state)
{
    MnsError error;
    char all[1024];
    const char *before = getenv(GATE_QUOTAS);
    if (quota_set(text, &error)) argp_error(state, "--quota: %s", error.text);
    const int size = snprintf(all, sizeof all, "%s%s ", before ? before : "", text);
    if (size < 0 || size >= (int)sizeof all || setenv(GATE_QUOTAS, all, 1))
        argp_error(state, "--quota: there are too many");
}

static void add_threads(Options *options, struct argp_state *state)
{
    if (options->daemon.threads < 0 || !(options->daemon.load || options->batch.name || options->check)) return;
    snprintf(options->threads, sizeof options->threads, "threads=%d", options->daemon.threads);
    add_setting(options, options->threads, state);
}

static double time_of(const char *text, struct argp_state *state)
{
    char *end;
    const double t = strtod(text, &end);
    if (end == text || *end || !(t >= 0) || isinf(t))
        argp_error(state, "--until takes a time in seconds, 0 or more; found \"%s\"", text);
    return t;
}

/* One word is allowed here. */
static bool only(const char *text, const char *word, const char *option, struct argp_state *state)
{
    if (strcmp(text, word)) argp_error(state, "%s takes %s; found \"%s\"", option, word, text);
    return true;
}

static void set_level(Options *options, const char *text, struct argp_state *state)
{
    options->level = log_level_find(text);
    if (options->level < 0) argp_error(state, "there is no log level \"%s\"", text);
}

/* What belongs to one mode makes no sense in the other. */
static void check(const Options *options, struct argp_state *state)
{
    const BatchOptions *batch = &options->batch;
    const DaemonOptions *daemon = &options->daemon;
    const bool prints = options->schemes || options->machine || options->log || options->replay || options->check;
    if (!batch->name && (batch->directory || (batch->json && !prints) || !isnan(batch->until) || batch->overwrite))
        argp_error(state, "--out, --overwrite, --until and --output go with --batch");
    if (batch->overwrite && options->resume)
        argp_error(state, "--overwrite begins anew, and --resume goes on: give one of them");
    if (options->check && (batch->name || daemon->load || options->resume))
        argp_error(state, "--check runs nothing: leave out --batch, --load and --resume");
    if (options->log && options->replay) argp_error(state, "--log and --replay are two things; ask for one");
    if (options->verify && !options->log && !options->replay) argp_error(state, "--verify goes with --log or --replay");
    if (options->replay && !options->verify)
        argp_error(state, "--replay goes with --verify: it compares, and writes nothing");
    if (batch->name && (daemon->load || daemon->start || daemon->at.tcp || daemon->at.listen || daemon->http.address ||
                        daemon->state_dir))
        argp_error(state,
                   "--batch starts no daemon: leave out --load, --start, --tcp, --listen, --http and --state-dir");
    if (daemon->at.keys && !daemon->at.listen)
        argp_error(state, "--keys says where the keys of --listen are: give both");
    if (daemon->http.token_file && !daemon->http.address)
        argp_error(state, "--http-token is asked for by --http: give both");
    if (daemon->http.plain && !daemon->http.address) argp_error(state, "--http-plain is for --http: give both");
    if (daemon->http.liveness && !daemon->http.token_file)
        argp_error(state, "--http-liveness is for --http with --http-token: give all three");
    if (!batch->name && !daemon->load && ((options->n_settings && !options->check) || options->resume || daemon->start))
        argp_error(state, "--set, --resume and --start need a case: --load or --batch");
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    Options *options = state->input;
    switch (key) {
    case 'n': options->daemon.at.name = text; break;
    case KEY_STATE: options->daemon.state_dir = text; break;
    case KEY_TCP: options->daemon.at.tcp = text; break;
    case KEY_LISTEN: options->daemon.at.listen = text; break;
    case KEY_KEYS: options->daemon.at.keys = text; break;
    case KEY_HTTP: options->daemon.http.address = text; break;
    case KEY_STREAMS: options->daemon.stream_memory = memory_of(text, state); break;
    case KEY_QUOTA: set_quota(text, state); break;
    case KEY_TOKEN: options->daemon.http.token_file = text; break;
    case KEY_LIVENESS: options->daemon.http.liveness = true; break;
    case KEY_PLAIN: options->daemon.http.plain = true; break;
    case KEY_LOAD: options->daemon.load = text; break;
    case KEY_START: options->daemon.start = true; break;
    case KEY_BATCH: options->batch.name = text; break;
    case KEY_OUT:
        if (!*text) argp_error(state, "--out must name a directory");
        options->batch.directory = text;
        break;
    case KEY_OVERWRITE: options->batch.overwrite = true; break;
    case KEY_CHECK: options->check = text; break;
    case KEY_UNTIL: options->batch.until = time_of(text, state); break;
    case KEY_SET: add_setting(options, text, state); break;
    case KEY_THREADS: set_threads(options, text, state); break;
    case 'o': options->batch.json = only(text, "json", "--output", state); break;
    case KEY_RESUME: options->resume = only(text, "auto", "--resume", state); break;
    case KEY_LOG: options->log = text; break;
    case KEY_REPLAY: options->replay = text; break;
    case KEY_VERIFY: options->verify = true; break;
    case KEY_SCHEMES: options->schemes = true; break;
    case KEY_MACHINE: options->machine = true; break;
    case KEY_LEVEL: set_level(options, text, state); break;
    case ARGP_KEY_ARG: argp_error(state, "there is no place for \"%s\"; a case follows --load or --batch", text); break;
    case ARGP_KEY_END:
        check(options, state);
        add_threads(options, state);
        break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

/* argp ends the process where the command line is wrong; scripts are told all the same. */
typedef struct Words {
    int argc;
    char **argv;
    bool understood;
    MnsError lacking; /* what the program needs and has not; no text: the command line is wrong */
} Words;

static void tell_scripts(int code, void *of)
{
    const Words *words = of;
    if (!words->understood && code) batch_misused(code, words->argc, words->argv, &words->lacking);
}

static int run(Options *options)
{
    if (options->schemes) return schemes_print(options->batch.json);
    if (options->machine) return machine_print(options->batch.json);
    if (options->log) return history_print(options->log, options->verify, options->batch.json);
    if (options->replay) return replay_run(options->replay, options->daemon.threads, options->batch.json);
    const int usual = options->batch.name ? LOG_WARNING : LOG_INFORMATION;
    log_set_level((LogLevel)(options->level >= 0 ? options->level : usual));
    if (options->check) {
        options->batch.name = options->check;
        options->batch.n_settings = options->n_settings;
        options->batch.settings = options->settings;
        return check_case(&options->batch);
    }
    options->batch.n_settings = options->daemon.n_settings = options->n_settings;
    options->batch.settings = options->daemon.settings = options->settings;
    options->batch.resume = options->daemon.resume = options->resume;
    return options->batch.name ? batch_run(&options->batch) : daemon_run(&options->daemon);
}

static bool computes(const Options *options)
{
    return !options->schemes && !options->machine && !options->log;
}

static int open_files(const Options *options)
{
    const EndpointOptions *at = &options->daemon.at;
    if (options->batch.name || options->check || options->replay) return OPEN_FILES_PROGRAM;
    return at->tcp || at->listen || options->daemon.http.address ? OPEN_FILES_DAEMON_FAR : OPEN_FILES_DAEMON;
}

/* Whether there is what the program needs. An exit code. */
static int take_environment(const Options *options, MnsError *error)
{
    int code = environment_level(error) ? MNS_EXIT_USAGE : MNS_EXIT_DONE;
    if (!code && computes(options) && open_files_need(open_files(options), error)) code = MNS_EXIT_IO;
    if (!code && computes(options) && environment_stacks(error)) code = MNS_EXIT_USAGE;
    if (code) fprintf(stderr, "%s: %s\n", log_program(), error->text);
    return code;
}

static int begin(int argc, char **argv)
{
    static const struct argp parser = {
        .options = arguments,
        .parser = parse,
        .doc = "Run particle simulations of fluids, and let people steer them while they run.\v"
               "Exit codes: 0 done, 1 refused or failed, 2 usage, 65 bad case, 70 diverged or a formula failed on the "
               "way, 74 input/output error, 75 stopped by a signal, after a checkpoint if it had begun, or another "
               "run has the directory (run the same command again with --resume auto), or another daemon the state "
               "directory."};
    if (gate_keeper_is(argc, argv)) return gate_keeper_run(argv);
    Options options = {.batch.until = NAN,
                       .level = -1,
                       .daemon.at.name = "default",
                       .daemon.threads = -1,
                       .daemon.stream_memory = (size_t)256 << 20};
    if (!strcmp(program_invocation_short_name, "meniscus")) log_set_program("meniscus"); /* it has become us */
    environment_waiting(argv);
    mns_multigrid_environment();
    argp_err_exit_status = MNS_EXIT_USAGE;
    static Words words; /* outlives main() */
    words = (Words){.argc = argc, .argv = argv};
    on_exit(tell_scripts, &words);
    unsetenv(GATE_QUOTAS);
    argp_parse(&parser, argc, argv, 0, NULL, &options);
    const int lacking = take_environment(&options, &words.lacking);
    if (lacking) exit(lacking);
    words.understood = true;
    const int code = run(&options);
    free(options.settings);
    return code;
}

int main(int argc, char **argv)
{
    process_main(argc, argv, begin);
}
