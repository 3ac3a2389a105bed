/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/gravity.h"
#include <math.h>

/* Of a mean, between which it is told whether they are enough: a pulse between two of the fewest goes unseen. */
enum { FEWEST = 16, MOST = 2048 };
static const double ENOUGH = 1e-5; /* that a mean of half as many may be off, over how far gravity departs */
static const double LEAP = 0.25;   /* from one to the next, as well: where it leaps two means may agree by chance */
static const double SMALL = 1e-6;  /* a departure, over what it departs from: rounding would have to settle it */
enum { LOOKS = 32 };               /* ahead */

/* Where a step is told to look: two points in each part of it, by which a cubic has its own mean. */
static double moment(double from, double to, size_t k, size_t n)
{
    static const double OFF = 0.28867513459481287; /* 1/(2 sqrt(3)), of a part's length from its middle */
    const size_t part = k / 2;
    const double parts = 0.5 * (double)n, middle = (double)part + 0.5;
    return from + (to - from) * ((k % 2 ? middle + OFF : middle - OFF) / parts);
}

/* How far gravity gets from what it is first, and from one look to the next. */
typedef struct Departure {
    double most, leap;
} Departure;

/* By how it departs from what it is first, so that one that does not depart has no rounding. */
static double mean_of(const Formula *gravity, double from, double to, size_t n, Departure *ret)
{
    double first = 0, last = 0, sum = 0;
    *ret = (Departure){0, 0};
    for (size_t k = 0; k < n; k++) {
        const double t = moment(from, to, k, n), value = formula_eval(gravity, &t);
        if (!isfinite(value)) return NAN;
        if (k == 0) first = last = value;
        sum += value - first;
        ret->most = fmax(ret->most, fabs(value - first));
        ret->leap = fmax(ret->leap, fabs(value - last));
        last = value;
    }
    return first + sum / (double)n;
}

static double mean(const Formula *gravity, double from, double to)
{
    if (formula_is_constant(gravity) || !(to > from)) return formula_eval(gravity, &to);
    Departure departure;
    double coarse = mean_of(gravity, from, to, FEWEST, &departure);
    for (size_t n = 2 * (size_t)FEWEST; n <= MOST; n *= 2) {
        const double fine = mean_of(gravity, from, to, n, &departure);
        if (departure.most <= SMALL * fabs(fine)) return fine;
        const bool agree = !(fabs(fine - coarse) > ENOUGH * departure.most);
        if (agree && departure.leap <= LEAP * departure.most) return fine;
        coarse = fine;
    }
    return coarse;
}

/* The three who ask about a step ask about the same one. */
void gravity_mean(MnsSim *sim, double from, double to, double ret[3])
{
    PullMean *last = &sim->pull;
    if (!last->known || last->from != from || last->to != to) {
        *last = (PullMean){.known = true, .from = from, .to = to};
        for (int d = 0; d < sim->model.dim; d++) last->of[d] = mean(sim->gravity[d], from, to);
    }
    for (int d = 0; d < 3; d++) ret[d] = last->of[d];
}

bool gravity_failure(MnsSim *sim, double from, double to, int *ret_direction, double *ret_time)
{
    double means[3];
    gravity_mean(sim, from, to, means);
    for (int d = 0; d < sim->model.dim; d++) {
        const Formula *gravity = sim->gravity[d];
        *ret_direction = d;
        *ret_time = to;
        if (!isfinite(formula_eval(gravity, &to))) return true;
        for (size_t n = FEWEST; n <= MOST && !isfinite(means[d]); n *= 2)
            for (size_t k = 0; k < n; k++) {
                *ret_time = moment(from, to, k, n);
                if (!isfinite(formula_eval(gravity, ret_time))) return true;
            }
        if (!isfinite(means[d])) return true;
    }
    return false;
}

double gravity_change(const MnsSim *sim, double t, double ahead)
{
    double before[3] = {0}, most2 = 0;
    bool changes = false;
    for (int d = 0; d < sim->model.dim; d++) changes = changes || !formula_is_constant(sim->gravity[d]);
    if (!changes) return 0;
    for (int k = 0; k <= LOOKS; k++) {
        const double then = t + ahead * k / LOOKS;
        double change2 = 0;
        for (int d = 0; d < sim->model.dim; d++) {
            const double now = formula_eval(sim->gravity[d], &then), change = k > 0 ? now - before[d] : 0;
            change2 += change * change;
            before[d] = now;
        }
        if (change2 > most2 && isfinite(change2)) most2 = change2;
    }
    return sqrt(most2) * LOOKS / ahead;
}

void gravity_forget(MnsSim *sim)
{
    sim->pull.known = false;
}
