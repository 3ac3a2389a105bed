/* SPDX-License-Identifier: BSD-3-Clause */
/* The index that tells ParaView the times of the snapshots in a directory: made anew from the files themselves each
 * time, at 0.04 ms a file, so that it cannot be wrong for long. */
#include "io/atomic_file.h"
#include "io/directory.h"
#include "io/h5.h"
#include "io/names.h"
#include "io/snapshot.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

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

/* Files that cannot be read are left out: the others still play. @return how many moments there are. */
static size_t find_moments(const char *dir, const DirectoryEntry *files, size_t n, Moment *moments)
{
    char path[IO_PATH_MAX];
    size_t found = 0;
    for (size_t k = 0; k < n; k++) {
        Moment moment = {.name = files[k].name};
        if (directory_path(path, dir, files[k].name, NULL) || h5_load(path, false, get_time, &moment.t, NULL)) continue;
        moments[found++] = moment;
    }
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
    const MnsStatus status = directory_path(path, dir, "snapshots.hdf.series", error);
    if (status) return status;
    char *text = index_text(moments, n);
    if (!text) return mns_fail(error, MNS_E_MEMORY, "no memory for the index of the snapshots in '%s'", dir);
    const MnsStatus written = atomic_write(path, text, strlen(text), error);
    free(text);
    return written;
}

MnsStatus snapshot_index(const char *dir, MnsError *error)
{
    DirectoryEntry *files = NULL;
    size_t n = 0;
    MnsStatus status = directory_list(dir, SNAPSHOT_BEGIN, NUMBERED_END, &files, &n, error);
    if (status) return status;
    Moment *moments = malloc((n + 1) * sizeof *moments);
    if (moments) status = write_index(dir, moments, find_moments(dir, files, n, moments), error);
    else status = mns_fail(error, MNS_E_MEMORY, "no memory for the index of the %zu snapshots in '%s'", n, dir);
    free(moments);
    free(files);
    return status;
}
