/* SPDX-License-Identifier: BSD-3-Clause */
/* The whole of `meniscus`: parse, connect, run, print, and say with the exit code how it went. */
#include "client/cli/command.h"
#include "client/cli/output.h"
#include "common/host/open_files.h"
#include "common/host/script.h"
#include "common/host/text.h"
#include <meniscus/exit.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static const double quick_s = 60; /* for commands that cannot rightly take longer, unless --timeout is given */

int command_exit_code(MnsStatus status, bool is_load)
{
    switch (status) {
    case MNS_OK: return MNS_EXIT_DONE;
    case MNS_E_UNAVAILABLE: return MNS_EXIT_UNREACHABLE;
    case MNS_E_DIVERGED: return MNS_EXIT_DIVERGED;
    case MNS_E_TIMEOUT: return MNS_EXIT_TIMEOUT;
    case MNS_E_DENIED: return MNS_EXIT_DENIED;
    case MNS_E_INTERRUPTED: return MNS_EXIT_AGAIN;
    case MNS_E_IO:
    case MNS_E_NO_SPACE:
    case MNS_E_CORRUPT: return MNS_EXIT_IO;
    case MNS_E_INVALID:
    case MNS_E_NOT_FOUND: return is_load ? MNS_EXIT_BAD_CASE : MNS_EXIT_FAILED;
    default: return MNS_EXIT_FAILED;
    }
}

/* What to do next; capabilities know the names of fields and probes, but not those of files, keys or versions. */
static const char *hint_of(const MnsError *error)
{
    static const char *const known[] = {"field", "fields", "probes"};
    if (error->status != MNS_E_NOT_FOUND) return mns_status_hint(error->status);
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
        if (strcmp(error->path, known[k]) == 0) return mns_status_hint(error->status);
    return "check the name that the message has";
}

/* The sentence on standard error; with -o json the same on standard output for programs. */
/* What is wrong in a case file begins with its place; all else with who says it, and the entry unless the sentence has it. */
static int complain(const MnsError *error, bool json, int code)
{
    const bool placed = code == MNS_EXIT_BAD_CASE, named = placed || strstr(error->text, error->path);
    const char *hint = hint_of(error);
    fprintf(stderr, "%s%s%s%s\n", placed ? "" : "meniscus: ", named ? "" : text_shown(error->path), named ? "" : ": ",
            text_shown(error->text));
    /* Of what to do next, the commands, unless the sentence has them; about a state the daemon's own says more. */
    if (!placed && error->status != MNS_E_STATE && strchr(hint, '`') && !strchr(error->text, '`'))
        fprintf(stderr, "What to do: %s.\n", hint);
    if (json) output_json(output_failure(error, hint, code), NULL);
    return code;
}

static int misuse(const MnsError *error, bool json, const Command *command)
{
    char hint[64];
    const bool one = command && command->run != command_help; /* which explains all */
    snprintf(hint, sizeof hint, "`meniscus help%s%s` explains", one ? " " : "", one ? command->name : "");
    fprintf(stderr, "meniscus: %s\n%s.\n", text_shown(error->text), hint);
    if (json) output_json(output_failure(error, hint, MNS_EXIT_USAGE), NULL);
    return MNS_EXIT_USAGE;
}

/* The last one holds, but if any is wrong, whoever has asked for JSON is still told of it in JSON. */
static MnsStatus check_format(Invocation *in, MnsError *error)
{
    const char *formats[MAX_WORDS];
    const size_t n = options_all(&in->options, OPT_OUTPUT, formats);
    for (size_t k = 0; k < n; k++)
        if (strcmp(formats[k], "json") != 0 && strcmp(formats[k], "text") != 0)
            return mns_fail(error, MNS_E_INVALID, "-o %s: the output is text or json", formats[k]);
    in->json = n && strcmp(formats[n - 1], "json") == 0;
    return MNS_OK;
}

static MnsStatus check_words(const Invocation *in, MnsError *error)
{
    const Command *command = in->command;
    const size_t n = in->options.n_words;
    if (n < command->min_words) return mns_fail(error, MNS_E_INVALID, "%s needs %s", command->name, command->arguments);
    if (n > command->max_words)
        return mns_fail(error, MNS_E_INVALID, "%s has no use for \"%.200s\"", command->name,
                        in->options.words[command->max_words]);
    return MNS_OK;
}

/* Whoever waits for a moment waits as long as it takes; a time limit would call the command off. */
static MnsStatus read_moment(Invocation *in, MnsError *error)
{
    const char *step = options_get(&in->options, OPT_WAIT_STEP), *time = options_get(&in->options, OPT_WAIT_TIME);
    in->has_at_step = step;
    in->has_at_time = time;
    if (step && time) return mns_fail(error, MNS_E_INVALID, "--at-step or --at-time, not both");
    if (!step && !time && options_get(&in->options, OPT_NO_WAIT))
        return mns_fail(error, MNS_E_INVALID, "--no-wait goes with --at-step or --at-time; all else is done at once");
    if (!step && !time) return MNS_OK;
    in->timeout = -1;
    return step ? parse_count("--at-step", step, &in->at_step, error)
                : parse_number("--at-time", time, &in->at_time, error);
}

