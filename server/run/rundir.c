/* SPDX-License-Identifier: BSD-3-Clause */
/* The directory that holds everything of one run. */
#include "run/rundir.h"

#include "base/log.h"
#include "common/case/name.h"
#include "common/host/places.h"
#include "common/host/text.h"
#include "io/atomic_file.h"
#include "io/directory.h"
#include "io/names.h"
#include "run/lock.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool exists(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0;
}

MnsStatus rundir_choose(const char *parent, const char *name, bool latest, char ret[static RUNDIR_PATH],
                        MnsError *error)
{
    if (strlen(parent) + strlen(name) + 16 > RUNDIR_PATH)
        return mns_fail(error, MNS_E_LIMIT, "the path of the run directory is too long: %.200s...", parent);
    char before[RUNDIR_PATH];
    snprintf(ret, RUNDIR_PATH, "%s/%s", parent, name);
    for (unsigned k = 2; exists(ret); k++) {
        memcpy(before, ret, sizeof before);
        snprintf(ret, RUNDIR_PATH, "%s/%s.%u", parent, name, k);
        if (latest && !exists(ret)) memcpy(ret, before, sizeof before);
        if (latest && !strcmp(ret, before)) break;
    }
    return MNS_OK;
}

/* From the end on, what is empty, down to the part of this length. */
static void remove_down_to(char path[static 4096], size_t first)
{
    while (first && strlen(path) >= first) {
        char *slash = strrchr(path, '/');
        rmdir(path);
        if (!slash) return;
        *slash = 0;
    }
}

static bool is_directory(const char *path)
{
    struct stat info;
    return !stat(path, &info) && S_ISDIR(info.st_mode);
}

static MnsStatus fail_place(const char *path, MnsError *error)
{
    char found[PLACES_FOUND];
    places_found(path, found);
    return mns_fail(error, MNS_E_IO,
                    "'%.200s' is %s, where a directory is to be; move it away, or choose another place", path, found);
}

/* path ends with a slash, which is put back. */
static MnsStatus make_all(char path[static 4096], size_t *ret_first, MnsError *error)
{
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        const bool made = !mkdir(path, 0775); /* whatever the umask, not for every account to write */
        if (!made && errno != EEXIST) return file_fail(error, errno, "make the directory", path);
        if (!made && !is_directory(path)) return fail_place(path, error);
        if (made && !*ret_first) *ret_first = strlen(path);
        *slash = '/';
    }
    return access(path, W_OK | X_OK) ? file_fail(error, errno, "write to", path) : MNS_OK;
}

MnsStatus rundir_make(const char *dir, size_t *ret_made, MnsError *error)
{
    char path[4096];
    size_t first = 0;
    if (strlen(dir) >= RUNDIR_PATH)
        return mns_fail(error, MNS_E_LIMIT, "the path of the run directory is too long: %.200s...", dir);
    snprintf(path, sizeof path, "%s/", dir);
    const MnsStatus status = make_all(path, &first, error);
    if (status) remove_down_to(path, first);
    else *ret_made = first;
    return status;
}

static const char lock_name[] = "lock";

/* A warning and no refusal: volumes of containers are often open to every account, where there is only one. */
static MnsStatus take_lock(const char *dir, int *ret_fd, char ret_holder[static LOCK_HOLDER], MnsError *error)
{
    char path[4096], exposed[512];
    MnsStatus status = directory_path(path, dir, lock_name, error);
    if (!status) status = lock_take(path, ret_fd, ret_holder, error);
    if (!status && places_is_exposed(dir, exposed, sizeof exposed)) log_line(LOG_WARNING, "%s", exposed);
    return status;
}

MnsStatus rundir_lock(const char *dir, int *ret_fd, MnsError *error)
{
    char holder[LOCK_HOLDER];
    const MnsStatus status = take_lock(dir, ret_fd, holder, error);
    if (status != MNS_E_STATE) return status;
    return mns_fail(error, MNS_E_STATE,
                    "%s is running in the directory '%.300s'; wait until it has ended, or choose another directory",
                    holder, dir);
}

MnsStatus rundir_check(const char *dir, int lock, MnsError *error)
{
    char path[4096];
    const MnsStatus status = lock < 0 ? MNS_OK : directory_path(path, dir, lock_name, error);
    if (status || lock < 0 || file_is_at(lock, path)) return status;
    return mns_fail(error, MNS_E_IO,
                    "'%.300s' is not the directory of this run any more: it, or its file '%s', was moved, removed or "
                    "replaced; put it back",
                    dir, lock_name);
}

