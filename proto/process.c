/* SPDX-License-Identifier: BSD-3-Clause */
/* Limits of the process that all programs must meet alike. */
#include "proto/process.h"
#include <limits.h>
#include <signal.h>
#include <sys/resource.h>

void process_begin(void)
{
    signal(SIGXFSZ, SIG_IGN);
}

int process_open_files(void)
{
    enum { USUAL = 1024 };
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit)) return USUAL;
    const struct rlimit raised = {limit.rlim_max, limit.rlim_max};
    if (limit.rlim_cur < limit.rlim_max && !setrlimit(RLIMIT_NOFILE, &raised)) limit = raised;
    return limit.rlim_cur < INT_MAX ? (int)limit.rlim_cur : INT_MAX;
}