/* What the global options say about requests. */
static MnsStatus read_manner(Invocation *in, MnsError *error)
{
    const char *timeout = options_get(&in->options, OPT_TIMEOUT), *id = options_get(&in->options, OPT_ID),
               *if_step = options_get(&in->options, OPT_IF_STEP),
               *if_version = options_get(&in->options, OPT_IF_VERSION), *given = options_get(&in->options, OPT_LEASE),
               *lease = given ? given : getenv("MENISCUS_LEASE");
    in->timeout = in->command->is_long ? -1 : quick_s;
    MnsStatus status = read_moment(in, error);
    if (status) return status;
    if (timeout) {
        status = parse_number("--timeout", timeout, &in->timeout, error);
        if (status != MNS_OK) return status;
        if (in->timeout < 0) return mns_fail(error, MNS_E_INVALID, "--timeout %s: seconds are not negative", timeout);
    }
    in->has_id = id;
    in->has_if_step = if_step;
    status = id ? parse_id("--id", id, in->id, error) : MNS_OK;
    if (!status && if_step) status = parse_count("--if-step", if_step, &in->if_step, error);
    if (!status && if_version) status = parse_count("--if-version", if_version, &in->if_version, error);
    if (!status && if_version && !in->if_version)
        status = mns_fail(error, MNS_E_INVALID, "--if-version 0: the first version of a case is 1");
    if (!status && lease && *lease)
        status = parse_count(given ? "--lease" : "MENISCUS_LEASE", lease, &in->lease, error);
    return status;
}

double command_clock(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

MnsStatus command_connect(Invocation *in, MnsError *error)
{
    const MnsClientOptions options = {.daemon = options_get(&in->options, OPT_DAEMON),
                                      .key_file = options_get(&in->options, OPT_KEY),
                                      .server_key = options_get(&in->options, OPT_SERVER_KEY)};
    char endpoint[MNS_ENDPOINT_SIZE];
    MnsStatus status = mns_daemon_endpoint(options.daemon, endpoint, error);
    if (status == MNS_E_INVALID) return command_usage(in, status);
    status = mns_client_open_with(&options, &in->client, error);
    /* What is wrong then is a key, whatever the command: nobody is to look for it in a case. */
    if (status == MNS_E_NOT_FOUND || status == MNS_E_STATE) in->code = MNS_EXIT_IO;
    if (status == MNS_E_INVALID) in->code = MNS_EXIT_FAILED;
    if (status != MNS_OK) return status;
    mns_client_set_timeout(in->client, in->timeout);
    if (in->has_id) mns_client_set_request_id(in->client, in->id);
    if (in->has_if_step) mns_client_set_if_step(in->client, in->if_step);
    if (in->if_version) mns_client_set_if_version(in->client, in->if_version);
    if (in->has_at_step) mns_client_set_at_step(in->client, in->at_step);
    if (in->has_at_time) mns_client_set_at_time(in->client, in->at_time);
    if (options_get(&in->options, OPT_NO_WAIT)) mns_client_set_no_wait(in->client);
    mns_client_set_lease(in->client, in->lease);
    return MNS_OK;
}

MnsStatus command_fault(Invocation *in, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = mns_client_status(in->client, &reply, error);
    if (status != MNS_OK) return status;
    const MnsStatus cause = reply->info ? reply->info->fault_status : MNS_OK;
    status = mns_fail(error, cause == MNS_OK ? MNS_E_INTERNAL : cause, "the run stopped in FAULT: %s",
                      reply->info ? reply->info->fault : "");
    mns_reply_free(reply);
    return status;
}

MnsStatus command_usage(Invocation *in, MnsStatus status)
{
    if (status != MNS_OK) in->code = MNS_EXIT_USAGE;
    return status;
}

static int help(const Command *command, bool json)
{
    if (json) return output_json(help_json(), NULL) == MNS_OK ? MNS_EXIT_DONE : MNS_EXIT_IO;
    help_print(command);
    return MNS_EXIT_DONE;
}

/* What only prints needs none. */
static MnsStatus check_files(Invocation *in, MnsError *error)
{
    if (in->command->run == command_help || in->command->run == command_schemes) return MNS_OK;
    const MnsStatus status = open_files_need(OPEN_FILES_PROGRAM, error);
    if (status) in->code = MNS_EXIT_IO;
    return status;
}

static int run_parsed(Invocation *in)
{
    MnsError error = {0};
    MnsStatus status = command_usage(in, check_format(in, &error));
    if (status == MNS_OK && options_get(&in->options, OPT_HELP)) return help(in->command, in->json);
    if (status == MNS_OK) status = command_usage(in, check_words(in, &error));
    if (status == MNS_OK) status = command_usage(in, read_manner(in, &error));
    if (status == MNS_OK) status = check_files(in, &error);
    if (status == MNS_OK) status = in->command->run(in, &error);
    mns_client_close(in->client);
    if (status == MNS_OK) return in->code;
    if (in->code == MNS_EXIT_USAGE) return misuse(&error, in->json, in->command);
    return complain(&error, in->json,
                    in->code ? in->code : command_exit_code(status, in->command->run == command_load));
}

int command_main(int argc, char **argv)
{
    Invocation in = {.json = script_wants_json(argc, argv)};
    MnsError error = {0};
    int used = 1, rest;
    if (options_parse(&in.options, argc, argv, OPTIONS_GLOBAL, true, &used, &error) != MNS_OK)
        return misuse(&error, in.json, NULL);
    if (options_get(&in.options, OPT_VERSION)) {
        printf("meniscus %s\n", MENISCUS_VERSION);
        return MNS_EXIT_DONE;
    }
    if (used == argc && options_get(&in.options, OPT_HELP)) return help(NULL, in.json);
    if (used == argc) {
        mns_fail(&error, MNS_E_INVALID, "say what to do: a command is missing");
        return misuse(&error, in.json, NULL);
    }
    if (command_find(argv[used], &in.command, &error) != MNS_OK) return misuse(&error, in.json, NULL);
    const OptionSet allowed = command_options(in.command);
    if (options_parse(&in.options, argc - used, argv + used, allowed, false, &rest, &error) != MNS_OK)
        return misuse(&error, in.json, in.command);
    return run_parsed(&in);
}
