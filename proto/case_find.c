/* SPDX-License-Identifier: BSD-3-Clause */
/* Find a case by name: as a path, in $MENISCUS_CASES, beside the program, in the installation. */
#include "proto/case_find.h"
#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct Search {
    const char *name;
    char *ret_path;   /* [4096] */
    char looked[256]; /* folders without it, for the complaint */
    char there[128];  /* cases of the first folder that has any */
} Search;

static bool is_file(const char *path)
{
    struct stat info;
    return !stat(path, &info) && S_ISREG(info.st_mode);
}

static void append(char *text, size_t size, const char *more, size_t length)
{
    const size_t n = strlen(text);
    snprintf(text + n, size - n, "%s%.*s", n ? ", " : "", (int)length, more);
}

/* Names of the cases of a folder, without their ending. */
static void list_cases(const char *folder, char *text, size_t size)
{
    struct dirent **entries;
    const int n = scandir(folder, &entries, NULL, alphasort);
    for (int k = 0; k < n; k++) {
        const char *end = strrchr(entries[k]->d_name, '.');
        if (end && !strcmp(end, ".yaml")) append(text, size, entries[k]->d_name, (size_t)(end - entries[k]->d_name));
        free(entries[k]);
    }
    if (n >= 0) free(entries);
}

static bool look_in(Search *search, const char *folder)
{
    char path[4096];
    const int n = snprintf(path, sizeof path, "%s/%s.yaml", folder, search->name);
    if (n > 0 && (size_t)n < sizeof path && is_file(path)) {
        strcpy(search->ret_path, path);
        return true;
    }
    if (access(folder, F_OK)) return false;
    append(search->looked, sizeof search->looked, folder, strlen(folder));
    if (!*search->there) list_cases(folder, search->there, sizeof search->there);
    return false;
}

/* Folders above the program: a build directory lies in the repository, at any depth; an installed program in
 * PREFIX/bin. */
static bool look_beside_program(Search *search)
{
    char folder[3000], cases[4096];
    const ssize_t n = readlink("/proc/self/exe", folder, sizeof folder - 1);
    if (n <= 0) return false;
    folder[n] = 0;
    for (char *slash = strrchr(folder, '/'); slash; slash = strrchr(folder, '/')) {
        *slash = 0;
        snprintf(cases, sizeof cases, "%s/server/cases", folder);
        if (look_in(search, cases)) return true;
        snprintf(cases, sizeof cases, "%s/share/meniscus/cases", folder);
        if (look_in(search, cases)) return true;
    }
    return false;
}

MnsStatus case_find(const char *name, char ret_path[static 4096], MnsError *error)
{
    Search search = {.name = name, .ret_path = ret_path};
    const char *asked = getenv("MENISCUS_CASES");
    if (strlen(name) < 4096 && is_file(name)) {
        strcpy(ret_path, name);
        return MNS_OK;
    }
    if (asked && look_in(&search, asked)) return MNS_OK;
    if (look_beside_program(&search) || look_in(&search, MENISCUS_CASES)) return MNS_OK;
    return mns_fail(error, MNS_E_NOT_FOUND,
                    "there is no case \"%.100s\": no file of that name, and none in %s; there are: %s", name,
                    *search.looked ? search.looked : "a folder of cases", *search.there ? search.there : "none");
}
