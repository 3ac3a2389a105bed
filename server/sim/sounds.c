/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/sounds.h"
#include "sim/bodies.h"
#include "sim/state.h"
#include <math.h>
#include <string.h>

/* What the equations of state of the fluids have to carry, fluid by fluid. */
typedef struct Loads {
    double low[MNS_MAX_FLUIDS], high[MNS_MAX_FLUIDS];   /* densities at the start [kg/m^3] */
    double top[MNS_MAX_FLUIDS], bottom[MNS_MAX_FLUIDS]; /* how far along gravity they reach [m] */
    size_t count[MNS_MAX_FLUIDS];                       /* of their particles */
} Loads;

static void find_loads(const MnsSim *sim, double g, Loads *loads)
{
    const Model *model = &sim->model;
    double low[MNS_MAX_FLUIDS], high[MNS_MAX_FLUIDS], top[MNS_MAX_FLUIDS], bottom[MNS_MAX_FLUIDS];
    size_t count[MNS_MAX_FLUIDS] = {0};
    for (size_t k = 0; k < MNS_MAX_FLUIDS; k++) {
        low[k] = top[k] = INFINITY;
        high[k] = bottom[k] = -INFINITY;
    }
#pragma omp parallel for num_threads(sim->threads) reduction(min : low, top) reduction(max : high, bottom) \
    reduction(+ : count)
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        const unsigned k = sim->s.phase[i];
        double depth = 0;
        for (int d = 0; d < model->dim && g > 0; d++) depth += model->gravity[d] / g * sim->s.x[d][i * sim->s.x_step];
        low[k] = fmin(low[k], sim->s.rho[i]);
        high[k] = fmax(high[k], sim->s.rho[i]);
        top[k] = fmin(top[k], depth);
        bottom[k] = fmax(bottom[k], depth);
        count[k]++;
    }
    memcpy(loads->low, low, sizeof low);
    memcpy(loads->high, high, sizeof high);
    memcpy(loads->top, top, sizeof top);
    memcpy(loads->bottom, bottom, sizeof bottom);
    memcpy(loads->count, count, sizeof count);
}

/* The greatest sigma / R that a fluid may come under [Pa], and the R of it [m]. What starts otherwise than as drops and bubbles at
 * rest is thought of as a single one, within whatever there is more of: if it is several, they are smaller. */
static double find_capillary(const MnsSim *sim, size_t k, const Loads *loads, double *R)
{
    *R = sim->drops[k].largest;
    if (*R > 0) return sim->drops[k].capillary;
    double tension = 0;
    for (size_t m = 0; m < sim->model.n_phases; m++)
        if (loads->count[m] > loads->count[k]) tension = fmax(tension, sim->model.tension[k][m]);
    *R = bodies_radius(&sim->model, loads->count[k]);
    return *R > 0 ? tension / *R : 0;
}

/* The speed of sound with which the pressure that now belongs to rho would belong to a density `allowed` times that of reference:
 * at the same density, pressure is as c^2. */
static double speed_for(const Phase *phase, double rho, double allowed)
{
    const double p0 = state_pressure(phase, phase->rho0);
    return phase->c * sqrt((state_pressure(phase, rho) - p0) / (state_pressure(phase, allowed * phase->rho0) - p0));
}

/* Two digits, and no less than it is. */
static double rounded_up(double value)
{
    const double digit = pow(10, floor(log10(value)) - 1);
    return ceil(value / digit * (1 - 1e-12)) * digit;
}

static const double DENSITY_DEVIATION = 0.1; /* at the start, beyond which it is said */

/* The speed of sound must keep a fluid nearly as dense as it is, whatever presses on it: ten times the speeds that weight and
 * surface tension can give it, and more if the pressure of the start asks for that. */
