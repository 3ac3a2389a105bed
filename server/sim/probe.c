/* SPDX-License-Identifier: BSD-3-Clause */
/* Probes: one number each, from the particles as they are now. Sums run over fixed blocks of particles, so that the number
 * of threads does not change a bit. */
#include "sim/sample.h"
#include <math.h>
#include <omp.h>

/* One probe, and what it takes to evaluate it at a particle. */
typedef struct Measure {
    const MnsSim *sim;
    const MnsProbe *probe;
    const MnsFieldInfo *field;  /* of an extremum */
    const void *array[3];       /* its components */
    const FormulaTeam *formula; /* of a deviation */
    int threads;
} Measure;

typedef double Summand(const Measure *m, size_t i);

static bool counts(const Measure *m, size_t i)
{
    const MnsProbe *probe = m->probe;
    if (probe->fluid >= 0 && m->sim->s.phase[i] != probe->fluid) return false;
    for (int d = 0; probe->within && d < m->sim->s.dim; d++)
        if (m->sim->s.x[d][i] < probe->min[d] || m->sim->s.x[d][i] > probe->max[d]) return false;
    return true;
}

/* Combine f over the fluid particles that count: sum, or the largest value where `largest`; NAN where there is none. */
static double over_fluid(const Measure *m, Summand *f, bool largest)
{
    const size_t n = particles_fluid(&m->sim->s), blocks = sim_blocks(n);
    const double none = largest ? -INFINITY : 0;
    double *partial = m->sim->partial, result = none;
#pragma omp parallel for schedule(static) num_threads(m->threads)
    for (size_t b = 0; b < blocks; b++) {
        double value = none;
        for (size_t i = b * SIM_BLOCK; i < n && i < (b + 1) * SIM_BLOCK; i++) {
            if (!counts(m, i)) continue;
            const double term = f(m, i);
            value = largest ? (term > value ? term : value) : value + term;
        }
        partial[b] = value;
    }
    for (size_t b = 0; b < blocks; b++)
        result = largest ? (partial[b] > result ? partial[b] : result) : result + partial[b];
    return largest && !(result > -INFINITY) ? NAN : result;
}

static double one(const Measure *m, size_t i)
{
    (void)m, (void)i;
    return 1;
}

static double mass(const Measure *m, size_t i)
{
    return m->sim->s.m[i];
}

static double kinetic(const Measure *m, size_t i)
{
    const Particles *s = &m->sim->s;
    double v2 = 0;
    for (int d = 0; d < s->dim; d++) v2 += s->v[d][i] * s->v[d][i];
    return 0.5 * s->m[i] * v2;
}

static double potential(const Measure *m, size_t i)
{
    const Particles *s = &m->sim->s;
    double gx = 0;
    for (int d = 0; d < s->dim; d++) gx += m->sim->model.gravity[d] * s->x[d][i];
    return -s->m[i] * gx;
}

static double mass_moment(const Measure *m, size_t i)
{
    return m->sim->s.m[i] * m->sim->s.x[m->probe->axis][i];
}

static double momentum(const Measure *m, size_t i)
{
    return m->sim->s.m[i] * m->sim->s.v[m->probe->axis][i];
}

static double forward(const Measure *m, size_t i)
{
    const double x = m->sim->s.x[m->probe->axis][i];
    return (m->probe->least ? -x : x) + 0.5 * m->sim->model.dx;
}

/* Wall the probe moves with: its displacement along d. */
static double shift(const MnsSim *sim, const MnsProbe *probe, int d)
{
    return probe->wall >= 0 ? sim->model.wall[probe->wall].x[d] : 0;
}

static double outside(const Measure *m, size_t i)
{
    const Model *model = &m->sim->model;
    for (int d = 0; d < model->dim; d++) {
        const double x = m->sim->s.x[d][i] - shift(m->sim, m->probe, d);
        if (model->period[d] == 0 && !(x >= model->min[d] && x <= model->max[d])) return 1;
    }
    return 0;
}

static double element(const Measure *m, int d, size_t i)
{
    switch (m->field->type) {
    case MNS_F64: return ((const double *)m->array[d])[i];
    case MNS_U32: return ((const uint32_t *)m->array[d])[i];
    case MNS_U8: return ((const uint8_t *)m->array[d])[i];
    }
    return NAN;
}

/* A vector counts by its magnitude. */
static double field_value(const Measure *m, size_t i)
{
    double sum = 0, value = 0;
    for (int d = 0; d < m->sim->s.dim && d < m->field->components; d++) {
        value = element(m, d, i);
        sum += value * value;
    }
    if (m->field->components > 1) value = sqrt(sum);
    return m->probe->least ? -value : value;
}

static double squared_deviation(const Measure *m, size_t i)
{
    const Particles *s = &m->sim->s;
    const double at[4] = {s->x[0][i], s->x[1][i], s->dim == 3 ? s->x[2][i] : 0, m->sim->progress.t};
    const double error = s->p[i] - formula_eval(formula_of(m->formula, omp_get_thread_num()), at);
    return error * error;
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

/* Smallest sum of W V over the points of the domain's fitted lattice; where a part of the domain is empty, over those a
 * kernel's support away from its sides, as a side need not be a wall. */
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
            const double rim = model->filled || model->period[d] > 0 ? 0 : model->kernel.support;
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

static double extremum(Measure *m)
{
    const int field = mns_field_find(m->probe->field);
    m->field = &mns_fields()[field];
    for (int d = 0; d < m->sim->s.dim; d++) m->array[d] = particles_field(&m->sim->s, field, d);
    const double value = over_fluid(m, field_value, true);
    return m->probe->least ? -value : value;
}

/* No more threads than there are copies of the formula: a run may have been steered to more. */
static double pressure_deviation(Measure *m)
{
    if (m->formula->n > 1 && m->formula->n < m->threads) m->threads = m->formula->n;
    const double n = over_fluid(m, one, false);
    return n > 0 ? sqrt(over_fluid(m, squared_deviation, false) / n) : NAN;
}

double mns_sim_probe(const MnsSim *sim, size_t k)
{
    const MnsProbe *probe = &sim->c->probes[k];
    Measure m = {.sim = sim, .probe = probe, .formula = &sim->probe_formula[k], .threads = sim->threads};
    double value;
    switch (probe->kind) {
    case MNS_PROBE_PRESSURE: return pressure(sim, probe);
    case MNS_PROBE_HEIGHT: return height(sim, probe);
    case MNS_PROBE_FRONT: value = over_fluid(&m, forward, true); return probe->least ? -value : value;
    case MNS_PROBE_KINETIC_ENERGY: return over_fluid(&m, kinetic, false);
    case MNS_PROBE_POTENTIAL_ENERGY: return over_fluid(&m, potential, false);
    case MNS_PROBE_MASS_CENTRE: return over_fluid(&m, mass_moment, false) / over_fluid(&m, mass, false);
    case MNS_PROBE_MOMENTUM: return over_fluid(&m, momentum, false);
    case MNS_PROBE_MASS: return over_fluid(&m, mass, false);
    case MNS_PROBE_EXTREMUM: return extremum(&m);
    case MNS_PROBE_COVERAGE: return coverage(sim, probe);
    case MNS_PROBE_ESCAPED: return over_fluid(&m, outside, false);
    case MNS_PROBE_PRESSURE_DEVIATION: return pressure_deviation(&m);
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
