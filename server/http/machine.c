/* SPDX-License-Identifier: BSD-3-Clause */
/* What the operating system says. */
#include "http/machine.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

static void look_at_memory(ProcessFigures *ret)
{
    unsigned long all, resident;
    FILE *file = fopen("/proc/self/statm", "re");
    if (!file) return;
    const double page = (double)sysconf(_SC_PAGESIZE);
    if (fscanf(file, "%lu %lu", &all, &resident) == 2) {
        ret->virtual = page * (double)all;
        ret->resident = page * (double)resident;
    }
    fclose(file);
}

static double count_fds(void)
{
    DIR *directory = opendir("/proc/self/fd");
    double n = -3; /* itself, and the two entries for directories */
    if (!directory) return NAN;
    while (readdir(directory)) n++;
    closedir(directory);
    return n;
}

void process_look(ProcessFigures *ret)
{
    struct timespec cpu;
    struct rlimit limit;
    *ret = (ProcessFigures){NAN, NAN, NAN, count_fds(), NAN};
    if (!clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu)) ret->cpu = (double)cpu.tv_sec + 1e-9 * (double)cpu.tv_nsec;
    if (!getrlimit(RLIMIT_NOFILE, &limit))
        ret->max_fds = limit.rlim_cur == RLIM_INFINITY ? INFINITY : (double)limit.rlim_cur;
    look_at_memory(ret);
}

void disk_look(const char *directory, DiskFigures *ret)
{
    struct statvfs info;
    *ret = (DiskFigures){NAN, NAN, access(directory, W_OK | X_OK) ? errno : 0};
    if (statvfs(directory, &info)) return;
    ret->size = (double)info.f_frsize * (double)info.f_blocks;
    ret->free = (double)info.f_frsize * (double)info.f_bavail;
    const bool full = info.f_blocks > 0 && (info.f_bavail == 0 || (info.f_files > 0 && info.f_favail == 0));
    if (!ret->refused && full) ret->refused = ENOSPC;
}
