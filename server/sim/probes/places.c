/* SPDX-License-Identifier: BSD-3-Clause */
/* Probes that look at places: averages by the kernel at points that are no particles. */
#include "sim/probes/probes.h"
#include "sim/sample.h"
#include "sim/solid.h"
#include <math.h>

double probe_pressure(Measure *m)
{
    const MnsSim *sim = m->sim;
    double x[3] = {0, 0, 0};
    const ShownView p = shown_view(sim, F_P, 0);
    for (int d = 0; d < sim->s.dim; d++) x[d] = m->probe->at[d] + measure_shift(m, d);
    const PointSums sums = sample_point(sim, x, m->probe->radius, EVERY_FLUID, &p, 1);
    return sums.fluid > NOTHING_NEAR ? sums.value / sums.fluid : NAN;
}

/* Is there fluid at a point? Beyond a free surface, where less than half of what is no wall is filled, there is nothing, nor within walls. */
static bool is_filled(const Share *share)
{
    return !share->solid && share->filled >= 0.5;
}

/* What the surface between two samples adds to the depth, over a step, where it is not midway. */
static double beyond_midway(const Share *before, const Share *after)
{
    if (before->solid || after->solid || is_filled(before) == is_filled(after)) return 0;
    const double at = (before->filled - 0.5) / (before->filled - after->filled);
    return is_filled(before) ? (at - 0.5) * before->among : (0.5 - at) * after->among;
}

/* Integral of the share along the line, by midpoints a quarter of a spacing apart: the blur of the kernel is symmetric, so it
 * does not change the depth. */
double probe_height(Measure *m)
{
    const Model *model = &m->sim->model;
    const int up = m->probe->axis;
    const double low = model->min[up] + measure_shift(m, up), length = model->max[up] - model->min[up];
    const int n = (int)ceil(4 * length / model->dx);
    const double step = length / n;
    double x[3] = {0, 0, 0}, depth = 0;
    Share before = {.solid = true};
    for (int d = 0; d < model->dim; d++) x[d] = m->probe->at[d] + measure_shift(m, d);
    for (int k = 0; k < n; k++) {
        x[up] = low + (k + 0.5) * step;
        const Share share = sample_share_along(m->sim, up, x, measure_fluids(m));
        depth += step * ((is_filled(&share) ? share.among : 0) + beyond_midway(&before, &share));
        before = share;
    }
    return depth;
}

/* Is there to be fluid at a point of the lattice? In a wall, where that is now, there is not; nor need there be at sides of a domain of which a part is empty, as
 * they may be open. x: moved with the probe's wall. */
static bool is_wanted(const Measure *m, const double x[3])
{
    const Model *model = &m->sim->model;
    const MnsProbe *probe = m->probe;
    for (int d = 0; d < model->dim; d++) {
        const double at = x[d] - measure_shift(m, d);
        const double rim = model->filled || model->period[d] > 0 ? 0 : model->kernel.support;
        if (at < model->min[d] + rim || at > model->max[d] - rim) return false;
        if (probe->within && (at < probe->min[d] || at > probe->max[d])) return false;
    }
    return !solid_covers(m->sim, x, solid_distance_now(m->sim, x));
}

/* Smallest sum of W V over the points of the domain's fitted lattice at which there is to be fluid. */
double probe_coverage(Measure *m)
{
    const MnsSim *sim = m->sim;
    const Model *model = &sim->model;
    size_t n[3] = {1, 1, 1};
    double spacing[3] = {0, 0, 0}, least = INFINITY;
    for (int d = 0; d < model->dim; d++) n[d] = case_fit(sim->c, d, &spacing[d]);
#pragma omp parallel for schedule(dynamic, 256) reduction(min : least) num_threads(sim->threads)
    for (size_t k = 0; k < n[0] * n[1] * n[2]; k++) {
        const size_t index[3] = {k % n[0], k / n[0] % n[1], k / n[0] / n[1]};
        double x[3] = {0, 0, 0};
        for (int d = 0; d < model->dim; d++)
            x[d] = model->min[d] + ((double)index[d] + 0.5) * spacing[d] + measure_shift(m, d);
        if (!is_wanted(m, x)) continue;
        const double all = sample_cover(sim, x);
        least = all < least ? all : least;
    }
    return least < INFINITY ? least : NAN;
}
