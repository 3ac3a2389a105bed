/* SPDX-License-Identifier: BSD-3-Clause */
/* A case file in memory: its message, where each entry stands, and what was overridden. */
#include "common/case/mark.h"
#include "common/case/reader.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* What --set has changed. */
typedef struct Setting {
    char *path, *yaml;
    char text[192]; /* the assignment as it was given, shortened, for complaints */
} Setting;

struct CaseFile {
    char *name;
    Meniscus__Case *message;
    Marks marks;
    size_t n_sets;
    Setting *sets; /* [n_sets] the newest last */
};

const Meniscus__Case *case_file_message(const CaseFile *file)
{
    return file->message;
}

void case_file_free(CaseFile *file)
{
    if (!file) return;
    meniscus__case__free_unpacked(file->message, NULL);
    marks_done(&file->marks);
    for (size_t k = 0; k < file->n_sets; k++) {
        free(file->sets[k].path);
        free(file->sets[k].yaml);
    }
    free(file->sets);
    free(file->name);
    free(file);
}

static CaseFile *file_new(const char *name)
{
    CaseFile *file = calloc(1, sizeof *file);
    if (!file) return NULL;
    file->name = strdup(name);
    file->message = (Meniscus__Case *)case_message_new(&meniscus__case__descriptor);
    if (file->name && file->message) return file;
    case_file_free(file);
    return NULL;
}

/* The entries of a text, which need not make a case yet. */
static MnsStatus parse(const char *name, const char *text, size_t size, CaseFile **ret, MnsError *error)
{
    CaseFile *file = file_new(name);
    if (!file) return case_no_memory(error);
    const MnsStatus status = case_read_document(name, text, size, &file->message->base, &file->marks, error);
    if (status) case_file_free(file);
    else *ret = file;
    return status;
}

/* Hand out a file whose entries make a case; free one whose do not. */
static MnsStatus check(CaseFile *file, CaseFile **ret, MnsError *error)
{
    MnsError local;
    MnsError *why = error ? error : &local;
    const MnsStatus status = case_message_check(file->message, why);
    if (status) {
        case_file_locate(file, why);
        case_file_free(file);
    } else {
        *ret = file;
    }
    return status;
}

MnsStatus case_file_parse(const char *name, const char *text, size_t size, CaseFile **ret, MnsError *error)
{
    CaseFile *file;
    const MnsStatus status = parse(name, text, size, &file, error);
    return status ? status : check(file, ret, error);
}

static MnsStatus fail_file(const char *path, const char *what, int number, MnsError *error)
{
    const MnsStatus status = number == ENOENT || number == ENOTDIR ? MNS_E_NOT_FOUND : MNS_E_IO;
    return mns_fail(error, status, "%s: cannot %s the case file: %s; %s", path, what, strerror(number),
                    mns_refusal_hint(number));
}

/* All bytes of an open file, one more than allowed at most, so that the parser can refuse it. */
static MnsStatus read_all(const char *path, FILE *in, char **ret, size_t *ret_size, MnsError *error)
{
    size_t size = 0, room = 1 << 14;
    char *text = malloc(room);
    while (text) {
        size += fread(text + size, 1, room - size, in);
        if (ferror(in)) {
            free(text);
            return fail_file(path, "read", errno, error);
        }
        if (size < room || size > CASE_FILE_LIMIT) {
            *ret = text;
            *ret_size = size;
            return MNS_OK;
        }
        char *grown = realloc(text, room *= 2);
        if (!grown) free(text);
        text = grown;
    }
    return case_no_memory(error);
}

/* Regular files alone: nobody may ever write into a pipe of that name. */
static MnsStatus open_file(const char *path, FILE **ret, MnsError *error)
{
    struct stat info;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0 || fstat(fd, &info)) return fail_file(path, "open", errno, error);
    if (!S_ISREG(info.st_mode)) {
        close(fd);
        return mns_fail(error, MNS_E_INVALID, "%s: a case is a file, and this is %s", path,
                        S_ISDIR(info.st_mode) ? "a directory" : "no regular file");
    }
    *ret = fdopen(fd, "r");
    if (*ret) return MNS_OK;
    close(fd);
    return case_no_memory(error);
}

static MnsStatus read_entries(const char *path, CaseFile **ret, MnsError *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *in;
    MnsStatus status = open_file(path, &in, error);
    if (status) return status;
    status = read_all(path, in, &text, &size, error);
    fclose(in);
    if (status) return status;
    status = parse(path, text, size, ret, error);
    free(text);
    return status;
}

MnsStatus case_file_read(const char *path, CaseFile **ret, MnsError *error)
{
    return case_file_read_with(path, 0, NULL, ret, error);
}

/* --- where a complaint belongs ------------------------------------------------------------------------------------ */

/* How much of a path, in whole steps, another path begins with. */
static size_t shared(const char *path, const char *other)
{
    size_t n = 0, same = 0;
    for (;; n++) {
        const bool ends = !path[n] || path[n] == '.' || path[n] == '[',
                   other_ends = !other[n] || other[n] == '.' || other[n] == '[';
        if (ends && other_ends) same = n;
        if (path[n] != other[n] || !path[n]) return same;
    }
}

/* The setting to blame for an entry, of which the file has the first `depth` bytes of the path: the innermost one around it, of several alike
 * the newest; else the first that made an entry around it, which the file lacks. NULL: the file is to blame. */
