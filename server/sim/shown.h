/* SPDX-License-Identifier: BSD-3-Clause */
/* Fields as they are shown: those that are stored, and those that are made where they are asked for (MADE_FIELDS). */
#ifndef SIM_SHOWN_H
#define SIM_SHOWN_H

#include "sim/sim.h"

/* All that there are. */
Fields shown_fields(const MnsSim *sim);

/* Component d of a field, [n] values until it is asked for again or the next step; NULL where there is none, or no memory to make it. */
const void *shown_field(const MnsSim *sim, int field, int d);

/* The same, without a copy of what is in a bundle: value i is first[i * step]. first: NULL where shown_field() is. */
typedef struct ShownView {
    const void *first;
    size_t step;
} ShownView;
ShownView shown_view(const MnsSim *sim, int field, int d);

/* Number i of a view of doubles. */
static inline double shown_number(const ShownView *view, size_t i)
{
    return ((const double *)view->first)[i * view->step];
}

/* Those that are not stored one number after the other. Make component d of one of these. out: [n] */
Fields shown_made(const MnsSim *sim);
void shown_make(const MnsSim *sim, int field, int d, double *out);

#endif
