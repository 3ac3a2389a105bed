/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/sounds.h"
#include "sim/state.h"
#include <math.h>
#include <stdio.h>

/* Why a fluid needs a greater speed of sound. */
typedef enum Cause { NOTHING_ASKS, PRESSED, WEIGHT, TENSION, AROUND } Cause;

/* What a fluid's sound must be, and why. */
typedef struct Need {
    Cause cause;
    double enough;      /* by the rules for the fluid itself [m/s] */
    double advised;     /* and with the others' beside it */
    double length, off; /* height, or diameter of a drop [m]; densities at the start, relative */
    bool bound;         /* of length: it may be larger */
    size_t drop;        /* that it is around */
} Need;

/* Of the densities of a fluid. */
typedef struct Range {
    double low, high; /* [kg/m^3] */
} Range;

static void find_ranges(const MnsSim *sim, Range range[])
{
    double low[MNS_MAX_FLUIDS], high[MNS_MAX_FLUIDS];
    for (size_t k = 0; k < MNS_MAX_FLUIDS; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
    }
#pragma omp parallel for num_threads(sim->threads) reduction(min : low) reduction(max : high)
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        const unsigned k = sim->s.phase[i];
        low[k] = fmin(low[k], sim->s.rho[i]);
        high[k] = fmax(high[k], sim->s.rho[i]);
    }
    for (size_t k = 0; k < MNS_MAX_FLUIDS; k++) range[k] = (Range){low[k], high[k]};
}

/* Densities are those of the start. */
static bool begins(const MnsSim *sim)
{
    return !sim->resumed && sim->progress.step == 0;
}

static double strength(const Model *model)
{
    double g2 = 0;
    for (int d = 0; d < model->dim; d++) g2 += model->gravity[d] * model->gravity[d];
    return sqrt(g2);
}

/* Along gravity: of a drop its own, as it does not bear others. */
static double height_of(const MnsSim *sim, size_t k, double g)
{
    const FluidStart *start = &sim->start[k];
    double along = 0;
    for (int d = 0; d < sim->model.dim && g > 0; d++)
        along += fabs(sim->model.gravity[d]) / g * (start->max[d] - start->min[d]);
    along += sim->model.dx;
    return start->drops ? fmin(along, start->across) : along;
}

/* The speed of sound with which the pressure that now belongs to rho would belong to a density `allowed` times that of reference:
 * at the same density, pressure is as c^2. */
static double speed_for(const Phase *phase, double rho, double allowed)
{
    const double p0 = state_pressure(phase, phase->rho0);
    return phase->c * sqrt((state_pressure(phase, rho) - p0) / (state_pressure(phase, allowed * phase->rho0) - p0));
}

/* Two digits, and no less than it is; or no more. */
static double rounded(double value, double (*towards)(double), double slack)
{
    const double digit = pow(10, floor(log10(value)) - 1);
    return towards(value / digit * (1 + slack)) * digit;
}

static double rounded_up(double value)
{
    return rounded(value, ceil, -1e-12);
}

static double rounded_down(double value)
{
    return rounded(value, floor, 1e-12);
}

static const double DENSITY_DEVIATION = 0.1; /* at the start, beyond which it is said */

static void ask(Need *need, Cause cause, double enough, double length)
{
    if (!(enough > need->enough)) return;
    need->cause = cause;
    need->enough = enough;
    need->length = length;
    need->bound = false;
}

/* The speed of sound must keep a fluid nearly as dense as it is, whatever presses on it: ten times the speeds that weight and
 * surface tension can give it, and more if the pressure of the start asks for that. */
