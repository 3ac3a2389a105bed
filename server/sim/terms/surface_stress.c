/* SPDX-License-Identifier: BSD-3-Clause */
/* Surface tension as a stress of the particles beside an interface, of any number of fluids.                      P4 eq. 4, 5
 *   g_i = 1/V_i sum_j sigma_ij V_j^2 grad_i W over other fluids,   Pi_i = (|g|^2 I/dim - g (x) g)/|g|
 *   m_i dv_i/dt += sum_j (V_i^2 Pi_i + V_j^2 Pi_j) . grad_i W,   opposite for the two of a pair, so momentum is kept
 * With q = V g / sqrt|g| the stress is V^2 Pi = |q|^2 I/dim - q (x) q: a vector says it all. */
#include "sim/terms/terms.h"
#include <math.h>

INLINE void surface_vector_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const double *tension = model->tension[s->phase[i]];
    const double V = particles_volume(s, model, i);
    double g[3] = {0}, most = 0;
    for (size_t a = 0; a < model->n_phases; a++) most = fmax(most, tension[a]);
    if (row->mixed) {
        Lanes sum[3] = {0};
        for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
            const uint32_t *j = row_j(row, b);
            double sigma[LANES];
            for (int l = 0; l < LANES; l++) sigma[l] = b->other[l] * tension[s->phase[j[l]]];
#pragma omp simd
            for (int l = 0; l < LANES; l++) {
                const double c = sigma[l] * (b->V[l] * b->V[l]) * b->F[l];
                for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, c, b->x[d][l], how);
            }
        }
        for (int d = 0; d < how.dim; d++) g[d] = lanes_sum(&sum[d]) / V;
    }
    const double size = sqrt(DOT(g, g, how));
    const double scale = size * model->kernel.h > 1e-8 * most ? V / sqrt(size) : 0;
    for (int d = 0; d < how.dim; d++) s->surface[d][i] = scale * g[d];
}
ROW_FUNCTIONS(surface_vector_row)

INLINE void surface_stress_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)model;
    const size_t i = row->i;
    double mine[3];
    Lanes sum[3] = {0};
    for (int d = 0; d < how.dim; d++) mine[d] = s->surface[d][i];
    const double mine2 = DOT(mine, mine, how);
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        const uint32_t *j = row_j(row, b);
        double of_j[3][LANES];
        for (int d = 0; d < how.dim; d++)
            for (int l = 0; l < LANES; l++) of_j[d][l] = s->surface[d][j[l]];
        for (int d = 0; d < how.dim && are_images(row, b); d++) turn_component(row, b, d, of_j[d]);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            double x[3], its[3];
            for (int d = 0; d < how.dim; d++) {
                x[d] = b->x[d][l];
                its[d] = of_j[d][l];
            }
            const double even = (mine2 + DOT(its, its, how)) / how.dim;
            const double along = DOT(mine, x, how), its_along = DOT(its, x, how);
            for (int d = 0; d < how.dim; d++)
                sum[d].of[l] += b->F[l] * (even * x[d] - (mine[d] * along + its[d] * its_along));
        }
    }
    for (int d = 0; d < how.dim; d++) s->a[d][i] += lanes_sum(&sum[d]) / s->m[i];
}
ROW_FUNCTIONS(surface_stress_row)

const Term surface_vector = {
    .name = "surface vector",
    .source = "P4 eq. 5",
    .equation = "q_i = V_i g_i/sqrt|g_i|,  g_i = 1/V_i sum_j sigma_ij V_j^2 grad_i W over other fluids",
    .on = ON_FLUID,
    .needed = is_tense,
    .needs = NEED_F | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(SURFACE),
    .row = ROW_TABLE(surface_vector_row),
};

const Term surface_stress = {
    .name = "surface stress",
    .source = "P4 eq. 4, 5, 9",
    .equation = "m_i dv_i/dt += sum_j (S_i + S_j) . grad_i W,  S = |q|^2 I/dim - q (x) q",
    .on = ON_FLUID,
    .needed = is_tense,
    .needs = NEED_F,
    .writes = FIELD(A),
    .row = ROW_TABLE(surface_stress_row),
};
