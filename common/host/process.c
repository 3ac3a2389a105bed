/* SPDX-License-Identifier: BSD-3-Clause */
/* Limits of the process that all programs must meet alike. */
#include "common/host/process.h"
#include "common/host/children.h"
#include "common/host/screen.h"
#include <errno.h>
#include <fcntl.h>
#include <meniscus/exit.h>
#include <meniscus/status.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <stdnoreturn.h>
#include <string.h>
#include <unistd.h>

/* The solver takes 0.4 MiB at most; sanitizers make frames several times as long. Only what is used takes memory. */
static void set_stacks(void)
{
#ifdef MENISCUS_SANITIZED
    static const size_t size = (size_t)8 << 20;
#else
    static const size_t size = (size_t)2 << 20;
#endif
    pthread_attr_t attributes;
    if (pthread_attr_init(&attributes)) return;
    if (!pthread_attr_setstacksize(&attributes, size)) pthread_setattr_default_np(&attributes);
    pthread_attr_destroy(&attributes);
}

/* A file that is opened later must not become one of these: messages would be written to it. What is opened in place of one that is closed can neither be
 * read nor written, as if it were closed. */
static void hold_standard_files(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
        if (fcntl(fd, F_GETFD) < 0) (void)open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

typedef struct Main {
    int (*run)(int argc, char **argv);
    int argc;
    char **argv;
    sigset_t signals; /* that `run` begins with blocked */
} Main;

/* A full disk shows when the last of the output is written, which is here, whatever has ended the program: its output counts. A program that ends with
 * MNS_EXIT_IO has said what failed. */
static void check_output(int code, void *nothing)
{
    (void)nothing;
    const int failed = screen_end();
    MnsError error;
    if (!failed || code == MNS_EXIT_IO) return;
    screen_fail(failed, &error);
    fprintf(stderr, "%s: %s\n", program_invocation_short_name, error.text);
    fflush(NULL);
    _exit(code == MNS_EXIT_DONE ? MNS_EXIT_IO : code);
}

/* It ends with the process, and not before: what it has for itself is kept until then. */
static void *run_main(void *main)
{
    const Main *m = main;
    pthread_sigmask(SIG_SETMASK, &m->signals, NULL);
    exit(m->run(m->argc, m->argv));
}

/* Where there is no other thread to be had, the main one does the work. Else it minds the end of children, and takes no other signal: it would meet the
 * action of one that others block in order to read it. */
noreturn void process_main(int argc, char **argv, int (*run)(int argc, char **argv))
{
    Main m = {.run = run, .argc = argc, .argv = argv};
    sigset_t all, ends;
    pthread_t thread;
    hold_standard_files();
    signal(SIGXFSZ, SIG_IGN);
    signal(SIGCHLD, SIG_DFL);
    set_stacks();
    screen_guard();
    on_exit(check_output, NULL);
    sigfillset(&all);
    sigemptyset(&ends);
    sigaddset(&ends, SIGCHLD);
    pthread_sigmask(SIG_SETMASK, &all, &m.signals);
    sigaddset(&m.signals, SIGCHLD);
    if (pthread_create(&thread, NULL, run_main, &m)) run_main(&m);
    for (int number;; sigwait(&ends, &number)) children_reap();
}
