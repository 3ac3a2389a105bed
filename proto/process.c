/* SPDX-License-Identifier: BSD-3-Clause */
/* Limits of the process that all programs must meet alike. */
#include "proto/process.h"
#include <signal.h>
#include <sys/resource.h>

void process_begin(void)
{
    signal(SIGXFSZ, SIG_IGN);
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