MnsStatus rundir_hold(const char *parent, int *ret_fd, MnsError *error)
{
    char holder[LOCK_HOLDER];
    const MnsStatus status = take_lock(parent, ret_fd, holder, error);
    if (status != MNS_E_STATE) return status;
    return mns_fail(
        error, MNS_E_STATE,
        "another daemon, %s, has the runs in '%.300s': speak to that one, which `meniscus ls` names, or give "
        "this one another --state-dir",
        holder, parent);
}

static const char current_name[] = "current";

static const char *name_of(const char *dir)
{
    const char *slash = strrchr(dir, '/');
    return slash ? slash + 1 : dir;
}

MnsStatus rundir_note_current(const char *parent, const char *dir, const char *asked, MnsError *error)
{
    char path[4096], *text;
    MnsStatus status = directory_path(path, parent, current_name, error);
    if (status) return status;
    const int size = asprintf(&text, "%s\n%s", name_of(dir), asked ? asked : "");
    if (size < 0) return mns_fail(error, MNS_E_MEMORY, "no memory for the name of the run");
    status = atomic_write(path, text, (size_t)size, error);
    free(text);
    return status;
}

void rundir_forget_current(const char *parent)
{
    char path[4096];
    if (!directory_path(path, parent, current_name, NULL)) unlink(path);
}

/* Is this what is left of the file? */
static bool goes_on_with(FILE *file, const char *text)
{
    int c;
    while ((c = getc(file)) != EOF && *text && c == (unsigned char)*text) text++;
    return c == EOF && !*text;
}

/* What is wrong with it. line: the first of the file, "" for an empty one */
static MnsStatus fail_current(const char *path, const char *line, MnsError *error)
{
    enum { SHOWN = 60 };
    char found[PLACES_FOUND], begin[SHOWN + 1];
    struct stat info;
    snprintf(begin, sizeof begin, "%s", line);
    places_found(path, found);
    if (stat(path, &info) || !S_ISREG(info.st_mode))
        return mns_fail(error, MNS_E_CORRUPT, "'%.200s' is %s, where a file with the name of its directory belongs",
                        path, found);
    if (!*line)
        return mns_fail(error, MNS_E_CORRUPT, "'%.200s' is empty, where the name of its directory belongs", path);
    return mns_fail(error, MNS_E_CORRUPT, "'%.200s' begins with \"%s\", where the name of its directory belongs", path,
                    text_shown(begin));
}

/* It may be a link that leads nowhere. */
static MnsStatus fail_to_open(const char *parent, const char *path, int number, MnsError *error)
{
    struct stat info;
    if (number != ENOENT && number != ELOOP) return file_fail(error, number, "read", path);
    if (!lstat(path, &info)) return fail_current(path, "", error);
    return mns_fail(error, MNS_E_NOT_FOUND, "no run was loaded in '%.300s'", parent);
}

MnsStatus rundir_current(const char *parent, const char *asked, char ret[static RUNDIR_PATH], bool *ret_same,
                         MnsError *error)
{
    char path[4096], name[256];
    MnsStatus status = directory_path(path, parent, current_name, error);
    if (status) return status;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* a pipe in its place holds up nobody */
    if (fd < 0) return fail_to_open(parent, path, errno, error);
    FILE *file = fdopen(fd, "r");
    if (!file) {
        close(fd);
        return mns_fail(error, MNS_E_MEMORY, "no memory to read '%.300s'", path);
    }
    const bool read = fgets(name, sizeof name, file) != NULL;
    *ret_same = read && goes_on_with(file, asked ? asked : "");
    fclose(file);
    name[read ? strcspn(name, "\n") : 0] = 0;
    if (!is_name(name)) return fail_current(path, name, error);
    status = directory_path(path, parent, name, error);
    if (!status && strlen(path) >= RUNDIR_PATH)
        status = mns_fail(error, MNS_E_LIMIT, "the path of the run directory is too long: %.200s...", parent);
    if (!status) memcpy(ret, path, strlen(path) + 1);
    return status;
}

MnsStatus rundir_try_current(const char *parent, MnsError *error)
{
    static const char as_long[512] = "";
    char path[4096];
    AtomicFile file;
    MnsStatus status = directory_path(path, parent, current_name, error);
    if (!status) status = atomic_fill(&file, path, as_long, sizeof as_long, error);
    if (!status) atomic_cancel(&file);
    return status;
}

bool rundir_is_current(const char *parent, const char *dir, const char *asked, bool *ret_same)
{
    char named[RUNDIR_PATH];
    const bool is = !rundir_current(parent, asked, named, ret_same, NULL) && !strcmp(name_of(named), name_of(dir));
    *ret_same = *ret_same && is;
    return is;
}

