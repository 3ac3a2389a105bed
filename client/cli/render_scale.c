/* SPDX-License-Identifier: BSD-3-Clause */
/* From values to the places on a colour bar: range, unit, label. */
#include "client/cli/render_scale.h"
#include "client/cli/render_ticks.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double percentile(size_t n, double *values, double p)
{
    qsort(values, n, sizeof *values, ascending);
    const double place = p * (double)(n - 1);
    const size_t k = place < (double)(n - 1) ? (size_t)place : n - 1;
    return k + 1 < n ? values[k] + (place - (double)k) * (values[k + 1] - values[k]) : values[k];
}

/* Values of one fluid's particles, or of all for -1. */
static size_t values_in_view(const Frame *frame, const View *view, int fluid, double *values)
{
    size_t n = 0;
    for (size_t k = 0; k < view->n; k++) {
        const size_t i = view->dots[k].particle;
        if (i >= frame->n_fluid || view->dots[k].hidden || !view->dots[k].seen) continue;
        if (fluid < 0 || frame->phase[i] == fluid) values[n++] = frame->value[i];
    }
    return n;
}

/* A few wild particles must not take the colours from all others; but if the tails are short nothing is cut. */
static void robust_range(size_t n, double *values, Scale *s)
{
    const double lo = percentile(n, values, 0.005), hi = percentile(n, values, 0.995);
    const double tail = 0.15 * (hi - lo);
    s->lo = fmin(s->lo, values[0] < lo - tail ? lo : values[0]);
    s->hi = fmax(s->hi, values[n - 1] > hi + tail ? hi : values[n - 1]);
}

/* Each fluid is asked by itself: where there is much air, a percentile of all says little about the water. */
static void robust_range_of_fluids(const Frame *frame, const View *view, double *values, Scale *s)
{
    s->lo = INFINITY;
    s->hi = -INFINITY;
    for (int fluid = 0; fluid < (int)frame->n_fluids; fluid++) {
        const size_t n = values_in_view(frame, view, fluid, values);
        if (n) robust_range(n, values, s);
    }
    if (!(s->lo <= s->hi)) s->lo = s->hi = 0;
}

/* Ends of a bar that are not round by themselves look arbitrary; a fiftieth of the range is not missed. */
static void round_range(Scale *s)
{
    const double unit = ticks_make(s->lo, s->hi, 8).step / 10;
    s->lo = floor(s->lo / unit + 1e-6) * unit;
    s->hi = ceil(s->hi / unit - 1e-6) * unit;
}

static void widen_if_flat(Scale *s)
{
    const double size = fmax(fabs(s->lo), fabs(s->hi));
    if (s->hi - s->lo > 1e-9 * size) return;
    const double by = size > 0 ? 0.05 * size : 1;
    s->lo -= by;
    s->hi += by;
}

static void choose_range(const Frame *frame, const View *view, const double range[2], bool symmetric, Scale *s)
{
    double *values = malloc((view->n + 1) * sizeof *values);
    s->lo = s->hi = 0;
    if (values) robust_range_of_fluids(frame, view, values, s);
    if (symmetric) {
        s->hi = fmax(fabs(s->lo), fabs(s->hi));
        s->lo = -s->hi;
    }
    widen_if_flat(s);
    round_range(s);
    if (range) {
        s->lo = range[0];
        s->hi = range[1];
    }
    const size_t n = values ? values_in_view(frame, view, -1, values) : 0;
    size_t below = 0, above = 0;
    for (size_t k = 0; k < n; k++) {
        below += values[k] < s->lo;
        above += values[k] > s->hi;
    }
    s->below = below > 0;
    s->above = above > 0;
    s->beyond = n ? (double)(below + above) / (double)n : 0;
    free(values);
}

/* "1" is no unit to print, "m^dim" is an area or a volume, and thousands of pascals are read more easily as kPa. */
static void choose_unit(const Frame *frame, Scale *s)
{
    const double size = fmax(fabs(s->lo), fabs(s->hi));
    s->factor = 1;
    if (!strcmp(frame->unit, "m^dim")) {
        unit_print(frame->dim == 2 ? "m^2" : "m^3", sizeof s->unit, s->unit);
    } else if (!strcmp(frame->unit, "Pa") && size >= 1e3) {
        s->factor = size < 1e6 ? 1e-3 : 1e-6;
        snprintf(s->unit, sizeof s->unit, size < 1e6 ? "kPa" : "MPa");
    } else if (strcmp(frame->unit, "1") != 0) {
        unit_print(frame->unit, sizeof s->unit, s->unit);
    }
}

static void choose_name(const Frame *frame, Scale *s)
{
    snprintf(s->name, sizeof s->name, "%s%s", frame->field, frame->is_magnitude ? " magnitude" : "");
    s->name[0] = (char)toupper((unsigned char)s->name[0]);
    for (char *c = s->name; *c; c++)
        if (*c == '_') *c = ' ';
}

Scale scale_make(const Frame *frame, const View *view, const double range[2], bool symmetric)
{
    Scale s = {0};
    choose_range(frame, view, range, symmetric, &s);
    choose_unit(frame, &s);
    choose_name(frame, &s);
    return s;
}
