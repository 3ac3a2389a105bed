/* SPDX-License-Identifier: BSD-3-Clause */
/* Limits of the process that all programs must meet alike. */
#include "proto/process.h"
#include "proto/children.h"
#include "proto/screen.h"
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <sys/resource.h>

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

typedef struct Main {
    int (*run)(int argc, char **argv);
    int argc, code;
    char **argv;
    sigset_t signals; /* that `run` begins with blocked */
    pthread_t thread; /* the main one */
    atomic_bool done;
} Main;

static void *run_main(void *main)
{
    Main *m = main;
    pthread_sigmask(SIG_SETMASK, &m->signals, NULL);
    m->code = m->run(m->argc, m->argv);
    m->done = true;
    pthread_kill(m->thread, SIGCHLD);
    return NULL;
}

/* The main thread minds the end of children. It takes no other signal: it would meet the action of one that others block in order to read it. */
static void wait_for(Main *m, pthread_t thread)
{
    sigset_t ends;
    sigemptyset(&ends);
    sigaddset(&ends, SIGCHLD);
    for (int number; !m->done; sigwait(&ends, &number)) children_reap();
    pthread_join(thread, NULL);
}

/* Where there is no other thread to be had, the main one does the work. */
int process_main(int argc, char **argv, int (*run)(int argc, char **argv))
{
    Main m = {.run = run, .argc = argc, .argv = argv, .thread = pthread_self()};
    sigset_t all;
    pthread_t thread;
    signal(SIGXFSZ, SIG_IGN);
    signal(SIGCHLD, SIG_DFL);
    set_stacks();
    screen_guard();
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &m.signals);
    sigaddset(&m.signals, SIGCHLD);
    if (pthread_create(&thread, NULL, run_main, &m)) run_main(&m);
    else wait_for(&m, thread);
    return m.code;
}

int process_open_files(int most)
{
    enum { USUAL = 1024 };
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit)) return USUAL;
    struct rlimit wanted = {limit.rlim_max, limit.rlim_max};
    if (wanted.rlim_cur > (rlim_t)most) wanted.rlim_cur = (rlim_t)most;
    if (!setrlimit(RLIMIT_NOFILE, &wanted)) limit = wanted;
    return limit.rlim_cur < (rlim_t)most ? (int)limit.rlim_cur : most;
}
