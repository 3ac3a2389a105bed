/* SPDX-License-Identifier: BSD-3-Clause */
/* How much memory there is, as Linux tells it in files. */
#include "run/memory.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

enum { PATH = 4096, LINE = 1024 };

/* The number behind a word at the beginning of a line; a word of "" is the first line's. False if there is none, as of "max". */
static bool number_in(const char *path, const char *word, uint64_t *ret)
{
    char line[LINE];
    bool found = false;
    FILE *file = fopen(path, "re");
    if (!file) return false;
    while (!found && fgets(line, sizeof line, file)) {
        char *end;
        if (strncmp(line, word, strlen(word)) != 0) continue;
        const uint64_t number = strtoull(line + strlen(word), &end, 10);
        found = end != line + strlen(word);
        if (found) *ret = number;
    }
    fclose(file);
    return found;
}

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
    if (!number_in(path, "", &limit)) return UINT64_MAX;
    snprintf(path, sizeof path, "%s/%s", directory, names->used);
    if (!number_in(path, "", &used)) return UINT64_MAX;
    snprintf(path, sizeof path, "%s/memory.stat", directory);
    number_in(path, names->inactive, &inactive);
    return less(limit, less(used, inactive));
}

/* The least that is left in a group and those it is in. A container sees its own group as the root. */
static uint64_t left_up(const char *mount, const char *group, const Names *names)
{
    char directory[PATH];
    uint64_t least = left_in(mount, names);
    snprintf(directory, sizeof directory, "%s%s", mount, group);
    while (strlen(directory) > strlen(mount)) {
        const uint64_t left = left_in(directory, names);
        least = left < least ? left : least;
        *strrchr(directory, '/') = 0;
    }
    return least;
}

/* Is the word one of a list with commas? */
static bool lists(const char *list, size_t size, const char *word)
{
    const size_t n = strlen(word);
    for (const char *at = list; at < list + size; at += strcspn(at, ",:") + 1)
        if (!strncmp(at, word, n) && (at[n] == ',' || at[n] == ':')) return true;
    return false;
}

/* Lines "0::/GROUP" of version 2, "4:memory:/GROUP" of version 1. */
static uint64_t left_in_groups(const char *root)
{
    char path[PATH], mount[PATH], line[PATH];
    uint64_t least = UINT64_MAX;
    snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
    FILE *file = fopen(path, "re");
    while (file && fgets(line, sizeof line, file)) {
        line[strcspn(line, "\n")] = 0;
        const char *kinds = strchr(line, ':'), *group = kinds ? strchr(kinds + 1, ':') : NULL;
        if (!group) continue;
        const bool old = lists(kinds + 1, (size_t)(group - kinds), "memory");
        if (!old && strncmp(line, "0::", 3) != 0) continue;
        snprintf(mount, sizeof mount, "%s/sys/fs/cgroup%s", root, old ? "/memory" : "");
        const uint64_t left = left_up(mount, group + 1, old ? &legacy : &unified);
        least = left < least ? left : least;
    }
    if (file) fclose(file);
    return least;
}

/* --- the machine and the process ----------------------------------------------------------------------------------------- */

static uint64_t left_on_machine(const char *root)
{
    char path[PATH];
    uint64_t kilobytes;
    snprintf(path, sizeof path, "%s/proc/meminfo", root);
    return number_in(path, "MemAvailable:", &kilobytes) ? 1024 * kilobytes : UINT64_MAX;
}

/* The first number is the pages of addresses in use. */
static uint64_t left_of_addresses(const char *root)
{
    char path[PATH];
    struct rlimit limit;
    uint64_t pages;
    snprintf(path, sizeof path, "%s/proc/self/statm", root);
    if (getrlimit(RLIMIT_AS, &limit) || limit.rlim_cur == RLIM_INFINITY || !number_in(path, "", &pages))
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
