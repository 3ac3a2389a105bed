/* SPDX-License-Identifier: BSD-3-Clause */
/* How many processors this process may use. */
#include "common/host/processors.h"
#include "common/host/control_groups.h"
#include <math.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

/* A quota and the period it is for, in microseconds: one line of version 2, two files of version 1. */
static double quota_in(const char *directory, bool old)
{
    enum { PATH = 4096 };
    char path[PATH + 64], line[128] = "", *end = NULL;
    uint64_t period = 0;
    snprintf(path, sizeof path, "%s/%s", directory, old ? "cpu.cfs_quota_us" : "cpu.max");
    FILE *file = fopen(path, "re");
    if (!file) return INFINITY;
    const double quota = fgets(line, sizeof line, file) ? strtod(line, &end) : 0;
    fclose(file);
    if (end == line || !(quota > 0)) return INFINITY; /* "max", -1 */
    if (!old) period = strtoull(end, NULL, 10);
    snprintf(path, sizeof path, "%s/cpu.cfs_period_us", directory);
    if (old && !groups_number(path, "", &period)) return INFINITY;
    return period ? quota / (double)period : INFINITY;
}

static void look(void *arg, const char *directory, bool old)
{
    double *least = arg;
    *least = fmin(*least, quota_in(directory, old));
}

Processors processors_look(const char *root)
{
    const int there = (int)sysconf(_SC_NPROCESSORS_ONLN);
    cpu_set_t set;
    Processors all = {.there = there, .bound = there, .quota = INFINITY};
    if (!sched_getaffinity(0, sizeof set, &set)) all.bound = CPU_COUNT(&set);
    groups_each(root, "cpu", look, &all.quota);
    all.threads = (int)fmin(all.bound, ceil(all.quota));
    return all;
}
