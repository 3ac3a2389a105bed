/* SPDX-License-Identifier: BSD-3-Clause */
/* Find a case by name: as a path, in $MENISCUS_CASES, beside the program, which is in the build or installed. */
#include "common/case/find.h"
#include "common/case/value.h"
#include "common/case/words.h"
#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { CASES_MAX = 64 };

typedef struct Search {
    const char *name;
    char *ret_path;    /* [4096] */
    char looked[200];  /* folders without it, for the complaint */
    char there[2000];  /* names of the cases in the first that has any, one after the other */
    char folder[4096]; /* which that is */
    size_t n_there, size_there;
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

/* Remember the name of a case, without its ending. */
static void add_case(Search *search, const char *name, size_t length)
{
    if (search->n_there == CASES_MAX || search->size_there + length >= sizeof search->there) return;
    memcpy(search->there + search->size_there, name, length);
    search->there[search->size_there + length] = 0;
    search->size_there += length + 1;
    search->n_there++;
}

static void list_cases(Search *search, const char *folder)
{
    struct dirent **entries;
    const int n = scandir(folder, &entries, NULL, alphasort);
    for (int k = 0; k < n; k++) {
        const char *end = strrchr(entries[k]->d_name, '.');
        if (end && !strcmp(end, ".yaml")) add_case(search, entries[k]->d_name, (size_t)(end - entries[k]->d_name));
        free(entries[k]);
    }
    if (n >= 0) free(entries);
}

static MnsStatus fail_search(const Search *search, MnsError *error)
{
    const char *names[CASES_MAX], *next = search->there;
    char shown[48], there[sizeof error->text] = "there are none";
    struct stat info;
    if (!stat(search->name, &info))
        return mns_fail(error, MNS_E_INVALID, "a case is a file, and \"%s\" is %s", case_shown(search->name, shown),
                        S_ISDIR(info.st_mode) ? "a directory" : "no regular file");
    for (size_t k = 0; k < search->n_there; k++, next += strlen(next) + 1) names[k] = next;
    const char *end = strrchr(search->name, '.');
    if (end && !strcmp(end, ".yaml"))
        return mns_fail(error, MNS_E_NOT_FOUND,
                        "there is no file \"%s\"; `meniscus init FILE.yaml` writes a case to begin with",
                        case_shown(search->name, shown));
    case_shown(search->name, shown);
    const size_t around =
        strlen(shown) + strlen(search->looked) + sizeof "there is no case \"\": no file of that name, and none in ; ";
    if (search->n_there)
        words_suggest(names, search->n_there, search->name, "`meniscus completion cases`", there,
                      sizeof error->text - around);
    return mns_fail(error, MNS_E_NOT_FOUND, "there is no case \"%s\": no file of that name, and none in %s; %s", shown,
                    search->looked, there);
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
    if (!strstr(search->looked, folder)) append(search->looked, sizeof search->looked, folder, strlen(folder));
    if (search->n_there) return false;
    list_cases(search, folder);
    if (search->n_there) snprintf(search->folder, sizeof search->folder, "%s", folder);
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

static bool look_everywhere(Search *search)
{
    const char *asked = getenv("MENISCUS_CASES");
    return (asked && look_in(search, asked)) || look_beside_program(search);
}

void case_list(void (*tell)(void *arg, const char *name, const char *folder), void *arg)
{
    char path[4096];
    Search search = {.name = ".", .ret_path = path}; /* no case is called that */
    if (look_everywhere(&search)) return;
    const char *next = search.there;
    for (size_t k = 0; k < search.n_there; k++, next += strlen(next) + 1) tell(arg, next, search.folder);
}

MnsStatus case_find(const char *name, char ret_path[static 4096], MnsError *error)
{
    Search search = {.name = name, .ret_path = ret_path};
    if (strlen(name) < 4096 && is_file(name)) {
        strcpy(ret_path, name);
        return MNS_OK;
    }
    if (look_everywhere(&search)) return MNS_OK;
    if (!*search.looked) /* no such folder, and $MENISCUS_CASES would say where there is one */
        snprintf(search.looked, sizeof search.looked, "$MENISCUS_CASES or beside the program");
    return fail_search(&search, error);
}