static void ask_for_load(const MnsSim *sim, size_t k, double g, Range range, Need *need)
{
    const Phase *phase = &sim->model.phase[k];
    const Curved *most = &sim->start[k].most;
    const double height = height_of(sim, k, g);
    ask(need, WEIGHT, 10 * sqrt(g * height), height);
    ask(need, TENSION, 10 * sqrt(most->capillary / phase->rho0), most->across);
    if (need->cause == TENSION) need->bound = most->bound;
    const double denser = range.high / phase->rho0 - 1, thinner = 1 - range.low / phase->rho0;
    if (fmax(denser, thinner) <= DENSITY_DEVIATION || !begins(sim)) return;
    const double loaded = need->enough;
    if (denser > DENSITY_DEVIATION) ask(need, PRESSED, speed_for(phase, range.high, 1 + DENSITY_DEVIATION), 0);
    if (thinner > DENSITY_DEVIATION) ask(need, PRESSED, speed_for(phase, range.low, 1 - DENSITY_DEVIATION), 0);
    need->enough = fmax(need->enough, loaded);
    need->cause = PRESSED;
    need->off = denser > thinner ? denser : -thinner;
}

/* The fluid around a drop bears nothing of its tension, but the drop's own swings: it may be as soft as sigma/R, and no softer. Measured: 0.6 of the
 * speed that this gives holds, and what is a fifth of it still does with 1 % of error. */
static void ask_around(const MnsSim *sim, size_t k, Need *need)
{
    for (size_t m = 0; m < sim->model.n_phases; m++) {
        const Curved *drop = &sim->start[m].in[k];
        const double enough = 0.6 * sqrt(drop->capillary / sim->model.phase[k].rho0);
        if (!(enough > need->enough)) continue;
        ask(need, AROUND, enough, drop->across);
        need->bound = drop->bound;
        need->drop = m;
    }
}

/* Two digits are as many as people give. */
static bool is_short(const MnsSim *sim, size_t k, const Need *need)
{
    return sim->model.phase[k].c < 0.99 * need->enough;
}

/* Raise what is advised until the scheme holds all of it together, which equal sounds do. */
static void fit_together(const MnsSim *sim, Need needs[])
{
    const MnsCase *c = sim->c;
    bool raised = sim->scheme->bound_sound;
    while (raised) {
        raised = false;
        for (size_t a = 0; a < c->n_fluids; a++)
            for (size_t b = 0; b < c->n_fluids; b++) {
                if (a == b || c->fluids[a].density > c->fluids[b].density) continue;
                double low, high;
                sim->scheme->bound_sound(c, a, b, &low, &high);
                const double light = low * needs[b].advised, heavy = needs[a].advised / high;
                if (needs[b].advised < heavy * (1 - 1e-9)) {
                    needs[b].advised = rounded_up(heavy);
                    raised = true;
                } else if (needs[a].advised < light * (1 - 1e-9)) {
                    needs[a].advised = rounded_up(light);
                    raised = true;
                }
            }
    }
}

/* Where sounds depend on each other: what those of others have to be. */
static const char *with_others(const MnsSim *sim, size_t k, const Need needs[], size_t size, char text[])
{
    size_t used = 0;
    text[0] = 0;
    for (size_t m = 0; m < sim->model.n_phases && used < size && sim->scheme->bound_sound; m++)
        if (m != k && needs[m].advised > sim->model.phase[m].c)
            used += (size_t)snprintf(text + used, size - used, "%s fluids[%zu].sound_speed of %g m/s",
                                     used ? " and" : ", together with", m, needs[m].advised);
    if (text[0] && used < size) snprintf(text + used, size - used, ", by what the scheme %s holds", sim->scheme->name);
    return text;
}

static const char *bound_of(const Need *need)
{
    return need->bound ? " at most, as it lies on a wall that is not flat" : "";
}

static void warn_sound(MnsSim *sim, size_t k, const Need needs[])
{
    const Need *need = &needs[k];
    const char *name = sim->c->fluids[k].name;
    const double c = sim->model.phase[k].c, advised = need->advised;
    char others[200];
    with_others(sim, k, needs, sizeof others, others);
    if (need->cause == PRESSED)
        plan_warn(sim,
                  "fluids[%zu].sound_speed: with %g m/s the pressure at the start makes %.60s %.0f %% %s than its "
                  "reference; %g m/s would be enough%s",
                  k, c, name, 100 * fabs(need->off), need->off > 0 ? "denser" : "thinner", advised, others);
    else if (need->cause == AROUND)
        plan_warn(
            sim,
            "fluids[%zu].sound_speed: %g m/s is less than 0.6 times sqrt(sigma/(rho R)) of %.60s around %.60s, %.3g m "
            "across: it may be torn apart; %g m/s would be enough%s%s",
            k, c, name, sim->c->fluids[need->drop].name, need->length, advised, bound_of(need), others);
    else
        plan_warn(sim,
                  "fluids[%zu].sound_speed: %g m/s is less than ten times sqrt(%s) of %.60s, %.3g m %s: it may be "
                  "compressed; "
                  "%g m/s would be enough%s%s",
                  k, c, need->cause == WEIGHT ? "g H" : "sigma/(rho R)", name, need->length,
                  need->cause == WEIGHT ? "high" : "across", advised, bound_of(need), others);
}

