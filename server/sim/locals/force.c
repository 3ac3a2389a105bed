/* SPDX-License-Identifier: BSD-3-Clause */
/* Accelerations begin with gravity: its mean over the step that ends here, which the next one puts right (integrator_gravity()). */
#include "sim/locals/locals.h"
#include "sim/terms/differences.h"

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

static void float_up(Particles *s, const Model *model, size_t first, size_t last)
{
    for (int d = 0; d < s->dim; d++)
        for (size_t i = first; i < last; i++) s->a[d][i] = body_force_of(model, density_around(s, model, i), d);
}

const Local buoyancy = {
    .name = "gravity",
    .source = "P5 3.3, with its force as that of a density's excess",
    .equation = "du_i/dt = (1 - rho_0/rho~_i) g,  rho_0 = 0 or that of a fluid in which others float",
    .on = ON_FLUID,
    .apply = float_up,
    .writes = FIELD(A),
};