static const Setting *set_to_blame(const CaseFile *file, const char *path, size_t depth)
{
    const Setting *around = NULL, *beside = NULL;
    size_t most = depth;
    for (size_t k = 0; k < file->n_sets; k++) {
        const Setting *set = &file->sets[k];
        const size_t length = strlen(set->path), same = shared(path, set->path);
        if (same == length && length >= depth && (!around || length >= strlen(around->path))) around = set;
        else if (same < length && same > most) {
            beside = set;
            most = same;
        }
    }
    return around ? around : beside;
}

static bool is_located(const CaseFile *file, const char *text)
{
    const size_t n = strlen(file->name);
    return !strncmp(text, "--set ", 6) || (!strncmp(text, file->name, n) && text[n] == ':');
}

/* The sentence without the path it may begin with. */
static const char *bare_sentence(const MnsError *error)
{
    const size_t n = strlen(error->path);
    return n && !strncmp(error->text, error->path, n) && !strncmp(error->text + n, ": ", 2) ? error->text + n + 2
                                                                                            : error->text;
}

void case_file_locate(const CaseFile *file, MnsError *error)
{
    if (!error || is_located(file, error->text)) return;
    if (error->status == MNS_E_MEMORY && !*error->path) return; /* that of reading it */
    char sentence[sizeof error->text], path[sizeof error->path];
    size_t depth;
    strcpy(sentence, bare_sentence(error));
    strcpy(path, error->path);
    const char *separator = *path ? ": " : "";
    const Mark *mark = &file->marks.list[marks_find(&file->marks, path, &depth)];
    const Setting *set = set_to_blame(file, path, depth);
    if (!set)
        mns_fail_at(error, error->status, path, "%.250s:%u:%u: %s%s%s", file->name, mark->line, mark->column, path,
                    separator, sentence);
    else if (!strcmp(set->path, path)) mns_fail_at(error, error->status, path, "--set %s: %s", set->text, sentence);
    else mns_fail_at(error, error->status, path, "--set %s: %s%s%s", set->text, path, separator, sentence);
}

/* --- overriding --------------------------------------------------------------------------------------------------- */

/* PATH=VALUE with what is long of either cut short. */
static void show_setting(const char *path, const char *yaml, char *text, size_t size)
{
    char shown[48], shown_value[48];
    const bool fits = strlen(path) < sizeof((MnsError *)0)->path;
    snprintf(text, size, "%s=%s", fits ? path : case_shown(path, shown), case_shown(yaml, shown_value));
}

static MnsStatus remember_set(CaseFile *file, const Setting *set, MnsError *error)
{
    Setting *grown = reallocarray(file->sets, file->n_sets + 1, sizeof *grown);
    if (!grown) return case_no_memory(error);
    file->sets = grown;
    file->sets[file->n_sets++] = *set;
    marks_drop(&file->marks, set->path);
    return MNS_OK;
}

/* The complaint of a set that was refused, in the words of the command line. */
static void blame_set(const Setting *set, MnsError *error)
{
    char sentence[sizeof error->text], inner[sizeof error->path];
    strcpy(sentence, bare_sentence(error));
    strcpy(inner, error->path);
    const bool same = !strncmp(inner, set->path, sizeof inner - 1) || !*inner;
    mns_fail_at(error, error->status, inner, "--set %s: %s%s%s", set->text, same ? "" : inner, same ? "" : ": ",
                sentence);
}

typedef MnsStatus (*Change)(const Meniscus__Case *message, const char *path, const char *yaml, Meniscus__Case **ret,
                            MnsError *error);

static MnsStatus set_entry(CaseFile *file, char *path, char *yaml, Change change, MnsError *error)
{
    Setting set = {.path = path, .yaml = yaml};
    show_setting(path, yaml, set.text, sizeof set.text);
    MnsError local;
    MnsError *why = error ? error : &local;
    Meniscus__Case *changed;
    MnsStatus status = change(file->message, path, yaml, &changed, why);
    if (status) {
        blame_set(&set, why);
        return status;
    }
    status = remember_set(file, &set, why);
    meniscus__case__free_unpacked(status ? changed : file->message, NULL);
    if (!status) file->message = changed;
    return status;
}

static MnsStatus assign(CaseFile *file, const char *assignment, Change change, MnsError *error)
{
    char shown[48];
    const char *equals = strchr(assignment, '=');
    if (!equals || equals == assignment)
        return mns_fail(error, MNS_E_INVALID, "--set %s: write PATH=VALUE, as in resolution=40",
                        case_shown(assignment, shown));
    char *path = strndup(assignment, (size_t)(equals - assignment)), *yaml = strdup(equals + 1);
    const MnsStatus status = path && yaml ? set_entry(file, path, yaml, change, error) : case_no_memory(error);
    if (status) {
        free(path);
        free(yaml);
    }
    return status;
}

MnsStatus case_file_set(CaseFile *file, const char *assignment, MnsError *error)
{
    return assign(file, assignment, case_message_set, error);
}

MnsStatus case_file_read_with(const char *path, size_t n_settings, const char *const *settings, CaseFile **ret,
                              MnsError *error)
{
    CaseFile *file = NULL;
    MnsStatus status = read_entries(path, &file, error);
    for (size_t k = 0; !status && k < n_settings; k++) status = assign(file, settings[k], case_message_put, error);
    if (!status) return check(file, ret, error);
    case_file_free(file);
    return status;
}

bool case_file_setting(const CaseFile *file, size_t k, const char **ret_path, const char **ret_yaml)
{
    if (k >= file->n_sets) return false;
    *ret_path = file->sets[k].path;
    *ret_yaml = file->sets[k].yaml;
    return true;
}
