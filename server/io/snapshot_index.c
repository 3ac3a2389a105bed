/* SPDX-License-Identifier: BSD-3-Clause */
/* The index that tells ParaView the times of the snapshots in a directory. It is made from the files there are; those that have
 * not changed since the last index was written are not opened again, at 0.04 ms each, but taken from it. */
#include "io/atomic_file.h"
#include "io/directory.h"
#include "io/h5.h"
#include "io/names.h"
#include "io/snapshot.h"

#include <fcntl.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct Moment {
    const char *name; /* of the file */
    double t;         /* [s] */
} Moment;

static void get_time(H5 *h, void *into)
{
    h5_get_mark(h, "/meniscus", "time", H5T_NATIVE_DOUBLE, into);
}

static int by_time(const void *left, const void *right)
{
    const Moment *a = left, *b = right;
    return a->t < b->t ? -1 : a->t > b->t ? 1 : strcmp(a->name, b->name);
}

/* What an earlier index says. */
typedef struct Known {
    json_t *times;           /* an object: name, time; empty if there is no index or not one of ours */
    struct timespec written; /* the index */
} Known;

static Known read_index(const char *dir)
{
    Known known = {.times = json_object()};
    char path[IO_PATH_MAX];
    struct stat about;
    size_t k;
    json_t *index, *file;
    const int fd = directory_path(path, dir, INDEX_NAME, NULL) ? -1 : file_open(path, O_RDONLY, 0);
    if (fd < 0) return known;
    if (!fstat(fd, &about)) known.written = about.st_mtim;
    index = json_loadfd(fd, 0, NULL);
    close(fd);
    json_array_foreach(json_object_get(index, "files"), k, file)
    {
        const char *name = json_string_value(json_object_get(file, "name"));
        json_t *time = json_object_get(file, "time");
        if (name && json_is_real(time)) json_object_set(known.times, name, time);
    }
    json_decref(index);
    return known;
}

static bool is_earlier(struct timespec a, struct timespec b)
{
    return a.tv_sec != b.tv_sec ? a.tv_sec < b.tv_sec : a.tv_nsec < b.tv_nsec;
}

/* Time of a file's moment, from the index if nothing has touched it since. */
static MnsStatus find_time(const char *dir, const DirectoryEntry *file, const Known *known, double *ret,
                           MnsError *error)
{
    char path[IO_PATH_MAX];
    const json_t *time = json_object_get(known->times, file->name);
    if (time && is_earlier(file->changed, known->written)) {
        *ret = json_real_value(time);
        return MNS_OK;
    }
    const MnsStatus status = directory_path(path, dir, file->name, error);
    return status ? status : h5_load(path, false, get_time, ret, error);
}

/* Those of later steps are left out, which are to go. @return how many are left. */
static size_t drop_later(DirectoryEntry *files, size_t n, uint64_t last)
{
    size_t left = 0;
    uint64_t step;
    for (size_t k = 0; k < n; k++)
        if (!name_step(files[k].name, &step) || step <= last) files[left++] = files[k];
    return left;
}

/* Files that cannot be read are left out: the others still play. @return how many moments there are. */
static size_t find_moments(const char *dir, const DirectoryEntry *files, size_t n, Moment *moments, FileNote *note,
                           void *arg)
{
    MnsError why;
    const Known known = read_index(dir);
    size_t found = 0;
    for (size_t k = 0; k < n; k++) {
        Moment moment = {.name = files[k].name};
        if (!find_time(dir, &files[k], &known, &moment.t, &why)) moments[found++] = moment;
        else if (note) note(arg, why.text);
    }
    json_decref(known.times);
    qsort(moments, found, sizeof *moments, by_time);
    return found;
}

/* @return the text, to be freed; NULL if there is no memory. */
static char *index_text(const Moment *moments, size_t n)
{
    json_t *files = json_array();
    for (size_t k = 0; k < n; k++)
        json_array_append_new(files, json_pack("{s:s, s:f}", "name", moments[k].name, "time", moments[k].t));
    json_t *index = json_pack("{s:s, s:o}", "file-series-version", "1.0", "files", files);
    char *text = index ? json_dumps(index, JSON_INDENT(1)) : NULL;
    json_decref(index);
    return text;
}

static MnsStatus write_index(const char *dir, const Moment *moments, size_t n, MnsError *error)
{
    char path[IO_PATH_MAX];
    const MnsStatus status = directory_path(path, dir, INDEX_NAME, error);
    if (status) return status;
    char *text = index_text(moments, n);
    if (!text) return mns_fail(error, MNS_E_MEMORY, "no memory for the index of the snapshots in '%s'", dir);
    const MnsStatus written = atomic_write(path, text, strlen(text), error);
    free(text);
    return written;
}

MnsStatus snapshot_index(const char *dir, uint64_t last, size_t *ret_n, FileNote *note, void *arg, MnsError *error)
{
    DirectoryEntry *files = NULL;
    size_t n = 0;
    MnsStatus status = directory_list(dir, SNAPSHOT_BEGIN, NUMBERED_END, &files, &n, error);
    if (status) return status;
    n = drop_later(files, n, last);
    Moment *moments = malloc((n + 1) * sizeof *moments);
    const size_t found = moments ? find_moments(dir, files, n, moments, note, arg) : 0;
    if (moments) status = write_index(dir, moments, found, error);
    else status = mns_fail(error, MNS_E_MEMORY, "no memory for the index of the %zu snapshots in '%s'", n, dir);
    free(moments);
    free(files);
    if (!status && ret_n) *ret_n = found;
    return status;
}
