/* SPDX-License-Identifier: BSD-3-Clause */
/* What a wall's dummy particles show to the fluid, extrapolated from the fluid around them.            P3 eq. 14, Adami 2012
 *   p_w^a = [ sum_f w p_f + (g - a_w) . sum_f w rho_f (x_w - x_f) ] / sum_f w,   w = W V_f,   f of fluid a only
 * One pressure for each fluid: a common one lets air at a triple point feel the water's pressure and shoots it away, or
 * lets water leak (schemes/README.md). */
#include "sim/terms/terms.h"

static unsigned phases_in(const Row *row, const Particles *s)
{
    unsigned present = 0;
    for (size_t k = 0; k < row_whole(row->n); k++) present |= 1u << s->phase[row->j[k]];
    return present;
}

/* c = W V_f rho_f for pairs of one fluid, u = W V_f; returns sum of W V_f p_f, and of W V_f. */
static double weigh(Row *row, const Particles *s, unsigned fluid, double *ret_weight)
{
    const double *restrict W = row->W, *restrict V = s->vol, *restrict p = s->p, *restrict rho = s->rho;
    const uint8_t *restrict phase = s->phase;
    const uint32_t *restrict j = row->j;
    double *restrict c = row->c, weight = 0, pressure = 0;
    for (size_t k = 0; k < row_whole(row->n); k++) {
        const double w = phase[j[k]] == fluid ? W[k] * V[j[k]] : 0;
        c[k] = w * rho[j[k]];
        weight += w;
        pressure += w * p[j[k]];
    }
    *ret_weight = weight;
    return pressure;
}

static void wall_pressure_row(Row *row, Particles *s, const Model *model)
{
    const size_t i = row->i, wall = i - particles_fluid(s);
    const WallState *body = &model->wall[s->phase[i] - model->n_phases];
    const unsigned present = phases_in(row, s);
    double all_weight = 0, all_pressure = 0;
    for (unsigned a = 0; a < model->n_phases; a++) {
        double weight = 0, pressure = 0;
        if (present & 1u << a) {
            pressure = weigh(row, s, a, &weight);
            for (int d = 0; d < row->dim; d++)
                pressure += (model->gravity[d] - body->a[d]) * row_sum_along(row, d, 0, row->n);
        }
        s->p_wall[a][wall] = weight > 1e-12 ? pressure / weight : 0;
        all_weight += weight;
        all_pressure += pressure;
    }
    s->p[i] = all_weight > 1e-12 ? all_pressure / all_weight : 0; /* for pictures */
}

static void wall_velocity_row(Row *row, Particles *s, const Model *model)
{
    (void)model;
    const size_t wall = row->i - particles_fluid(s), n = row_whole(row->n);
    const double *restrict W = row->W, *restrict V = s->vol;
    const uint32_t *restrict j = row->j;
    double *restrict c = row->c;
#pragma omp simd
    for (size_t k = 0; k < n; k++) c[k] = W[k] * V[j[k]];
    const double weight = row_sum(row, 0, n);
    for (int d = 0; d < row->dim; d++)
        s->v_wall[d][wall] = weight > 1e-12 ? row_sum_field(row, s->v[d], 0, n) / weight : s->v[d][row->i];
}

static bool is_viscous(const Model *model)
{
    return model->viscous;
}

const Term wall_pressure = {
    .name = "wall pressure",
    .source = "P3 eq. 14, for each fluid of its own",
    .equation = "p_w = [sum_f w p_f + (g - a_w) . sum_f w rho_f x_wf] / sum_f w,  w = W V_f",
    .on = ON_WALL,
    .row = wall_pressure_row,
};

const Term wall_velocity = {
    .name = "wall velocity",
    .source = "Adami 2012 eq. 22",
    .equation = "v~_w = sum_f W V_f v_f / sum_f W V_f",
    .on = ON_WALL,
    .needed = is_viscous,
    .row = wall_velocity_row,
};
