/* SPDX-License-Identifier: BSD-3-Clause */
/* Time series of the probes: kept in memory, written whole each time it is flushed. */
#include "io/series.h"
#include "io/atomic_file.h"
#include "io/directory.h"
#include "io/meta.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* What was written before a line and is not of it is there no longer. */
typedef struct Lines {
    size_t n;
    uint64_t *id, *row; /* [n] */
} Lines;

struct Series {
    FileMeta meta;
    const char *level, *arithmetic; /* of the run that it was made for */
    char path[IO_PATH_MAX];
    size_t n, room; /* rows */
    uint64_t *step; /* [room] */
    double *time;   /* [room] s */
    double **value; /* [probes][room] */
    Lines lines;
    _Atomic size_t saved; /* rows in the file */
    bool changed;         /* since it was last written */
    bool cut;             /* rows that were in the file were left out */
    uint64_t last_step;   /* of interest when an old file is read */
};

static size_t probes(const Series *s)
{
    return s->meta.c->n_probes;
}

static bool grow_column(double **column, size_t room)
{
    double *grown = realloc(*column, room * sizeof *grown);
    if (grown) *column = grown;
    return grown != NULL;
}

/* Columns that grew before one that did not are merely longer than they need to be. */
static MnsStatus make_room(Series *s, size_t rows, MnsError *error)
{
    if (rows <= s->room) return MNS_OK;
    const size_t room = rows > 2 * s->room ? rows : 2 * s->room;
    uint64_t *step = realloc(s->step, room * sizeof *step);
    if (step) s->step = step;
    bool grown = step && grow_column(&s->time, room);
    for (size_t k = 0; k < probes(s) && grown; k++) grown = grow_column(&s->value[k], room);
    if (!grown) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu rows of probe values", room);
    s->room = room;
    return MNS_OK;
}

static void name_of(char name[static 256], const MnsProbe *probe)
{
    snprintf(name, 256, "/probes/%s", probe->name);
}

/* --- reading what is there --------------------------------------------------------------------------------------- */

static bool same_probes(H5 *h, const Series *s)
{
    char name[256];
    if (h5_members(h, "/probes") != probes(s)) return false;
    for (size_t k = 0; k < probes(s); k++) {
        const MnsProbe *probe = &s->meta.c->probes[k];
        name_of(name, probe);
        if (!h5_has(h, name) || !h5_mark_is(h, name, "unit", mns_probe_unit(probe))) return false;
    }
    return true;
}

static MnsStatus lines_room(Lines *lines, size_t n, MnsError *error)
{
    uint64_t *id = realloc(lines->id, n * sizeof *id);
    if (id) lines->id = id;
    uint64_t *row = id ? realloc(lines->row, n * sizeof *row) : NULL;
    if (row) lines->row = row;
    return row ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "no memory for %zu time lines", n);
}

static void get_lines(H5 *h, Lines *lines)
{
    const size_t n = h5_rows(h, "/lines/id");
    h5_expect_bytes(h, n);
    if (!n || h->status) return;
    h->status = lines_room(lines, n, h->error);
    h5_get(h, "/lines/id", H5T_NATIVE_UINT64, n, lines->id);
    h5_get(h, "/lines/row", H5T_NATIVE_UINT64, n, lines->row);
    if (!h->status) lines->n = n;
}

static void get_rows(H5 *h, void *into)
{
    Series *s = into;
    char name[256];
    if (!same_probes(h, s)) return;
    const size_t n = h5_rows(h, "/step");
    h5_expect_bytes(h, n);
    if (!h->status) h->status = make_room(s, n, h->error);
    h5_get(h, "/step", H5T_NATIVE_UINT64, n, s->step);
    h5_get(h, "/time", H5T_NATIVE_DOUBLE, n, s->time);
    for (size_t k = 0; k < probes(s) && !h->status; k++) {
        name_of(name, &s->meta.c->probes[k]);
        h5_get(h, name, H5T_NATIVE_DOUBLE, n, s->value[k]);
    }
    while (!h->status && s->n < n && s->step[s->n] <= s->last_step) s->n++;
    s->saved = s->n;
    s->cut = s->changed = s->n < n;
    if (!h->status && h5_has(h, "/lines/id")) get_lines(h, &s->lines);
}

/* The sentence of a file that cannot be read says what to do about it. */
static MnsStatus take_over(Series *s, MnsError *error)
{
    MnsError why = {0};
    const MnsStatus status = h5_load(s->path, true, get_rows, s, &why);
    if (status == MNS_OK || status == MNS_E_NOT_FOUND) return MNS_OK;
    return mns_fail(error, status, "%s; move it away to begin a new series", why.text);
}

/* --- the series -------------------------------------------------------------------------------------------------- */

