/* SPDX-License-Identifier: BSD-3-Clause */
/* Bounds of a number of the case. proto/schema.py makes BOUNDS_Scheme_cfl and the like of what case.proto says. */
#ifndef SIM_BOUNDS_H
#define SIM_BOUNDS_H

#include <stdbool.h>

typedef struct Bounds {
    double min, max;
    bool min_open, max_open; /* whether the bound itself is refused */
    const char *words;       /* "(0, inf) kg/m^3" */
} Bounds;

/* Never of NaN. */
static inline bool bounds_hold(Bounds bounds, double value)
{
    const bool above = bounds.min_open ? value > bounds.min : value >= bounds.min;
    const bool below = bounds.max_open ? value < bounds.max : value <= bounds.max;
    return above && below;
}

#endif
