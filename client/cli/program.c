/* SPDX-License-Identifier: BSD-3-Clause */
/* Other programs of the project, and `meniscus run`, which is one of them. */
#include "client/cli/program.h"
#include "client/cli/command.h"
#include <errno.h>
#include <limits.h>
#include <meniscus/exit.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* PATH of a program in the directory of this one. @return false if there is none that may be run. */
static bool beside(const char *program, char ret[PATH_MAX])
{
    char self[PATH_MAX];
    const ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    if (n <= 0) return false;
    self[n] = 0;
    char *slash = strrchr(self, '/');
    if (!slash) return false;
    *slash = 0;
    return snprintf(ret, PATH_MAX, "%s/%s", self, program) < PATH_MAX && access(ret, X_OK) == 0;
}

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
    if (beside(program, path)) execv(path, (char **)argv);
    else execvp(program, (char **)argv);
    const int cause = errno;
    free(argv);
    return mns_fail(error, MNS_E_NOT_FOUND, "cannot run %s: %s; it belongs beside this program or in $PATH", program,
                    strerror(cause));
}

int command_run(int argc, char **argv)
{
    MnsError error;
    const bool wants_help = argc > 1 && (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0);
    if (wants_help || argc < 2) {
        fputs("Usage: meniscus run CASE [--set PATH=VALUE]... [--out DIR] [--until T] [--resume auto] [--threads N]\n"
              "                    [-o text|json]\n"
              "Run a case to its end without a daemon: the same solver, the same files.\n",
              wants_help ? stdout : stderr);
        return wants_help ? MNS_EXIT_DONE : MNS_EXIT_USAGE;
    }
    const char **arguments = calloc((size_t)argc + 1, sizeof *arguments);
    if (!arguments) return MNS_EXIT_FAILED;
    arguments[0] = "--batch";
    for (int k = 1; k < argc; k++) arguments[k] = argv[k];
    program_become("meniscusd", arguments, &error);
    free(arguments);
    fprintf(stderr, "meniscus: %s\n", error.text);
    return MNS_EXIT_FAILED;
}
