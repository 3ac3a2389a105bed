/* SPDX-License-Identifier: BSD-3-Clause */
/* Probes that are sums over the particles of a fluid, or a mean of them. */
#include "sim/probes/probes.h"
#include <math.h>
#include <omp.h>

static double one(const Measure *m, size_t i)
{
    (void)m, (void)i;
    return 1;
}

static double mass(const Measure *m, size_t i)
{
    return m->sim->s.m[i];
}

double probe_mass(Measure *m)
{
    return measure_sum(m, mass);
}

static double kinetic(const Measure *m, size_t i)
{
    const Particles *s = &m->sim->s;
    double v2 = 0;
    for (int d = 0; d < s->dim; d++) v2 += s->v[d][i * s->v_step] * s->v[d][i * s->v_step];
    return 0.5 * s->m[i] * v2;
}

double probe_kinetic_energy(Measure *m)
{
    return measure_sum(m, kinetic);
}

static double potential(const Measure *m, size_t i)
{
    const Particles *s = &m->sim->s;
    double gx = 0;
    for (int d = 0; d < s->dim; d++) gx += m->sim->model.gravity_now[d] * s->x[d][i * s->x_step];
    return -s->m[i] * gx;
}

double probe_potential_energy(Measure *m)
{
    return measure_sum(m, potential);
}

static double mass_moment(const Measure *m, size_t i)
{
    return m->sim->s.m[i] * m->sim->s.x[m->probe->axis][i * m->sim->s.x_step];
}

double probe_mass_centre(Measure *m)
{
    return measure_sum(m, mass_moment) / measure_sum(m, mass);
}

static double momentum(const Measure *m, size_t i)
{
    return m->sim->s.m[i] * m->sim->s.v[m->probe->axis][i * m->sim->s.v_step];
}

double probe_momentum(Measure *m)
{
    return measure_sum(m, momentum);
}

/* All of a fluid moves as its centre does. */
double probe_velocity(Measure *m)
{
    return measure_sum(m, momentum) / measure_sum(m, mass);
}

static double volume(const Measure *m, size_t i)
{
    return particles_volume(&m->sim->s, &m->sim->model, i);
}

double probe_volume(Measure *m)
{
    return measure_sum(m, volume);
}

static double outside(const Measure *m, size_t i)
{
    const Model *model = &m->sim->model;
    for (int d = 0; d < model->dim; d++) {
        const double x = m->sim->s.x[d][i * m->sim->s.x_step] - measure_shift(m, d);
        if (model->period[d] == 0 && !(x >= model->min[d] && x <= model->max[d])) return 1;
    }
    return 0;
}

double probe_escaped(Measure *m)
{
    return measure_sum(m, outside);
}

static double squared_deviation(const Measure *m, size_t i)
{
    const Particles *s = &m->sim->s;
    const double at[4] = {s->x[0][i * s->x_step], s->x[1][i * s->x_step], s->dim == 3 ? s->x[2][i * s->x_step] : 0,
                          m->sim->progress.t};
    const double error = s->p[i * s->p_step] - formula_eval(formula_of(m->formula, omp_get_thread_num()), at);
    return error * error;
}

/* No more threads than there are copies of the formula: a run may have been steered to more. */
double probe_pressure_deviation(Measure *m)
{
    if (!m->formula->shared && m->formula->n < m->threads) m->threads = m->formula->n;
    const double n = measure_sum(m, one);
    return n > 0 ? sqrt(measure_sum(m, squared_deviation) / n) : NAN;
}
