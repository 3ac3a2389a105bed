/* SPDX-License-Identifier: BSD-3-Clause */
/* One run from the command line, without a daemon: the same solver, the same outputs, no socket. */
#ifndef BATCH_BATCH_H
#define BATCH_BATCH_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct BatchOptions {
    const char *name; /* of the case, or the path of its file               */
    size_t n_settings;
    char **settings;       /* [n_settings] "resolution=40"                       */
    const char *directory; /* of the run; NULL: ./NAME.run                       */
    double until;          /* stop with a checkpoint at or after this time [s]; NAN: run to the end */
    bool resume;           /* from the newest whole checkpoint in the directory, if there is one    */
    bool overwrite;        /* delete the files of the run that was in the directory                 */
    bool json;
} BatchOptions;

/* Run it and print what came of it on standard output. Returns an exit code of <meniscus/exit.h>. Must be called before any
 * thread is started, as it decides who gets the signals. */
int batch_run(const BatchOptions *options);

/* The process ends with this code before batch_run(), as the command line is wrong, or for the error if that has a text: if argv asks for JSON,
 * print the one object that is promised. */
void batch_misused(int code, int argc, char *const *argv, const MnsError *error);

#endif