MnsStatus series_new(const char *dir, const FileMeta *meta, bool resume, uint64_t last_step, Series **ret,
                     MnsError *error)
{
    Series *s = calloc(1, sizeof *s);
    if (s) s->value = calloc(meta->c->n_probes + 1, sizeof *s->value);
    if (!s || !s->value) {
        free(s);
        return mns_fail(error, MNS_E_MEMORY, "no memory for the series of %zu probes", meta->c->n_probes);
    }
    s->meta = *meta;
    s->level = mns_level();
    s->arithmetic = mns_arithmetic();
    s->last_step = last_step;
    MnsStatus status = directory_path(s->path, dir, "probes.hdf", error);
    if (!status && resume) status = take_over(s, error);
    if (!status && !s->lines.n) status = series_begin_line(s, error);
    if (status) series_free(s);
    else *ret = s;
    return status;
}

MnsStatus series_set_aside(const char *dir, MnsError *error)
{
    char from[4096], to[4096];
    MnsStatus status = directory_path(from, dir, "probes.hdf", error);
    if (!status) status = directory_path(to, dir, "probes.hdf.damaged", error);
    if (status) return status;
    return rename(from, to) ? file_fail(error, errno, "move aside", from) : MNS_OK;
}

size_t series_rows(const Series *series)
{
    return series->n;
}

size_t series_saved(const Series *series)
{
    return series->saved < series->n ? series->saved : series->n;
}

bool series_was_cut(const Series *series)
{
    return series->cut;
}

/* By the clock, so that no other line has the same number, whatever file it was in. */
MnsStatus series_begin_line(Series *series, MnsError *error)
{
    Lines *lines = &series->lines;
    struct timespec now;
    const MnsStatus status = lines_room(lines, lines->n + 1, error);
    if (status) return status;
    clock_gettime(CLOCK_REALTIME, &now);
    lines->id[lines->n] = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
    lines->row[lines->n++] = series->n;
    if (series->n) series->changed = true;
    return MNS_OK;
}

uint64_t series_line(const Series *series)
{
    return series->lines.id[series->lines.n - 1];
}

size_t series_line_end(const Series *series, uint64_t line)
{
    const Lines *lines = &series->lines;
    size_t k = 0, end = SIZE_MAX;
    while (k < lines->n && lines->id[k] != line) k++;
    if (k == lines->n) return 0;
    while (++k < lines->n)
        if (lines->row[k] < end) end = lines->row[k];
    return end;
}

void series_copy(const Series *series, size_t first, size_t n, size_t n_columns, const int *columns, uint64_t *step,
                 double *time, double *values)
{
    memcpy(step, series->step + first, n * sizeof *step);
    memcpy(time, series->time + first, n * sizeof *time);
    for (size_t c = 0; c < n_columns; c++) {
        const double *from = series->value[columns[c]] + first;
        for (size_t k = 0; k < n; k++) values[k * n_columns + c] = from[k];
    }
}

size_t series_size(const Series *series)
{
    return series->n * (sizeof *series->step + sizeof *series->time + probes(series) * sizeof **series->value);
}

MnsStatus series_append(Series *series, uint64_t step, double t, const double *values, MnsError *error)
{
    const MnsStatus status = make_room(series, series->n + 1, error);
    if (status) return status;
    while (series->n && series->step[series->n - 1] >= step) series->n--;
    const size_t row = series->n++;
    series->step[row] = step;
    series->time[row] = t;
    for (size_t k = 0; k < probes(series); k++) series->value[k][row] = values[k];
    series->changed = true;
    return MNS_OK;
}

static void fill(H5 *h, const void *what)
{
    const Series *s = what;
    char name[256];
    meta_put_run(h, &s->meta);
    meta_put_level(h, s->level, s->arithmetic);
    h5_put(h, "/step", H5T_NATIVE_UINT64, s->n, s->step);
    h5_put(h, "/time", H5T_NATIVE_DOUBLE, s->n, s->time);
    h5_mark_text(h, "/time", "unit", "s");
    h5_make_group(h, "/probes");
    for (size_t k = 0; k < probes(s); k++) {
        name_of(name, &s->meta.c->probes[k]);
        h5_put(h, name, H5T_NATIVE_DOUBLE, s->n, s->value[k]);
        h5_mark_text(h, name, "unit", mns_probe_unit(&s->meta.c->probes[k]));
    }
    h5_make_group(h, "/lines");
    h5_put(h, "/lines/id", H5T_NATIVE_UINT64, s->lines.n, s->lines.id);
    h5_put(h, "/lines/row", H5T_NATIVE_UINT64, s->lines.n, s->lines.row);
}

MnsStatus series_flush(Series *series, MnsError *error)
{
    if (!series->changed) return MNS_OK;
    const MnsStatus status = h5_save(series->path, true, fill, series, error);
    series->changed = status != MNS_OK;
    if (!status) series->saved = series->n;
    return status;
}

void series_free(Series *series)
{
    if (!series) return;
    for (size_t k = 0; k < probes(series); k++) free(series->value[k]);
    free(series->value);
    free(series->time);
    free(series->step);
    free(series->lines.id);
    free(series->lines.row);
    free(series);
}
