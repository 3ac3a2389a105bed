/* SPDX-License-Identifier: BSD-3-Clause */
/* Probes that are the largest or smallest of something over the particles of a fluid. */
#include "sim/probes/probes.h"
#include "sim/shown.h"
#include <math.h>

static double forward(const Measure *m, size_t i)
{
    const double x = m->sim->s.x[m->probe->axis][i * m->sim->s.x_step];
    return (m->probe->least ? -x : x) + 0.5 * m->sim->model.dx;
}

double probe_front(Measure *m)
{
    const double value = measure_largest(m, forward);
    return m->probe->least ? -value : value;
}

static double element(const Measure *m, int d, size_t i)
{
    switch (m->field->type) {
    case MNS_F64: return shown_number(&m->array[d], i);
    case MNS_U32: return ((const uint32_t *)m->array[d].first)[i];
    case MNS_U8: return ((const uint8_t *)m->array[d].first)[i];
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

double probe_extremum(Measure *m)
{
    const int field = mns_field_find(m->probe->field);
    m->field = &mns_fields()[field];
    for (int d = 0; d < m->sim->s.dim; d++) m->array[d] = shown_view(m->sim, field, d);
    if (!m->array[0].first) return NAN; /* setup.c refuses such probes; nobody shall die of one that got past it */
    const double value = measure_largest(m, field_value);
    return m->probe->least ? -value : value;
}
