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
}

void history_clear(History *history)
{
    for (size_t k = 0; k < history->n; k++) {
        free(history->series[k].t);
        free(history->series[k].v);
    }
    history->n = 0;
}

/* The series of that name, a new one if need be; NULL if there is no room. */
static Series *series_of(History *history, const MnsValue *value)
{
    for (size_t k = 0; k < history->n; k++)
        if (!strcmp(history->series[k].name, value->name)) return &history->series[k];
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

/* Of each four points in a row the lowest and the highest, in their order: the line keeps its peaks, and no point is made up. */
static void thin(Series *series)
{
    size_t to = 0;
    for (size_t from = 0; from < series->n; from += 4) {
        const size_t end = from + 4 < series->n ? from + 4 : series->n;
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
    }
    series->n = to;
    series->thinned++;
}

void history_add(History *history, double t, size_t n, const MnsValue *values)
{
    for (size_t k = 0; k < n; k++) {
        Series *series = series_of(history, &values[k]);
        if (!series) continue;
        while (series->n && series->t[series->n - 1] >= t) series->n--;
        if (series->n == HISTORY_POINTS) thin(series);
        series->t[series->n] = t;
        series->v[series->n++] = values[k].number;
    }
}

json_t *history_json(const History *history)
{
    json_t *list = json_array();
    for (size_t k = 0; k < history->n; k++) {
        const Series *series = &history->series[k];
        json_t *t = json_array(), *v = json_array();
        for (size_t i = 0; i < series->n; i++) {
            json_array_append_new(t, output_number(series->t[i]));
            json_array_append_new(v, output_number(series->v[i]));
        }
        json_array_append_new(list, json_pack("{ss ss sI so so}", "name", series->name, "unit", series->unit, "thinned",
                                              (json_int_t)series->thinned, "t", t, "v", v));
    }
    return list;
}
