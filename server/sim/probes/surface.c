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
        const Share share = sample_share(m->sim, x, measure_fluids(m));
        if (share.open < 0.5) continue;
        if (before >= 0.5 && share.fluid < 0.5) found = fallen(last, x[up] - last, before, share.fluid);
        if (found == found && m->probe->least) break;
        before = share.fluid;
        last = x[up];
    }
    return found;
}

/* Coordinate of a particle, larger further out. */
static double outward(const Measure *m, size_t i)
{
    const double x = m->sim->s.x[m->probe->axis][i * m->sim->s.x_step];
    return m->probe->least ? -x : x;
}

static double outward_to_limit(const Measure *m, size_t i)
{
    const double x = outward(m, i);
    return x <= m->limit ? x : -INFINITY;
}

/* Half where the fluid ends, be it at a wall. */
static double inside(const Measure *m, const double x[3])
{
    const Share share = sample_share(m->sim, x, measure_fluids(m));
    return fmin(share.fluid, share.open);
}

/* Where the fluid ends on the way out from a particle, if that is within a kernel's support: else it is not of the surface. Nor
 * is it within the fluid if it is alone. Only those up to twice the support below the limit are asked. */
static double end_of_fluid(const Measure *m, size_t i)
{
    const Model *model = &m->sim->model;
    const int axis = m->probe->axis;
    const double start = outward(m, i), step = 0.25 * model->dx, sign = m->probe->least ? -1 : 1;
    if (!(start <= m->limit && start > m->limit - 2 * model->kernel.support)) return -INFINITY;
    double x[3] = {0, 0, 0};
    for (int d = 0; d < model->dim; d++) x[d] = m->sim->s.x[d][i * m->sim->s.x_step];
    double before = inside(m, x);
    for (int k = 1; before >= 0.5 && (k - 1) * step < model->kernel.support; k++) {
        x[axis] = sign * (start + k * step);
        const double after = inside(m, x);
        if (after < 0.5) return fallen(start + (k - 1) * step, step, before, after);
        before = after;
    }
    return -INFINITY;
}

/* The ends above all particles of the outermost layer, two supports thick, that has any; one that comes of its lower half may
 * be outdone by what is just below. Particles that are alone make layers without. */
double probe_extent(Measure *m)
{
    const double support = m->sim->model.kernel.support;
    double end = NAN;
    m->limit = INFINITY;
    do {
        m->limit = measure_largest(m, outward_to_limit);
        if (m->limit != m->limit) break;
        end = measure_largest(m, end_of_fluid);
        m->limit -= support;
    } while (!(end > m->limit));
    return m->probe->least ? -end : end;
}
