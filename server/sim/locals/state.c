/* SPDX-License-Identifier: BSD-3-Clause */
/* Linear equation of state, and what follows from density and pressure.                                          P3 eq. 3 */
#include "sim/state.h"
#include "sim/locals/locals.h"

static void linear(Particles *s, const Model *model, size_t first, size_t last)
{
    for (size_t i = first; i < last; i++) {
        const Phase *phase = &model->phase[s->phase[i]];
        s->p[i] = state_pressure(phase, s->rho[i]);
        s->vol[i] = s->m[i] / s->rho[i];
        s->z[i] = s->rho[i] * phase->c;
    }
}

const Local linear_pressure = {
    .name = "linear state equation",
    .source = "P3 eq. 3",
    .equation = "p_i = c^2 (rho_i - rho0),  V_i = m_i / rho_i",
    .on = ON_FLUID,
    .apply = linear,
    .writes = FIELD(P) | FIELD(VOL) | FIELD(Z),
};
