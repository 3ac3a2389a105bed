/* SPDX-License-Identifier: BSD-3-Clause */
/* Probes: one number each, from the particles as they are now. Sums run over fixed blocks of particles, so that the number
 * of threads does not change a bit. */
#include "sim/sample.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 4096 };

typedef double Summand(const MnsSim *sim, const MnsProbe *probe, size_t i);

static bool counts(const MnsSim *sim, const MnsProbe *probe, size_t i)
{
    return probe->fluid < 0 || sim->s.phase[i] == probe->fluid;
}

static bool inside(const MnsSim *sim, const MnsProbe *probe, size_t i)
{
    for (int d = 0; probe->within && d < sim->s.dim; d++)
        if (sim->s.x[d][i] < probe->min[d] || sim->s.x[d][i] > probe->max[d]) return false;
    return true;
}

/* Combine f over the fluid particles that count: sum, or the largest value where `largest`; NAN where there is none. */
static double over_fluid(const MnsSim *sim, const MnsProbe *probe, Summand *f, bool largest)
{
    const size_t n = particles_fluid(&sim->s), blocks = (n + BLOCK - 1) / BLOCK;
    const double none = largest ? -INFINITY : 0;
    double *partial = malloc(blocks * sizeof *partial), result = none;
    if (!partial) return NAN;
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t b = 0; b < blocks; b++) {
        double value = none;
        for (size_t i = b * BLOCK; i < n && i < (b + 1) * BLOCK; i++) {
            if (!counts(sim, probe, i) || !inside(sim, probe, i)) continue;
            const double term = f(sim, probe, i);
            value = largest ? (term > value ? term : value) : value + term;
        }
        partial[b] = value;
    }
    for (size_t b = 0; b < blocks; b++)
        result = largest ? (partial[b] > result ? partial[b] : result) : result + partial[b];
    free(partial);
    return largest && !(result > -INFINITY) ? NAN : result;
}

static double mass(const MnsSim *sim, const MnsProbe *probe, size_t i)
{
    (void)probe;
    return sim->s.m[i];
}

static double kinetic(const MnsSim *sim, const MnsProbe *probe, size_t i)
{
    (void)probe;
    double v2 = 0;
    for (int d = 0; d < sim->s.dim; d++) v2 += sim->s.v[d][i] * sim->s.v[d][i];
    return 0.5 * sim->s.m[i] * v2;
}

static double potential(const MnsSim *sim, const MnsProbe *probe, size_t i)
{
    (void)probe;
    double gx = 0;
    for (int d = 0; d < sim->s.dim; d++) gx += sim->model.gravity[d] * sim->s.x[d][i];
    return -sim->s.m[i] * gx;
}

static double mass_moment(const MnsSim *sim, const MnsProbe *probe, size_t i)
{
    return sim->s.m[i] * sim->s.x[probe->axis][i];
}

static double momentum(const MnsSim *sim, const MnsProbe *probe, size_t i)
{
    return sim->s.m[i] * sim->s.v[probe->axis][i];
}

static double forward(const MnsSim *sim, const MnsProbe *probe, size_t i)
{
    const double x = sim->s.x[probe->axis][i];
    return (probe->least ? -x : x) + 0.5 * sim->model.dx;
}

/* Wall the probe moves with: its displacement along d. */
static double shift(const MnsSim *sim, const MnsProbe *probe, int d)
{
    return probe->wall >= 0 ? sim->model.wall[probe->wall].x[d] : 0;
}

static double outside(const MnsSim *sim, const MnsProbe *probe, size_t i)
{
    for (int d = 0; d < sim->s.dim; d++) {
        const double x = sim->s.x[d][i] - shift(sim, probe, d);
        if (sim->model.period[d] == 0 && !(x >= sim->model.min[d] && x <= sim->model.max[d])) return 1;
    }
    return 0;
}

static double field_value(const MnsSim *sim, const MnsProbe *probe, size_t i)
{
    const int field = mns_field_find(probe->field);
    const MnsFieldInfo *info = &mns_fields()[field];
    double sum = 0, value = 0;
    for (int d = 0; d < sim->s.dim && d < info->components; d++) {
        const void *array = particles_field(&sim->s, field, d);
        value = info->type == MNS_F64   ? ((const double *)array)[i]
                : info->type == MNS_U32 ? ((const uint32_t *)array)[i]
                                        : ((const uint8_t *)array)[i];
        sum += value * value;
    }
    if (info->components > 1) value = sqrt(sum);
    return probe->least ? -value : value;
}

static double pressure(const MnsSim *sim, const MnsProbe *probe)
{
    double x[3] = {0, 0, 0};
    const double *p[1] = {sim->s.p};
    for (int d = 0; d < sim->s.dim; d++) x[d] = probe->at[d] + shift(sim, probe, d);
    const PointSums sums = sample_point(sim, x, probe->radius, -1, p, 1);
    return sums.fluid > 1e-12 ? sums.value / sums.fluid : NAN;
}

/* Share of the fluid at a point: 1 deep inside it, 0 outside. Beyond a free surface, where less than half of the kernel
 * is filled, there is nothing; dummy particles fill their half. */
static double share(const MnsSim *sim, const MnsProbe *probe, const double x[3])
{
    const PointSums sums = sample_point(sim, x, 0, probe->fluid, NULL, 0);
    return sums.all >= 0.5 && sums.fluid > 1e-12 ? sums.one / sums.fluid : 0;
}

