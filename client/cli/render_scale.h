/* SPDX-License-Identifier: BSD-3-Clause */
/* From values to the places on a colour bar: range, unit, label. */
#ifndef CLI_RENDER_SCALE_H
#define CLI_RENDER_SCALE_H

#include "client/cli/render_view.h"

typedef struct Scale {
    double lo, hi;           /* ends of the bar, in the field's own unit; lo < hi */
    bool below, above;       /* values lie beyond the ends */
    double beyond;           /* share of the particles seen whose values do */
    double factor;           /* what the labels show is value * factor */
    char name[96], unit[40]; /* "Pressure", "kPa" */
} Scale;

/* range: lo, hi as the user wants them, or NULL: from 0.5th to 99.5th percentile of the values of each fluid's particles
 * that are seen, or all of them if that is hardly more. symmetric: the middle of the bar is to be zero. */
Scale scale_make(const Frame *frame, const View *view, const double range[2], bool symmetric);

/* The p-th part (0 to 1) of n > 0 numbers is at most this; reorders them. */
double percentile(size_t n, double *values, double p);

#endif
