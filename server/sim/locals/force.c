/* SPDX-License-Identifier: BSD-3-Clause */
/* Accelerations begin with gravity. */
#include "sim/locals/locals.h"

static void gravity(Particles *s, const Model *model, size_t first, size_t last)
{
    for (int d = 0; d < s->dim; d++)
        for (size_t i = first; i < last; i++) s->a[d][i] = model->gravity[d];
}

const Local body_force = {
    .name = "gravity",
    .source = "P3 eq. 2",
    .equation = "dv_i/dt = g",
    .on = ON_FLUID,
    .apply = gravity,
    .writes = FIELD(A),
};