/* A directory that had a run before. */
typedef struct Former {
    struct timespec written; /* its journal */
    uint64_t size;
    char *path;
} Former;

static int by_age(const void *a, const void *b)
{
    const struct timespec s = ((const Former *)a)->written, t = ((const Former *)b)->written;
    if (s.tv_sec != t.tv_sec) return s.tv_sec < t.tv_sec ? -1 : 1;
    return s.tv_nsec < t.tv_nsec ? -1 : s.tv_nsec > t.tv_nsec;
}

/* False if there is no memory for it. */
static bool add_former(const char *parent, const char *name, const char *but, Former **formers, size_t *n)
{
    char dir[4096], path[4096];
    struct stat info;
    if (name[0] == '.' || directory_path(dir, parent, name, NULL) || !strcmp(dir, but)) return true;
    if (strlen(dir) >= RUNDIR_PATH || directory_path(path, dir, JOURNAL_NAME, NULL)) return true;
    if (stat(path, &info) || !S_ISREG(info.st_mode)) return true;
    Former *more = reallocarray(*formers, *n + 1, sizeof *more);
    if (!more) return false;
    *formers = more;
    more[*n] = (Former){info.st_mtim, (uint64_t)info.st_size, strdup(dir)};
    return more[(*n)++].path != NULL;
}

MnsStatus rundir_former(const char *parent, const char *but, uint64_t most_bytes, char ***ret, size_t *ret_n,
                        MnsError *error)
{
    Former *formers = NULL;
    size_t n = 0, first = 0;
    bool room = true;
    DIR *all = opendir(parent);
    for (const struct dirent *entry; all && room && (entry = readdir(all));)
        room = add_former(parent, entry->d_name, but, &formers, &n);
    if (all) closedir(all);
    if (n) qsort(formers, n, sizeof *formers, by_age);
    for (first = n; first > 0 && formers[first - 1].size <= most_bytes; first--) most_bytes -= formers[first - 1].size;
    *ret = room ? calloc(n - first + 1, sizeof **ret) : NULL;
    *ret_n = *ret ? n - first : 0;
    for (size_t k = 0; k < n; k++) {
        if (*ret && k >= first) (*ret)[k - first] = formers[k].path;
        else free(formers[k].path);
    }
    free(formers);
    return *ret ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "no memory for the runs in '%.300s'", parent);
}

void rundir_forget_journal(const char *dir)
{
    char path[4096];
    if (!directory_path(path, dir, JOURNAL_NAME, NULL)) unlink(path);
}

void rundir_unmake(const char *dir, size_t made)
{
    char path[4096];
    if (!directory_path(path, dir, lock_name, NULL)) unlink(path);
    snprintf(path, sizeof path, "%s", dir);
    remove_down_to(path, made);
}

static const char series_name[] = "probes.hdf";

static bool is_name_of_output(const char *name)
{
    uint64_t step;
    return name_step(name, &step) || !strcmp(name, series_name) || !strcmp(name, INDEX_NAME) ||
           !strcmp(name, "case.yaml");
}

void rundir_clear(const char *dir)
{
    char stem[256];
    DIR *stream = opendir(dir);
    if (!stream) return;
    for (struct dirent *entry; (entry = readdir(stream));) {
        snprintf(stem, sizeof stem, "%s", entry->d_name);
        char *end = strrchr(stem, '.');
        if (!end || strcmp(end, ATOMIC_END) != 0) continue;
        *end = 0;
        if (is_name_of_output(stem)) unlinkat(dirfd(stream), entry->d_name, 0);
    }
    closedir(stream);
}

/* The first of abandoned, abandoned.2 ... that does not exist: what was left before is left alone. */
static MnsStatus make_aside(const char *dir, char ret[static RUNDIR_PATH], MnsError *error)
{
    char path[RUNDIR_PATH];
    int n = snprintf(path, sizeof path, "%s/abandoned", dir);
    for (unsigned k = 2; n < RUNDIR_PATH && mkdir(path, 0777); k++) {
        if (errno != EEXIST) return file_fail(error, errno, "make the directory", path);
        n = snprintf(path, sizeof path, "%s/abandoned.%u", dir, k);
    }
    if (n >= RUNDIR_PATH)
        return mns_fail(error, MNS_E_LIMIT, "the path of the run directory is too long: %.200s...", dir);
    memcpy(ret, path, sizeof path);
    return MNS_OK;
}

