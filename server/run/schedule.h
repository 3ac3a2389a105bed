/* SPDX-License-Identifier: BSD-3-Clause */
/* When an output is due: at the first step boundary at or after k times its interval, k counted from 0. Nothing is
 * remembered but the time of the boundary before, so a restart shifts nothing. */
#ifndef RUN_SCHEDULE_H
#define RUN_SCHEDULE_H

#include <stdbool.h>

/* Is it due at the boundary at time t?
 *  interval  [s]; 0: never
 *  before    time of the boundary before [s]; -INFINITY at the first of a run */
bool schedule_due(double interval, double before, double t);

/* How long to wait at least [s] before something is written whole again that took so many seconds the last time: a growing file
 * then takes 5 % of its writer's time at most, however long the run. followed: somebody waits for what is new in it. */
double schedule_flush(double seconds, bool followed);

/* How long to wait at least [s] before a checkpoint by the clock, of this interval, where the last one took so many seconds: they take 1 % of the time at
 * most, unless that would make them ten times rarer. */
double schedule_checkpoint(double interval, double seconds);

#endif
