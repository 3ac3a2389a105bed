/* SPDX-License-Identifier: BSD-3-Clause */
/* The past of the probes. */
#include "client/dashboard/history.h"
#include "client/cli/output.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void history_init(History *history)
{
    history->n = 0;
    history->version = 0;
}

void history_clear(History *history)
{
    for (size_t k = 0; k < history->n; k++) {
        free(history->series[k].t);
        free(history->series[k].v);
    }
    history->n = 0;
    history->version++;
}

static Series *find(History *history, const char *name)
{
    for (size_t k = 0; k < history->n; k++)
        if (!strcmp(history->series[k].name, name)) return &history->series[k];
    return NULL;
}

/* The series of that name, a new one if need be; NULL if there is no room. */
static Series *series_of(History *history, const MnsValue *value)
{
    Series *known = find(history, value->name);
    if (known) return known;
    if (history->n == HISTORY_PROBES) return NULL;
    Series *series = &history->series[history->n];
    *series = (Series){.t = malloc(HISTORY_POINTS * sizeof(double)), .v = malloc(HISTORY_POINTS * sizeof(double))};
    if (!series->t || !series->v) {
        free(series->t);
        free(series->v);
        return NULL;
    }
    snprintf(series->name, sizeof series->name, "%s", value->name);
    snprintf(series->unit, sizeof series->unit, "%s", value->unit);
    history->n++;
    return series;
}

/* Of the points [from, end) the lowest and the highest, in their order, to where `to` is: the line keeps its peaks, and no point is made up.
 * Returns where the next one goes. */
static size_t keep_extremes(Series *series, size_t from, size_t end, size_t to)
{
    size_t low = from, high = from;
    for (size_t k = from; k < end; k++) {
        if (series->v[k] < series->v[low] || isnan(series->v[low])) low = k;
        if (series->v[k] > series->v[high] || isnan(series->v[high])) high = k;
    }
    const size_t first = low < high ? low : high, second = low < high ? high : low;
    for (size_t k = first; k <= second; k += second > first ? second - first : 1) {
        series->t[to] = series->t[k];
        series->v[to++] = series->v[k];
    }
    return to;
}

/* Which span a time is in, of those of which two points are kept each. */
static double span_of(const Series *series, double t)
{
    return series->width > 0 ? floor(t / series->width) : t;
}

/* Where the points of the last one begin. */
static size_t last_span(const Series *series)
{
    size_t from = series->n;
    const double span = series->n ? span_of(series, series->t[series->n - 1]) : 0;
    while (from > 0 && span_of(series, series->t[from - 1]) == span) from--;
    return from;
}

/* Spans twice as wide, all of them alike: what is long ago is not thinned more often than what has just come. */
static void thin(Series *series)
{
    const double all = series->t[series->n - 1] - series->t[0];
    series->width = series->width > 0 ? 2 * series->width : 4 * all / HISTORY_POINTS;
    size_t to = 0;
    for (size_t from = 0, end; from < series->n; from = end) {
        for (end = from + 1; end < series->n; end++)
            if (span_of(series, series->t[end]) != span_of(series, series->t[from])) break;
        to = keep_extremes(series, from, end, to);
    }
    series->n = to;
    series->thinned++;
}

/* Forget the points at this time and later. */
static void cut(Series *series, double t)
{
    while (series->n && series->t[series->n - 1] >= t) series->n--;
    if (!series->n) series->width = 0;
}

/* The newest is always there; with the next one it has to be an extreme to stay. */
static void append(Series *series, double t, double v)
{
    enum { IN_LAST = 3 };
    cut(series, t);
    const size_t from = last_span(series);
    const bool over = series->n && span_of(series, t) != span_of(series, series->t[series->n - 1]);
    if (series->width > 0 && (over || series->n - from >= IN_LAST))
        series->n = keep_extremes(series, from, series->n, from);
    while (series->n == HISTORY_POINTS) thin(series);
    series->t[series->n] = t;
    series->v[series->n++] = v;
}

void history_add(History *history, double t, size_t n, const MnsValue *values)
{
    for (size_t k = 0; k < n; k++) {
        Series *series = series_of(history, &values[k]);
        if (series) append(series, t, values[k].number);
    }
}

void history_precede(History *history, History *past)
{
    for (size_t k = 0; k < past->n; k++) {
        Series *before = &past->series[k], *after = find(history, before->name);
        if (after) {
            cut(before, after->t[0]);
            for (size_t i = 0; i < after->n; i++) append(before, after->t[i], after->v[i]);
            before->thinned += after->thinned; /* either may have been */
            const Series whole = *before;
            *before = *after;
            *after = whole;
        } else if (history->n < HISTORY_PROBES) {
            history->series[history->n++] = *before;
            *before = (Series){0};
        }
    }
    history->version++;
    history_clear(past);
}

json_t *history_json(const History *history, size_t k)
{
    if (k >= history->n) return json_array();
    const Series *series = &history->series[k];
    json_t *t = json_array(), *v = json_array();
    for (size_t i = 0; i < series->n; i++) {
        json_array_append_new(t, output_number(series->t[i]));
        json_array_append_new(v, output_number(series->v[i]));
    }
    return json_pack("[{ss ss sI so so}]", "name", series->name, "unit", series->unit, "thinned",
                     (json_int_t)series->thinned, "t", t, "v", v);
}