static MnsStatus move_aside(const char *dir, const char *name, char aside[static RUNDIR_PATH], MnsError *error)
{
    char from[4096 + 260], to[4096 + 260];
    const MnsStatus status = aside[0] ? MNS_OK : make_aside(dir, aside, error);
    if (status) return status;
    snprintf(from, sizeof from, "%s/%s", dir, name);
    snprintf(to, sizeof to, "%s/%s", aside, name);
    return rename(from, to) ? file_fail(error, errno, "move aside", from) : MNS_OK;
}

/* The series goes on with fewer samples in a new file of the name, so a link keeps them all; where there are no links, a copy. */
static MnsStatus keep_series(const char *dir, const char *aside, MnsError *error)
{
    char from[4096], to[4096];
    const MnsStatus status = directory_path(from, dir, series_name, error);
    if (status || !exists(from)) return status;
    const MnsStatus found = directory_path(to, aside, series_name, error);
    return found || !link(from, to) ? found : atomic_copy(from, to, error);
}

/* A link is still at its old place: a rename to there would do nothing, so its second name is taken away. */
static void put_back(const char *dir, const char *aside, const char *name)
{
    char from[4096 + 260], to[4096 + 260];
    snprintf(from, sizeof from, "%s/%s", aside, name);
    snprintf(to, sizeof to, "%s/%s", dir, name);
    if (!rename(from, to)) unlink(from);
}

void rundir_return(const char *dir, const char *aside)
{
    DIR *stream = aside[0] ? opendir(aside) : NULL;
    if (!stream) return;
    for (struct dirent *entry; (entry = readdir(stream));)
        if (entry->d_name[0] != '.' && strcmp(entry->d_name, INDEX_NAME) != 0 &&
            strcmp(entry->d_name, JOURNAL_NAME) != 0)
            put_back(dir, aside, entry->d_name);
    closedir(stream);
    put_back(dir, aside, INDEX_NAME); /* last, as it went first */
    rmdir(aside);
}

MnsStatus rundir_retire_journal(const char *dir, char ret_aside[static RUNDIR_PATH], MnsError *error)
{
    char aside[RUNDIR_PATH] = "";
    const MnsStatus status = move_aside(dir, JOURNAL_NAME, aside, error);
    if (status && aside[0]) rmdir(aside);
    if (!status) memcpy(ret_aside, aside, sizeof aside);
    return status;
}

void rundir_return_journal(const char *dir, const char *aside)
{
    put_back(dir, aside, JOURNAL_NAME);
    rmdir(aside);
}

/* Before the files that it lists. */
static MnsStatus move_list(const char *dir, char aside[static RUNDIR_PATH], MnsError *error)
{
    char path[4096];
    const MnsStatus status = directory_path(path, dir, INDEX_NAME, error);
    return status || !exists(path) ? status : move_aside(dir, INDEX_NAME, aside, error);
}

MnsStatus rundir_abandon(const char *dir, bool all, uint64_t after, char ret_aside[static RUNDIR_PATH], MnsError *error)
{
    char aside[RUNDIR_PATH];
    memcpy(aside, ret_aside, sizeof aside);
    DIR *stream = opendir(dir);
    if (!stream) return file_fail(error, errno, "read", dir);
    MnsStatus status = all ? move_list(dir, aside, error) : MNS_OK;
    for (struct dirent *entry; !status && (entry = readdir(stream));) {
        uint64_t step;
        const bool numbered = name_step(entry->d_name, &step);
        if ((numbered && (all || step > after)) || (all && !strcmp(entry->d_name, series_name)))
            status = move_aside(dir, entry->d_name, aside, error);
    }
    closedir(stream);
    if (!status && !all && aside[0]) status = keep_series(dir, aside, error);
    if (status) rundir_return(dir, aside);
    else memcpy(ret_aside, aside, sizeof aside);
    return status;
}

static int is_output(const struct dirent *entry)
{
    return is_name_of_output(entry->d_name);
}

MnsStatus rundir_list(const char *dir, char ***ret, size_t *ret_n, MnsError *error)
{
    struct dirent **entries;
    const int n = scandir(dir, &entries, is_output, alphasort);
    if (n < 0) return file_fail(error, errno, "read", dir);
    char **names = calloc((size_t)n + 1, sizeof *names);
    for (int k = 0; k < n; k++) {
        if (names) names[k] = strdup(entries[k]->d_name);
        free(entries[k]);
    }
    free(entries);
    if (!names) return mns_fail(error, MNS_E_MEMORY, "no memory for the list of files");
    *ret = names;
    *ret_n = (size_t)n;
    return MNS_OK;
}