/* A run that is steered on and on is not warned each time of a little more. */
static const double NOT_AGAIN = 1.1;

static void warn_sounds(MnsSim *sim, const Need needs[])
{
    for (size_t k = 0; k < sim->model.n_phases; k++) {
        if (!is_short(sim, k, &needs[k]) || needs[k].advised <= NOT_AGAIN * sim->advised.sound[k]) continue;
        warn_sound(sim, k, needs);
        sim->advised.sound[k] = needs[k].advised;
    }
}

/* Half of the pressure that the softest fluid takes: at rho c^2/exponent its pressure does not fall to 0 however thin it gets. */
static const double ADVISED = 0.5, FAR_TOO_LITTLE = 0.1; /* the latter of the former */

/* By the sounds that are advised, so that it holds when these are set. */
static double stiffness(const MnsSim *sim, size_t k, const Need needs[])
{
    const Phase *phase = &sim->model.phase[k];
    return phase->rho0 * needs[k].advised * needs[k].advised / phase->exponent;
}

/* What presses on a fluid everywhere, besides the background: of a bubble, its depth. */
static double least_pressure(const Phase *phase, Range range)
{
    return fmax(0, state_pressure(phase, range.low) - phase->background);
}

static void warn_background(MnsSim *sim, const Need needs[], const Range range[])
{
    size_t softest = 0;
    if (!sim->model.tense || !sim->scheme->takes_background) return;
    for (size_t k = 1; k < sim->model.n_phases; k++)
        if (stiffness(sim, k, needs) < stiffness(sim, softest, needs)) softest = k;
    const Phase *phase = &sim->model.phase[softest];
    const double most = stiffness(sim, softest, needs), half = ADVISED * most;
    const char *scheme = sim->scheme->name, *name = sim->c->fluids[softest].name;
    if (phase->background > most)
        plan_warn(
            sim,
            "scheme.%s.background_pressure: %g Pa is more than rho c^2/exponent of %.60s, %.4g Pa, so that its "
            "pressure does not fall to 0 however thin it gets: particles beside the interface drive each other apart; "
            "%g Pa would be enough",
            scheme, phase->background, name, most, rounded_down(half));
    else if (sim->scheme->needs_background &&
             phase->background + least_pressure(phase, range[softest]) < FAR_TOO_LITTLE * half)
        plan_warn(sim,
                  "scheme.%s.background_pressure: %g Pa leaves %.60s, the softest fluid, less than a tenth of rho "
                  "c^2/(2 exponent), %.4g Pa, as nothing else presses on it: its pressure swings below 0, and drops at "
                  "rest make energy; %g Pa would be enough",
                  scheme, phase->background, name, half, rounded_down(half));
}

void sounds_look(MnsSim *sim)
{
    Range range[MNS_MAX_FLUIDS];
    Need needs[MNS_MAX_FLUIDS] = {0};
    const double g = strength(&sim->model);
    if (sim->scheme->projects) return;
    find_ranges(sim, range);
    for (size_t k = 0; k < sim->model.n_phases; k++) {
        ask_for_load(sim, k, g, range[k], &needs[k]);
        ask_around(sim, k, &needs[k]);
        needs[k].advised = is_short(sim, k, &needs[k]) ? rounded_up(needs[k].enough) : sim->model.phase[k].c;
    }
    fit_together(sim, needs);
    warn_sounds(sim, needs);
    warn_background(sim, needs, range);
}
