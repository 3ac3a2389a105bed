/* SPDX-License-Identifier: BSD-3-Clause */
/* Control groups of this process, of both versions, as Linux shows them in files. */
#include "common/host/control_groups.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PATH = 4096, LINE = 1024 };

bool groups_number(const char *path, const char *word, uint64_t *ret)
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

/* Is the word one of a list with commas? */
static bool lists(const char *list, size_t size, const char *word)
{
    const size_t n = strlen(word);
    for (const char *at = list; at < list + size; at += strcspn(at, ",:") + 1)
        if (!strncmp(at, word, n) && (at[n] == ',' || at[n] == ':')) return true;
    return false;
}

/* Version 1 has a hierarchy for each controller, or for some together. */
static void find_mount(const char *root, const char *controller, const char *list, size_t size, char ret[static PATH])
{
    snprintf(ret, PATH, "%s/sys/fs/cgroup/%s", root, controller);
    if (access(ret, F_OK)) snprintf(ret, PATH, "%s/sys/fs/cgroup/%.*s", root, (int)size, list);
}

static void look_up(const char *mount, const char *group, bool old, GroupLook *look, void *arg)
{
    char directory[PATH];
    look(arg, mount, old);
    snprintf(directory, sizeof directory, "%s%s", mount, group);
    while (strlen(directory) > strlen(mount)) {
        look(arg, directory, old);
        *strrchr(directory, '/') = 0;
    }
}

/* Lines "0::/GROUP" of version 2, "4:memory:/GROUP" of version 1. */
void groups_each(const char *root, const char *controller, GroupLook *look, void *arg)
{
    char path[PATH], mount[PATH], line[PATH];
    snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
    FILE *file = fopen(path, "re");
    while (file && fgets(line, sizeof line, file)) {
        line[strcspn(line, "\n")] = 0;
        const char *kinds = strchr(line, ':'), *group = kinds ? strchr(kinds + 1, ':') : NULL;
        if (!group) continue;
        const size_t size = (size_t)(group - kinds) - 1;
        const bool old = lists(kinds + 1, size + 1, controller);
        if (!old && strncmp(line, "0::", 3) != 0) continue;
        if (old) find_mount(root, controller, kinds + 1, size, mount);
        else snprintf(mount, sizeof mount, "%s/sys/fs/cgroup", root);
        look_up(mount, group + 1, old, look, arg);
    }
    if (file) fclose(file);
}
