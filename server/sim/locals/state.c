/* SPDX-License-Identifier: BSD-3-Clause */
/* The equation of state of each fluid. Volumes and impedances, which follow from density too, are made where they are asked for. */
#include "sim/state.h"
#include "sim/locals/locals.h"

static void state(Particles *s, const Model *model, size_t first, size_t last)
{
    for (size_t i = first; i < last; i++) {
        const Phase *phase = &model->phase[s->phase[i]];
        s->p[i * s->p_step] = state_pressure(phase, s->rho[i]);
    }
}

const Local linear_pressure = {
    .name = "linear state equation",
    .source = "P1 eq. 5, P3 eq. 3",
    .equation = "p_i = c^2 (rho_i - rho0),  V_i = m_i / rho_i",
    .on = ON_FLUID,
    .apply = state,
    .writes = FIELD(P) | FIELD(VOL) | FIELD(Z),
};

const Local tait_pressure = {
    .name = "Tait's state equation",
    .source = "P2 eq. 6",
    .equation = "p_i = c^2 rho0/gamma ((rho_i/rho0)^gamma - 1) + p_b,  V_i = m_i / rho_i",
    .on = ON_FLUID,
    .apply = state,
    .writes = FIELD(P) | FIELD(VOL) | FIELD(Z),
};
