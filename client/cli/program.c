/* SPDX-License-Identifier: BSD-3-Clause */
/* Other programs of the project, and `meniscus run`, which is one of them. */
#include "client/cli/program.h"
#include "client/cli/beside.h"
#include "client/cli/command.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

MnsStatus program_become(const char *program, const char *const *arguments, MnsError *error)
{
    size_t n = 0;
    while (arguments[n]) n++;
    const char **argv = calloc(n + 2, sizeof *argv);
    if (!argv) return mns_fail(error, MNS_E_MEMORY, "no memory to run %s", program);
    argv[0] = program;
    memcpy(argv + 1, arguments, n * sizeof *argv);
    char path[PATH_MAX];
    fflush(NULL);
    if (beside_find(program, path)) execv(path, (char **)argv);
    else execvp(program, (char **)argv);
    const int cause = errno;
    free(argv);
    return mns_fail(error, MNS_E_NOT_FOUND, "cannot run %s: %s; it belongs beside this program or in $PATH", program,
                    strerror(cause));
}

/* Values that can be wrong without a look at the case are refused here, like those of any command. */
static MnsStatus check_run(const Options *o, MnsError *error)
{
    double until;
    uint64_t threads;
    const char *resume = options_get(o, OPT_RESUME_AUTO);
    const char *time = options_get(o, OPT_UNTIL), *number = options_get(o, OPT_THREADS);
    if (resume && strcmp(resume, "auto") != 0)
        return mns_fail(error, MNS_E_INVALID, "--resume takes auto; found \"%.100s\"", resume);
    MnsStatus status = time ? parse_number("--until", time, &until, error) : MNS_OK;
    if (status == MNS_OK && time && until < 0)
        return mns_fail(error, MNS_E_INVALID, "--until %.100s: a time is 0 or more", time);
    if (status == MNS_OK && number) status = parse_count("--threads", number, &threads, error);
    return status;
}

MnsStatus command_log(Invocation *in, MnsError *error)
{
    const bool verify = options_get(&in->options, OPT_VERIFY);
    const char *arguments[] = {"--log", in->options.words[0], NULL, NULL, NULL, NULL};
    size_t n = 2;
    if (verify) arguments[n++] = "--verify";
    if (in->json) arguments[n++] = "--output=json";
    return program_become("meniscusd", arguments, error);
}

MnsStatus command_replay(Invocation *in, MnsError *error)
{
    const Options *o = &in->options;
    const char *threads = options_get(o, OPT_THREADS);
    const char *arguments[] = {"--replay", o->words[0], "--verify", NULL, NULL, NULL, NULL};
    size_t n = 3;
    if (!options_get(o, OPT_VERIFY))
        return command_usage(in, mns_fail(error, MNS_E_INVALID,
                                          "a replay is there to compare, and writes nothing: say meniscus replay DIR "
                                          "--verify"));
    const MnsStatus status = command_usage(in, check_run(o, error));
    if (status != MNS_OK) return status;
    if (threads) {
        arguments[n++] = "--threads";
        arguments[n++] = threads;
    }
    if (in->json) arguments[n++] = "--output=json";
    return program_become("meniscusd", arguments, error);
}

MnsStatus command_run(Invocation *in, MnsError *error)
{
    const Options *o = &in->options;
    MnsStatus status = command_usage(in, check_run(o, error));
    if (status != MNS_OK) return status;
    const size_t size = 2 * o->n_given + 3;
    const char **arguments = calloc(size, sizeof *arguments);
    char(*names)[24] = calloc(o->n_given + 1, sizeof *names);
    size_t n = 0;
    if (arguments && names) {
        arguments[n++] = "--batch";
        arguments[n++] = o->words[0];
        for (size_t k = 0; k < o->n_given; k++) {
            if (o->given[k].id == OPT_OUTPUT && !in->json) continue; /* text is what meniscusd prints anyhow */
            snprintf(names[k], sizeof names[k], "--%s", option_table[o->given[k].id].name);
            arguments[n++] = names[k];
            arguments[n++] = o->given[k].value;
        }
        status = program_become("meniscusd", arguments, error);
    } else {
        status = mns_fail(error, MNS_E_MEMORY, "no memory to run meniscusd");
    }
    free(names);
    free(arguments);
    return status;
}
