/* SPDX-License-Identifier: BSD-3-Clause */
/* The whole of `meniscus`: parse, connect, run, print, and say with the exit code how it went. */
#include "client/cli/command.h"
#include "client/cli/output.h"
#include <meniscus/exit.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double quick_s = 60; /* for commands that cannot rightly take longer, unless --timeout is given */

int command_exit_code(MnsStatus status, bool is_load)
{
    switch (status) {
    case MNS_OK: return MNS_EXIT_DONE;
    case MNS_E_UNAVAILABLE: return MNS_EXIT_UNREACHABLE;
    case MNS_E_DIVERGED: return MNS_EXIT_DIVERGED;
    case MNS_E_TIMEOUT: return MNS_EXIT_TIMEOUT;
    case MNS_E_INTERRUPTED: return MNS_EXIT_AGAIN;
    case MNS_E_IO:
    case MNS_E_NO_SPACE:
    case MNS_E_CORRUPT: return MNS_EXIT_IO;
    case MNS_E_INVALID:
    case MNS_E_NOT_FOUND: return is_load ? MNS_EXIT_BAD_CASE : MNS_EXIT_FAILED;
    default: return MNS_EXIT_FAILED;
    }
}

/* The sentence on standard error; with -o json the same on standard output for programs. */
static int complain(const MnsError *error, bool json, int code)
{
    fprintf(stderr, "%s%s\n", code == MNS_EXIT_BAD_CASE ? "" : "meniscus: ", error->text);
    if (json) {
        json_t *detail = json_pack("{ss ss ss si}", "status", mns_status_name(error->status), "message", error->text,
                                   "path", error->path, "exit_code", code);
        output_json(json_pack("{so}", "error", detail), NULL);
    }
    return code;
}

static int misuse(const MnsError *error, bool json, const Command *command)
{
    const int code = complain(error, json, MNS_EXIT_USAGE);
    fprintf(stderr, "`meniscus help%s%s` explains.\n", command ? " " : "", command ? command->name : "");
    return code;
}

static MnsStatus check_format(Invocation *in, MnsError *error)
{
    const char *format = options_get(&in->options, OPT_OUTPUT);
    in->json = format && strcmp(format, "json") == 0;
    if (format && !in->json && strcmp(format, "text") != 0)
        return mns_fail(error, MNS_E_INVALID, "-o %s: the output is text or json", format);
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

/* What the global options say about requests. */
static MnsStatus read_manner(Invocation *in, MnsError *error)
{
    const char *timeout = options_get(&in->options, OPT_TIMEOUT), *id = options_get(&in->options, OPT_ID);
    in->timeout = in->command->is_long ? -1 : quick_s;
    if (timeout) {
        const MnsStatus status = parse_number("--timeout", timeout, &in->timeout, error);
        if (status != MNS_OK) return status;
        if (in->timeout < 0) return mns_fail(error, MNS_E_INVALID, "--timeout %s: seconds are not negative", timeout);
    }
    in->has_id = id;
    return id ? parse_id("--id", id, in->id, error) : MNS_OK;
}

MnsStatus command_connect(Invocation *in, MnsError *error)
{
    const MnsStatus status = mns_client_open(options_get(&in->options, OPT_DAEMON), &in->client, error);
    if (status != MNS_OK) return status;
    mns_client_set_timeout(in->client, in->timeout);
    if (in->has_id) mns_client_set_request_id(in->client, in->id);
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

static int run_parsed(Invocation *in)
{
    MnsError error = {0};
    if (options_get(&in->options, OPT_HELP)) {
        help_print(in->command);
        return MNS_EXIT_DONE;
    }
    MnsStatus status = command_usage(in, check_format(in, &error));
    if (status == MNS_OK) status = command_usage(in, check_words(in, &error));
    if (status == MNS_OK) status = command_usage(in, read_manner(in, &error));
    if (status == MNS_OK) status = in->command->run(in, &error);
    mns_client_close(in->client);
    if (status == MNS_OK) return in->code;
    if (in->code == MNS_EXIT_USAGE) return misuse(&error, in->json, in->command);
    return complain(&error, in->json,
                    in->code ? in->code : command_exit_code(status, in->command->run == command_load));
}

/* Commands that parse their options themselves get the global ones that came before the command too. */
static int run_raw(const Command *command, const Options *global, int argc, char **argv)
{
    char **all = calloc((size_t)argc + 2 * global->n_given + 1, sizeof *all);
    char(*names)[24] = calloc(global->n_given + 1, sizeof *names);
    int n = 0, code = MNS_EXIT_FAILED;
    if (all && names) {
        all[n++] = argv[0];
        for (size_t k = 0; k < global->n_given; k++) {
            const OptionInfo *info = &option_table[global->given[k].id];
            snprintf(names[k], sizeof names[k], info->letter ? "-%.1s" : "--%s",
                     info->letter ? &info->letter : info->name);
            all[n++] = names[k];
            if (info->value) all[n++] = (char *)global->given[k].value;
        }
        for (int k = 1; k < argc; k++) all[n++] = argv[k];
        code = command->raw(n, all);
    }
    free(names);
    free(all);
    return code;
}

int command_main(int argc, char **argv)
{
    Invocation in = {0};
    MnsError error = {0};
    int used = 1;
    if (options_parse(&in.options, argc, argv, OPTIONS_GLOBAL, true, &used, &error) != MNS_OK)
        return misuse(&error, false, NULL);
    if (options_get(&in.options, OPT_VERSION)) return printf("meniscus %s\n", MENISCUS_VERSION) < 0;
    if (used == argc) {
        help_print(NULL);
        return options_get(&in.options, OPT_HELP) ? MNS_EXIT_DONE : MNS_EXIT_USAGE;
    }
    check_format(&in, &error);
    if (command_find(argv[used], &in.command, &error) != MNS_OK) return misuse(&error, in.json, NULL);
    if (in.command->raw) return run_raw(in.command, &in.options, argc - used, argv + used);
    int rest;
    const unsigned allowed = OPTIONS_GLOBAL | in.command->options;
    if (options_parse(&in.options, argc - used, argv + used, allowed, false, &rest, &error) != MNS_OK)
        return misuse(&error, in.json, in.command);
    return run_parsed(&in);
}
