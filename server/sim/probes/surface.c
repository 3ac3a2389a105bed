/* SPDX-License-Identifier: BSD-3-Clause */
/* Probes that find where fluids end, to a part of a spacing: where the share is a half, between samples a quarter of a spacing
 * apart. */
#include "sim/probes/probes.h"
#include <math.h>

/* Where along a line a number falls below a half that is `before` at x and `after` a step further. */
static double fallen(double x, double step, double before, double after)
{
    return x + step * (before - 0.5) / (before - after);
}

/* From below, where fluids come to their end. Within walls there is nothing to see, so what was before them is kept. */
double probe_elevation(Measure *m)
{
    const Model *model = &m->sim->model;
    const int up = m->probe->axis;
    const double low = model->min[up] + measure_shift(m, up), length = model->max[up] - model->min[up];
    const int n = (int)ceil(4 * length / model->dx);
    double x[3] = {0, 0, 0}, found = NAN, before = 0, last = low;
    for (int d = 0; d < model->dim; d++) x[d] = m->probe->at[d] + measure_shift(m, d);
    for (int k = 0; k <= n; k++) {
        x[up] = low + k * length / n;
        const Share share = sample_share_along(m->sim, up, x, measure_fluids(m));
        if (share.solid) continue;
        if (before >= 0.5 && share.fluid < 0.5) found = fallen(last, x[up] - last, before, share.fluid);
        if (found == found && m->probe->least) break;
        before = share.fluid;
        last = x[up];
    }
    return found;
}

static double outward_to_limit(const Measure *m, size_t i)
{
    const double x = measure_outward(m, i);
    return x < m->limit ? x : -INFINITY;
}

/* Half where the fluid ends, be it at a wall: of what is near, of a kernel more is in walls in a corner. */
static double inside(const Measure *m, const double x[3])
{
    const Share share = sample_share(m->sim, x, measure_fluids(m));
    return fmin(share.fluid, share.beside);
}

/* How far out from a particle its fluid may end: a step beyond the support. */
static double end_reach(const Model *model)
{
    return model->kernel.support + 0.25 * model->dx;
}

/* Where the fluid ends on the way out from a particle, if that is within a kernel's support: else it is not of the surface. Nor
 * is it within the fluid if it is alone. Only those of the layer are asked, and of them only whose fluid may end farther out than
 * one is known to: most are done with a look at that height. */
static double end_of_fluid(const Measure *m, size_t i)
{
    const Model *model = &m->sim->model;
    const int axis = m->probe->axis;
    const double start = measure_outward(m, i), step = 0.25 * model->dx, sign = m->probe->least ? -1 : 1;
    if (!(start < m->limit && start >= m->layer && start + end_reach(model) > m->known)) return -INFINITY;
    double x[3] = {0, 0, 0};
    for (int d = 0; d < model->dim; d++) x[d] = m->sim->s.x[d][i * m->sim->s.x_step];
    if (m->known - start >= step) {
        x[axis] = sign * (start + floor((m->known - start) / step) * step);
        if (inside(m, x) < 0.5) return -INFINITY;
        x[axis] = sign * start;
    }
    double before = inside(m, x);
    for (int k = 1; before >= 0.5 && (k - 1) * step < model->kernel.support; k++) {
        x[axis] = sign * (start + k * step);
        const double after = inside(m, x);
        if (after < 0.5) return fallen(start + (k - 1) * step, step, before, after);
        before = after;
    }
    return -INFINITY;
}

static double at_upper_side(const Measure *m, size_t i)
{
    return m->sim->s.x[m->probe->axis][i * m->sim->s.x_step];
}

static double at_lower_side(const Measure *m, size_t i)
{
    return -m->sim->s.x[m->probe->axis][i * m->sim->s.x_step];
}

/* Whether the fluid reaches across the periodic side along the axis, so that particles on both sides of it are neighbours. */
static bool goes_round(Measure *m)
{
    const Model *model = &m->sim->model;
    const int axis = m->probe->axis;
    if (model->period[axis] == 0) return false;
    const double within = measure_largest(m, at_upper_side) + measure_largest(m, at_lower_side);
    return model->period[axis] - within < 1.5 * model->dx;
}

/* The ends above all particles, layer by layer from the outermost, a spacing thick, until none that is left can be farther out.
 * Particles that are alone make layers without. */
double probe_extent(Measure *m)
{
    const Model *model = &m->sim->model;
    if (goes_round(m)) return NAN;
    m->limit = INFINITY;
    m->known = -INFINITY;
    for (;;) {
        const double outermost = measure_largest(m, outward_to_limit);
        if (!(outermost + end_reach(model) > m->known)) break; /* NAN: there is no particle left */
        m->layer = outermost - model->dx;
        m->known = fmax(m->known, measure_largest(m, end_of_fluid));
        m->limit = m->layer;
    }
    const double end = m->known > -INFINITY ? m->known : NAN;
    return m->probe->least ? -end : end;
}
