/* SPDX-License-Identifier: BSD-3-Clause */
/* When an item of a stream is due. */
#include "run/due.h"

#include "run/schedule.h"
#include <math.h>

DueState due_begin(void)
{
    return (DueState){.begun = false, .last = -INFINITY};
}

bool due_now(const When *when, DueState *state, uint64_t step, double t, double dt, double wall)
{
    const double before = state->begun && state->before <= t ? state->before : t - dt;
    state->begun = true;
    state->before = t;
    if (when->every_steps && step % when->every_steps) return false;
    if (when->interval > 0 && !schedule_due(when->interval, before, t)) return false;
    if (wall < state->last + when->gap) return false;
    state->last = wall;
    return true;
}
