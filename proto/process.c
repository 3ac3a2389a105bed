/* SPDX-License-Identifier: BSD-3-Clause */
/* Limits of the process that all programs must meet alike. */
#include "proto/process.h"
#include <pthread.h>
#include <signal.h>
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

void process_begin(void)
{
    signal(SIGXFSZ, SIG_IGN);
    set_stacks();
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