static void warn_sound(MnsSim *sim, size_t k, double g, const Loads *loads)
{
    const Phase *phase = &sim->model.phase[k];
    double R;
    const double capillary = find_capillary(sim, k, loads, &R);
    const bool drops = sim->drops[k].largest > 0;
    const double height = drops ? 2 * R : loads->bottom[k] - loads->top[k] + sim->model.dx;
    const double weight = 10 * sqrt(g * height), tension = 10 * sqrt(capillary / phase->rho0);
    const bool heavy = weight > tension;
    const double most = loads->high[k] / phase->rho0 - 1, least = 1 - loads->low[k] / phase->rho0;
    double enough = fmax(weight, tension);
    if (most > DENSITY_DEVIATION) enough = fmax(enough, speed_for(phase, loads->high[k], 1 + DENSITY_DEVIATION));
    if (least > DENSITY_DEVIATION) enough = fmax(enough, speed_for(phase, loads->low[k], 1 - DENSITY_DEVIATION));
    if (phase->c >= 0.99 * enough) return; /* two digits are as many as people give */
    enough = rounded_up(enough);
    if (fmax(most, least) > DENSITY_DEVIATION)
        plan_warn(sim,
                  "fluids[%zu].sound_speed: with %g m/s the pressure at the start makes %.60s %.0f %% %s than its "
                  "reference; %g m/s would be enough",
                  k, phase->c, sim->c->fluids[k].name, 100 * fmax(most, least), most > least ? "denser" : "thinner",
                  enough);
    else
        plan_warn(
            sim,
            "fluids[%zu].sound_speed: %g m/s is less than ten times sqrt(%s) of %.60s, %g m %s: it may be compressed; "
            "%g m/s would be enough",
            k, phase->c, heavy ? "g H" : "sigma/(rho R)", sim->c->fluids[k].name, heavy ? height : 2 * R,
            heavy && !drops ? "high" : "across", enough);
}

/* The fluid around a drop bears nothing of its tension, but the drop's own swings: it may be as soft as sigma/R, and no softer. Measured: 0.6 of the
 * speed that this gives holds, and what is a fifth of it still does with 1 % of error. */
static void warn_around(MnsSim *sim, size_t k, const Loads *loads)
{
    const Phase *phase = &sim->model.phase[k];
    double enough = 0, across = 0;
    size_t drop = 0;
    for (size_t m = 0; m < sim->model.n_phases; m++) {
        double R;
        if (m == k || loads->count[m] > loads->count[k] || !(sim->model.tension[k][m] > 0)) continue;
        const double c = 0.6 * sqrt(find_capillary(sim, m, loads, &R) / phase->rho0);
        if (!(c > enough)) continue;
        enough = c;
        across = 2 * R;
        drop = m;
    }
    if (phase->c < 0.99 * enough)
        plan_warn(
            sim,
            "fluids[%zu].sound_speed: %g m/s is less than 0.6 times sqrt(sigma/(rho R)) of %.60s around %.60s, %g m "
            "across: it may be torn apart; %g m/s would be enough",
            k, phase->c, sim->c->fluids[k].name, sim->c->fluids[drop].name, across, rounded_up(enough));
}

/* Of a pressure that is more than 0 where there is no density at all: the thinner a particle is, the larger, and the harder it drives others away,
 * without end. */
static void warn_background(MnsSim *sim, size_t k)
{
    const Phase *phase = &sim->model.phase[k];
    const double most = phase->rho0 * phase->c * phase->c / phase->exponent;
    if (!sim->model.tense || phase->background <= most) return;
    plan_warn(
        sim,
        "scheme.%s.background_pressure: %g Pa is more than rho c^2/exponent of %.60s, %g Pa, so that its pressure "
        "does not fall to 0 however thin it gets: particles beside the interface drive each other apart; %g Pa "
        "would be enough",
        sim->scheme->name, phase->background, sim->c->fluids[k].name, most, 0.5 * most);
}

void sounds_look(MnsSim *sim)
{
    Loads loads;
    double g2 = 0;
    for (int d = 0; d < sim->model.dim; d++) g2 += sim->model.gravity[d] * sim->model.gravity[d];
    find_loads(sim, sqrt(g2), &loads);
    for (size_t k = 0; k < sim->model.n_phases; k++) {
        warn_sound(sim, k, sqrt(g2), &loads);
        warn_around(sim, k, &loads);
        warn_background(sim, k);
    }
}
