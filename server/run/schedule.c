/* SPDX-License-Identifier: BSD-3-Clause */
/* When an output is due. */
#include "run/schedule.h"

#include <math.h>

static const double FLUSH_INTERVAL = 10, FOLLOWED_INTERVAL = 1, FLUSH_SHARE = 0.05;
static const double CHECKPOINT_SHARE = 0.01, RARER = 10;

/* Largest k with k * interval <= t, but for rounding: 0.3, as people write it, is less than 3 * 0.1, and counts as there. */
static double ticks(double interval, double t)
{
    const double reached = t * (1 + 1e-12);
    double k = floor(reached / interval);
    if (!(k < 1e15)) return k;          /* beyond, k + 1 is no other number */
    while (k * interval > reached) k--; /* the quotient may round across an integer too */
    while ((k + 1) * interval <= reached) k++;
    return k;
}

bool schedule_due(double interval, double before, double t)
{
    if (!(interval > 0)) return false;
    if (before < 0 || t - before >= interval) return true;
    return ticks(interval, t) > ticks(interval, before);
}

double schedule_flush(double seconds, bool followed)
{
    return fmax(followed ? FOLLOWED_INTERVAL : FLUSH_INTERVAL, seconds / FLUSH_SHARE);
}

double schedule_checkpoint(double interval, double seconds)
{
    return fmin(fmax(interval, seconds / CHECKPOINT_SHARE), RARER * interval);
}
