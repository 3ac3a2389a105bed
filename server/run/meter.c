/* SPDX-License-Identifier: BSD-3-Clause */
/* How fast a run goes. */
#include "run/meter.h"

#include <math.h>

/* Rates are measured over half a second, and half of each new one counts: the last few seconds decide. */
static const double STRETCH = 0.5, WEIGHT = 0.5;

void meter_begin(Meter *meter, MnsProgress progress, double now)
{
    meter->mark = now;
    meter->mark_t = progress.t;
    meter->mark_step = progress.step;
}

static double blend(double old, double new)
{
    return old > 0 ? (1 - WEIGHT) * old + WEIGHT * new : new;
}

void meter_step(Meter *meter, MnsProgress progress, size_t particles, double seconds, double now)
{
    meter->stepping += seconds;
    meter->particle_steps += (double)particles;
    const double passed = now - meter->mark;
    if (passed < STRETCH) return;
    meter->steps_rate = blend(meter->steps_rate, (double)(progress.step - meter->mark_step) / passed);
    meter->time_rate = blend(meter->time_rate, (progress.t - meter->mark_t) / passed);
    meter_begin(meter, progress, now);
}

double meter_eta(const Meter *meter, double t, double end)
{
    return meter->time_rate > 0 ? fmax(end - t, 0) / meter->time_rate : NAN;
}

double meter_ns(const Meter *meter)
{
    return meter->particle_steps > 0 ? 1e9 * meter->stepping / meter->particle_steps : NAN;
}
