/* SPDX-License-Identifier: BSD-3-Clause */
/* The past of the probes, for browsers that come later and for runs of any length: a bounded number of points for each, evenly over all of
 * its time, in which the extremes survive. */
#ifndef DASHBOARD_HISTORY_H
#define DASHBOARD_HISTORY_H

#include "common/case/name.h"
#include <jansson.h>
#include <meniscus/client.h>

enum { HISTORY_PROBES = 256, HISTORY_POINTS = 4000 };

typedef struct Series {
    char name[CASE_NAME_SIZE], unit[32];
    size_t n;         /* points */
    uint64_t thinned; /* how often half of them were given up */
    double width;     /* [s] of the spans of time of which two each are kept; 0: all are */
    double *t, *v;    /* [HISTORY_POINTS] */
} Series;

typedef struct History {
    size_t n;
    uint64_t version; /* another after each change that is not a sample more */
    Series series[HISTORY_PROBES];
} History;

void history_init(History *history);

/* Forget all, as when another case is loaded. */
void history_clear(History *history);

/* Take a sample over. Points at this time and later are of a time line that was left, and go. What there is no memory for is left out. */
void history_add(History *history, double t, size_t n, const MnsValue *values);

/* Put before each series what `past` has of it from before its first point, and take over what else is in there. */
void history_precede(History *history, History *past);

/* [{"name", "unit", "thinned", "t": [...], "v": [...]}] for series k, [] if there is none; a value without a number is null. */
json_t *history_json(const History *history, size_t k);

#endif
