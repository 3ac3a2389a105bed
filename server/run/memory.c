/* SPDX-License-Identifier: BSD-3-Clause */
/* How much memory there is, as Linux tells it in files. */
#include "run/memory.h"

#include "common/host/control_groups.h"
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

enum { PATH = 4096 };

static uint64_t less(uint64_t a, uint64_t b)
{
    return a > b ? a - b : 0;
}

/* --- control groups ------------------------------------------------------------------------------------------------------ */

/* Names of the files of a version. */
typedef struct Names {
    const char *limit, *used, *inactive;
} Names;

static const Names unified = {"memory.max", "memory.current", "inactive_file "};
static const Names legacy = {"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file "};

/* What is left in one group; files that it has read and nobody uses give way. */
static uint64_t left_in(const char *directory, const Names *names)
{
    char path[PATH + 64];
    uint64_t limit, used, inactive = 0;
    snprintf(path, sizeof path, "%s/%s", directory, names->limit);
    if (!groups_number(path, "", &limit)) return UINT64_MAX;
    snprintf(path, sizeof path, "%s/%s", directory, names->used);
    if (!groups_number(path, "", &used)) return UINT64_MAX;
    snprintf(path, sizeof path, "%s/memory.stat", directory);
    groups_number(path, names->inactive, &inactive);
    return less(limit, less(used, inactive));
}

static void look(void *arg, const char *directory, bool old)
{
    uint64_t *least = arg;
    const uint64_t left = left_in(directory, old ? &legacy : &unified);
    *least = left < *least ? left : *least;
}

static uint64_t left_in_groups(const char *root)
{
    uint64_t least = UINT64_MAX;
    groups_each(root, "memory", look, &least);
    return least;
}

/* --- the machine and the process ----------------------------------------------------------------------------------------- */

static uint64_t left_on_machine(const char *root)
{
    char path[PATH];
    uint64_t kilobytes;
    snprintf(path, sizeof path, "%s/proc/meminfo", root);
    return groups_number(path, "MemAvailable:", &kilobytes) ? 1024 * kilobytes : UINT64_MAX;
}

/* The first number is the pages of addresses in use. */
static uint64_t left_of_addresses(const char *root)
{
    char path[PATH];
    struct rlimit limit;
    uint64_t pages;
    snprintf(path, sizeof path, "%s/proc/self/statm", root);
    if (getrlimit(RLIMIT_AS, &limit) || limit.rlim_cur == RLIM_INFINITY || !groups_number(path, "", &pages))
        return UINT64_MAX;
    return less(limit.rlim_cur, pages * (uint64_t)sysconf(_SC_PAGESIZE));
}

size_t memory_free(const char *root, const char **ret_why)
{
    const struct {
        uint64_t left;
        const char *why;
    } all[] = {
        {left_on_machine(root), "free on this machine"},
        {left_in_groups(root), "left to its control group"},
        {left_of_addresses(root), "left of its limit of addresses (ulimit -v)"},
    };
    size_t least = 0;
    for (size_t k = 1; k < sizeof all / sizeof *all; k++)
        if (all[k].left < all[least].left) least = k;
    *ret_why = all[least].why;
    return all[least].left < SIZE_MAX ? (size_t)all[least].left : SIZE_MAX;
}