/* Integral of the share along the line, by midpoints a quarter of a spacing apart: the blur of the kernel is symmetric, so it
 * does not change the depth. */
static double height(const MnsSim *sim, const MnsProbe *probe)
{
    const Model *model = &sim->model;
    const int up = probe->axis;
    const double low = model->min[up] + shift(sim, probe, up), length = model->max[up] - model->min[up];
    const int n = (int)ceil(4 * length / model->dx);
    const double step = length / n;
    double x[3] = {0, 0, 0}, depth = 0;
    for (int d = 0; d < model->dim; d++) x[d] = probe->at[d] + shift(sim, probe, d);
    for (int k = 0; k < n; k++) {
        x[up] = low + (k + 0.5) * step;
        depth += step * share(sim, probe, x);
    }
    return depth;
}

/* Smallest sum of W V over the points of the domain's fitted lattice that are a kernel's support away from its sides: a side
 * need not be a wall, and a gap at a wall is a matter of how walls push, not of voids. */
static double coverage(const MnsSim *sim, const MnsProbe *probe)
{
    const Model *model = &sim->model;
    size_t n[3] = {1, 1, 1};
    double spacing[3] = {0, 0, 0}, least = INFINITY;
    for (int d = 0; d < model->dim; d++) n[d] = case_fit(sim->c, d, &spacing[d]);
#pragma omp parallel for schedule(dynamic, 256) reduction(min : least) num_threads(sim->threads)
    for (size_t k = 0; k < n[0] * n[1] * n[2]; k++) {
        const size_t index[3] = {k % n[0], k / n[0] % n[1], k / n[0] / n[1]};
        double x[3] = {0, 0, 0};
        bool wanted = true;
        for (int d = 0; d < model->dim; d++) {
            x[d] = model->min[d] + ((double)index[d] + 0.5) * spacing[d];
            const double rim = model->period[d] > 0 ? 0 : model->kernel.support;
            wanted = wanted && x[d] >= model->min[d] + rim && x[d] <= model->max[d] - rim &&
                     (!probe->within || (x[d] >= probe->min[d] && x[d] <= probe->max[d]));
            x[d] += shift(sim, probe, d);
        }
        if (!wanted) continue;
        const double all = sample_point(sim, x, 0, -1, NULL, 0).all;
        least = all < least ? all : least;
    }
    return least < INFINITY ? least : NAN;
}

/* Formulas keep a state of their own, so this sum is not parallel. */
static double pressure_deviation(const MnsSim *sim, const MnsProbe *probe, const Formula *formula)
{
    double sum = 0, n = 0;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        if (!counts(sim, probe, i)) continue;
        const double at[4] = {sim->s.x[0][i], sim->s.x[1][i], sim->s.dim == 3 ? sim->s.x[2][i] : 0, sim->progress.t};
        const double error = sim->s.p[i] - formula_eval(formula, at);
        sum += error * error;
        n++;
    }
    return n > 0 ? sqrt(sum / n) : NAN;
}

double mns_sim_probe(const MnsSim *sim, size_t k)
{
    const MnsProbe *probe = &sim->c->probes[k];
    double value;
    switch (probe->kind) {
    case MNS_PROBE_PRESSURE: return pressure(sim, probe);
    case MNS_PROBE_HEIGHT: return height(sim, probe);
    case MNS_PROBE_FRONT: value = over_fluid(sim, probe, forward, true); return probe->least ? -value : value;
    case MNS_PROBE_KINETIC_ENERGY: return over_fluid(sim, probe, kinetic, false);
    case MNS_PROBE_POTENTIAL_ENERGY: return over_fluid(sim, probe, potential, false);
    case MNS_PROBE_MASS_CENTRE: return over_fluid(sim, probe, mass_moment, false) / over_fluid(sim, probe, mass, false);
    case MNS_PROBE_MOMENTUM: return over_fluid(sim, probe, momentum, false);
    case MNS_PROBE_MASS: return over_fluid(sim, probe, mass, false);
    case MNS_PROBE_EXTREMUM: value = over_fluid(sim, probe, field_value, true); return probe->least ? -value : value;
    case MNS_PROBE_COVERAGE: return coverage(sim, probe);
    case MNS_PROBE_ESCAPED: return over_fluid(sim, probe, outside, false);
    case MNS_PROBE_PRESSURE_DEVIATION: return pressure_deviation(sim, probe, sim->probe_formula[k]);
    }
    return NAN;
}

const char *mns_probe_unit(const MnsProbe *probe)
{
    switch (probe->kind) {
    case MNS_PROBE_PRESSURE:
    case MNS_PROBE_PRESSURE_DEVIATION: return "Pa";
    case MNS_PROBE_HEIGHT:
    case MNS_PROBE_FRONT:
    case MNS_PROBE_MASS_CENTRE: return "m";
    case MNS_PROBE_KINETIC_ENERGY:
    case MNS_PROBE_POTENTIAL_ENERGY: return "J";
    case MNS_PROBE_MOMENTUM: return "kg m/s";
    case MNS_PROBE_MASS: return "kg";
    case MNS_PROBE_EXTREMUM: {
        const int field = mns_field_find(probe->field);
        return field < 0 ? "1" : mns_fields()[field].unit;
    }
    case MNS_PROBE_COVERAGE:
    case MNS_PROBE_ESCAPED: return "1";
    }
    return "1";
}
