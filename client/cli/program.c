/* SPDX-License-Identifier: BSD-3-Clause */
/* Other programs of the project, and `meniscus run`, which is one of them. */
#include "client/cli/program.h"
#include "client/cli/beside.h"
#include "client/cli/command.h"
#include "common/host/children.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

MnsStatus program_become(const char *program, const char *const *arguments, MnsError *error)
{
    size_t n = 0;
    while (arguments[n]) n++;
    const char **argv = calloc(n + 2, sizeof *argv);
    if (!argv) return mns_fail(error, MNS_E_MEMORY, "no memory to run %s", program);
    argv[0] = "meniscus"; /* whoever typed that is to be answered in that name */
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

/* Until it ends; what does not fit is read and forgotten, so that it can end. */
static void read_all(int fd, char *ret, size_t size)
{
    char rest[256];
    size_t n = 0;
    ssize_t got;
    while ((got = n + 1 < size ? read(fd, ret + n, size - 1 - n) : read(fd, rest, sizeof rest)) > 0)
        if (n + 1 < size) n += (size_t)got;
    ret[n] = 0;
}

MnsStatus program_ask(const char *program, const char *const *arguments, char *ret, size_t size, MnsError *error)
{
    enum { MOST = 8 };
    const char *argv[MOST + 2] = {program};
    char path[PATH_MAX];
    int ends[2];
    Child child;
    posix_spawn_file_actions_t actions;
    for (size_t k = 0; arguments[k]; k++) {
        if (k == MOST) return mns_fail(error, MNS_E_LIMIT, "too many words for %s", program);
        argv[k + 1] = arguments[k];
    }
    if (pipe2(ends, O_CLOEXEC)) return mns_fail(error, MNS_E_IO, "cannot ask %s: %s", program, strerror(errno));
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    const bool beside = beside_find(program, path);
    const int failed = children_start(&child, beside ? path : program, &actions, (char **)argv);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (!failed) read_all(ends[0], ret, size);
    close(ends[0]);
    if (failed)
        return mns_fail(error, MNS_E_NOT_FOUND, "cannot run %s: %s; it belongs beside this program or in $PATH",
                        program, strerror(failed));
    const int state = children_wait(&child);
    if (WIFEXITED(state) && WEXITSTATUS(state) == 0) return MNS_OK;
    return mns_fail(error, MNS_E_IO, "%s ended with exit code %d", program,
                    WIFEXITED(state) ? WEXITSTATUS(state) : 128);
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
    if (resume && options_get(o, OPT_OVERWRITE))
        return mns_fail(error, MNS_E_INVALID, "--overwrite begins anew, and --resume goes on: give one of them");
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

/* meniscusd in one of its modes that takes a case, with the options that were given here. */
static MnsStatus become_with(const Invocation *in, const char *mode, MnsError *error)
{
    const Options *o = &in->options;
    MnsStatus status;
    const size_t size = 2 * o->n_given + 3;
    const char **arguments = calloc(size, sizeof *arguments);
    char(*names)[24] = calloc(o->n_given + 1, sizeof *names);
    size_t n = 0;
    if (arguments && names) {
        arguments[n++] = mode;
        arguments[n++] = o->words[0];
        for (size_t k = 0; k < o->n_given; k++) {
            const OptionInfo *info = &option_table[o->given[k].id];
            if (o->given[k].id == OPT_OUTPUT && !in->json) continue; /* text is what meniscusd prints anyhow */
            snprintf(names[k], sizeof names[k], "--%s", info->name);
            arguments[n++] = names[k];
            if (info->value) arguments[n++] = o->given[k].value;
        }
        status = program_become("meniscusd", arguments, error);
    } else {
        status = mns_fail(error, MNS_E_MEMORY, "no memory to run meniscusd");
    }
    free(names);
    free(arguments);
    return status;
}

MnsStatus command_run(Invocation *in, MnsError *error)
{
    const MnsStatus status = command_usage(in, check_run(&in->options, error));
    return status ? status : become_with(in, "--batch", error);
}

MnsStatus command_check(Invocation *in, MnsError *error)
{
    const MnsStatus status = command_usage(in, check_run(&in->options, error));
    return status ? status : become_with(in, "--check", error);
}
