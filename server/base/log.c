/* SPDX-License-Identifier: BSD-3-Clause */
/* One line per event on standard error; with the priority in front where the journal reads it. */
#include "base/log.h"

#include <poll.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static _Atomic int log_highest = LOG_INFORMATION;
static bool to_journal;
static const char *program = "meniscusd";

/* Before there are threads: a library that one of them starts may change the environment while another looks at it. */
__attribute__((constructor)) static void look_at_environment(void)
{
    to_journal = getenv("JOURNAL_STREAM") != NULL;
}

void log_set_program(const char *name)
{
    program = name;
}

const char *log_program(void)
{
    return program;
}

void log_set_level(LogLevel level)
{
    log_highest = (int)level;
}

int log_level_find(const char *word)
{
    static const char *const words[] = {[LOG_ERROR] = "error",
                                        [LOG_WARNING] = "warning",
                                        [LOG_NOTICE] = "notice",
                                        [LOG_INFORMATION] = "info",
                                        [LOG_DETAIL] = "debug"};
    for (int level = LOG_ERROR; level <= LOG_DETAIL; level++)
        if (!strcmp(word, words[level])) return level;
    return -1;
}

LogLevel log_level(void)
{
    return (LogLevel)log_highest;
}

/* A pipe or a socket that nobody reads must not make a thread wait, least of all the solver's. What is ready takes a whole line. */
static bool takes_a_line(void)
{
    struct pollfd out = {.fd = STDERR_FILENO, .events = POLLOUT};
    return poll(&out, 1, 0) != 0;
}

static void write_line(LogLevel level, const char *line)
{
    if (to_journal) fprintf(stderr, "<%d>%s\n", (int)level, line);
    else fprintf(stderr, "%s: %s\n", program, line);
}

static void write_if_read(LogLevel level, const char *line)
{
    static unsigned lost; /* lines, since one was written */
    char text[80];
    if (!takes_a_line()) {
        lost++;
        return;
    }
    if (lost) {
        snprintf(text, sizeof text, "%u lines were lost, as nobody read them", lost);
        write_line(LOG_WARNING, text);
    }
    lost = 0;
    write_line(level, line);
}

void log_line(LogLevel level, const char *format, ...)
{
    if ((int)level > log_highest) return;
    char line[1024];
    va_list list;
    va_start(list, format);
    vsnprintf(line, sizeof line, format, list);
    va_end(list);
    for (char *c = line; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 127) *c = ' ';
    flockfile(stderr);
    write_if_read(level, line);
    funlockfile(stderr);
}
