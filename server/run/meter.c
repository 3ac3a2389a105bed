/* SPDX-License-Identifier: BSD-3-Clause */
/* How fast a run goes. */
#include "run/meter.h"

#include <math.h>

/* Rates are measured over half a second, and half of each new one counts: the last few seconds decide. */
static const double STRETCH = 0.5, WEIGHT = 0.5;

static void mark(Meter *meter, MnsProgress progress, double now)
{
    meter->mark = now;
    meter->mark_t = progress.t;
    meter->mark_step = progress.step;
}

void meter_begin(Meter *meter, MnsProgress progress, double now)
{
    mark(meter, progress, now);
    if (!meter->moving) meter->since = now;
    meter->moving = true;
}

void meter_halt(Meter *meter, double now)
{
    meter->ran = meter_ran(meter, now);
    meter->moving = false;
}

double meter_ran(const Meter *meter, double now)
{
    return meter->ran + (meter->moving ? now - meter->since : 0);
}

static void take_rates(Meter *meter, MnsProgress progress, double passed, double weight)
{
    const double steps = (double)(progress.step - meter->mark_step) / passed,
                 time = (progress.t - meter->mark_t) / passed;
    meter->steps_rate = (1 - weight) * meter->steps_rate + weight * steps;
    meter->time_rate = (1 - weight) * meter->time_rate + weight * time;
}

void meter_step(Meter *meter, MnsProgress progress, size_t particles, double seconds, double now)
{
    meter->stepping += seconds;
    meter->steps++;
    meter->particle_steps += (double)particles;
    const double passed = now - meter->mark;
    if (!meter->measured && passed > 0) take_rates(meter, progress, passed, 1); /* better than nothing to say */
    else if (passed >= STRETCH) take_rates(meter, progress, passed, WEIGHT);
    if (passed < STRETCH) return;
    meter->measured = true;
    mark(meter, progress, now);
}

double meter_rate(const Meter *meter)
{
    return meter->steps_rate > 0 ? meter->steps_rate : NAN;
}

double meter_eta(const Meter *meter, double t, double end)
{
    return meter->time_rate > 0 ? fmax(end - t, 0) / meter->time_rate : NAN;
}

double meter_ns(const Meter *meter)
{
    return meter->particle_steps > 0 ? 1e9 * meter->stepping / meter->particle_steps : NAN;
}
