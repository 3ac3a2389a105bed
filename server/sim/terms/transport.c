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
static void background_row(Row *row, Particles *s, const Model *model)
{
    const size_t i = row->i, n = row_whole(row->n);
    const Phase *phase = &model->phase[s->phase[i]];
    const double *restrict V = s->vol, *restrict F = row->F;
    const uint32_t *restrict j = row->j;
    double *restrict c = row->c;
#pragma omp simd
    for (size_t k = 0; k < n; k++) c[k] = V[j[k]] * F[k];

    double along_w = 0;
    for (int d = 0; d < row->dim; d++) {
        const double sum = row_sum_along(row, d, 0, n);
        s->b[d][i] = -2 * phase->p_b / s->rho[i] * sum;
        along_w += s->w[d][i] * sum;
    }
    if (!model->transport_stress || !phase->summation) return;
    for (int d = 0; d < row->dim; d++) s->a[d][i] += s->vol[i] * s->rho[i] / s->m[i] * s->v[d][i] * along_w;
}

/* The neighbours' part: sum_j m_j v_j (w_j . grad_i W) over neighbours of summed density. */
static void transport_stress_row(Row *row, Particles *s, const Model *model)
{
    (void)model;
    const size_t i = row->i, first = row_whole(row->end[GROUP_CONTINUITY]), last = row_whole(row->end[GROUP_SUMMATION]);
    const double *restrict m = s->m, *restrict F = row->F;
    const uint32_t *restrict j = row->j;
    double *restrict c = row->c, *restrict u = row->u;
    if (first == last) return;
    for (size_t k = first; k < last; k++) u[k] = 0;
    for (int d = 0; d < row->dim; d++) {
        const double *restrict w = s->w[d], *restrict dx = row->dx[d];
#pragma omp simd
        for (size_t k = first; k < last; k++) u[k] += w[j[k]] * dx[k];
    }
#pragma omp simd
    for (size_t k = first; k < last; k++) c[k] = m[j[k]] * F[k] * u[k];
    for (int d = 0; d < row->dim; d++) s->a[d][i] += s->vol[i] / s->m[i] * row_sum_field(row, s->v[d], first, last);
}

const Term background = {
    .name = "background pressure",
    .source = "P3 eq. 11, 12",
    .equation = "b_i = -2 p_b / rho_i sum_j V_j grad_i W;  m_i dv_i/dt += sum_j V_i V_j A_i . grad_i W",
    .on = ON_FLUID,
    .row = background_row,
};

const Term transport_stress = {
    .name = "transport stress",
    .source = "P3 eq. 12",
    .equation = "m_i dv_i/dt += sum_j V_i V_j A_j . grad_i W,  A = rho v (x) w",
    .on = ON_FLUID,
    .needed = transports,
    .row = transport_stress_row,
};
