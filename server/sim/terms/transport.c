/* SPDX-License-Identifier: BSD-3-Clause */
/* Transport velocity: particles are advected with v + w, where w comes from a constant background pressure and keeps them
 * evenly spread; where density is summed, the stress A = rho v (x) w accounts for the difference.            P3 eq. 11, 12
 *   b_i = -2 p_b / rho_i sum_j V_j grad_i W,   w_i = dt/2 b_i
 *   m_i dv_i/dt += sum_j V_i V_j (A_i + A_j) . grad_i W,   A = 0 where density is not summed, and in walls
 * A fluid of the other kind feels its neighbours' A too, so that the forces of a pair stay opposite. Fluids whose density
 * follows continuity are spread as well, without stress: nothing else closes the holes that open in a falling jet, as their
 * density does not know how far apart their particles are (schemes/README.md). */
#include "sim/terms/terms.h"

static bool transports(const Model *model)
{
    if (!model->transport_stress) return false;
    for (size_t k = 0; k < model->n_phases; k++)
        if (model->phase[k].summation) return true;
    return false;
}

/* b_i, and the part of the stress that is the particle's own: rho_i v_i (w_i . sum_j V_j grad_i W). */
INLINE void background_row(const Row *row, Particles *s, const Model *model, int dim)
{
    const size_t i = row->i;
    const Phase *phase = &model->phase[s->phase[i]];
    const double half = 0.5 * model->dt;
    Lanes sums[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double c = b->V[l] * b->F[l];
            for (int d = 0; d < dim; d++) sums[d].of[l] += c * b->x[d][l];
        }
    double along_w = 0;
    for (int d = 0; d < dim; d++) {
        const double sum = lanes_sum(&sums[d]);
        along_w += half * s->b[d][i] * sum; /* w of this step, of the last one's b */
        s->b[d][i] = -2 * phase->p_b / s->rho[i] * sum;
    }
    if (!model->transport_stress || !phase->summation) return;
    for (int d = 0; d < dim; d++) s->a[d][i] += s->vol[i] * s->rho[i] / s->m[i] * s->v[d][i] * along_w;
}
ROW_FUNCTIONS(background_row)

/* The neighbours' part: sum_j m_j v_j (w_j . grad_i W) over neighbours of summed density. */
INLINE void transport_stress_row(const Row *row, Particles *s, const Model *model, int dim)
{
    (void)model;
    if (!row->summed) return;
    const size_t i = row->i;
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            double flux = 0;
            for (int d = 0; d < dim; d++) flux += b->q[d][l] * b->x[d][l];
            const double c = b->F[l] * flux;
            for (int d = 0; d < dim; d++) sum[d].of[l] += c * b->v[d][l];
        }
    for (int d = 0; d < dim; d++) s->a[d][i] += s->vol[i] / s->m[i] * lanes_sum(&sum[d]);
}
ROW_FUNCTIONS(transport_stress_row)

const Term background = {
    .name = "background pressure",
    .source = "P3 eq. 11, 12",
    .equation = "b_i = -2 p_b / rho_i sum_j V_j grad_i W;  m_i dv_i/dt += sum_j V_i V_j A_i . grad_i W",
    .on = ON_FLUID,
    .needs = NEED_F | NEED_STATE,
    .writes = FIELD(A) | FIELD(B),
    .row = ROW_TABLE(background_row),
};

const Term transport_stress = {
    .name = "transport stress",
    .source = "P3 eq. 12",
    .equation = "m_i dv_i/dt += sum_j V_i V_j A_j . grad_i W,  A = rho v (x) w",
    .on = ON_FLUID,
    .needed = transports,
    .needs = NEED_F | NEED_V | NEED_FLUX,
    .writes = FIELD(A),
    .row = ROW_TABLE(transport_stress_row),
};
