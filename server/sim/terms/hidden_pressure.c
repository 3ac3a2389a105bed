/* SPDX-License-Identifier: BSD-3-Clause */
/* Pressures of wall particles behind mirrors (mirrors.h), which no row has and no system solves for: for pictures, loads and probes.
 *   P_w = sum_f W (P_f + dt rho_f b . x_wf) / sum_f W,   b gravity, less that on the fluid in which others float;  0 where no fluid is near */
#include "sim/mirrors.h"
#include "sim/solve/solve.h"
#include "sim/terms/differences.h"
#include "sim/terms/terms.h"

INLINE void hidden_row(const Row *row, Particles *s, const Model *model, bool mixed_fluids, How how)
{
    const size_t i = row->i;
    const double *P = s->system->x;
    double weight = 0, sum = 0;
    if (!mirrors_hide(model, s, i)) return;
    for (const Block *b = row->block; b < row->block + row->n; b++) {
        const uint32_t *j = row_j(row, b);
        for (int l = 0; l < LANES; l++) {
            const double rho = mixed_fluids ? density_around(s, model, j[l]) : model->phase[s->phase[j[l]]].rho0;
            double along = 0;
            for (int d = 0; d < how.dim; d++) along += body_force_of(model, rho, d) * b->x[d][l];
            weight += b->W[l];
            sum += b->W[l] * (P[j[l]] + model->dt * rho * along);
        }
    }
    s->system->x[i] = weight > 0 ? sum / weight : 0;
}

INLINE void hidden_pressure_row(const Row *row, Particles *s, const Model *model, How how)
{
    hidden_row(row, s, model, false, how);
}
ROW_FUNCTIONS(hidden_pressure_row)

INLINE void hidden_mixed_pressure_row(const Row *row, Particles *s, const Model *model, How how)
{
    hidden_row(row, s, model, true, how);
}
ROW_FUNCTIONS(hidden_mixed_pressure_row)

const Term hidden_pressure = {
    .name = "pressure behind mirrors",
    .source = "schemes/incompressible.md",
    .equation = "P_w = sum_f W (P_f + dt rho_f g . x_wf) / sum_f W",
    .on = ON_WALL,
    .needed = has_mirrors,
    .needs = NEED_W,
    .row = ROW_TABLE(hidden_pressure_row),
};

const Term hidden_mixed_pressure = {
    .name = "pressure behind mirrors",
    .source = "schemes/differences.md",
    .equation = "P_w = sum_f W (P_f + dt rho~_f b . x_wf) / sum_f W",
    .on = ON_WALL,
    .needed = has_mirrors,
    .needs = NEED_W,
    .row = ROW_TABLE(hidden_mixed_pressure_row),
};
