/* SPDX-License-Identifier: BSD-3-Clause */
/* A bubble that particles do not resolve has the pressure of the liquid around it, besides its own.
 *   p_i += chi sum_l W V_l p_l / sum_l W V_l,   l: neighbours that follow continuity (liquids)
 *   chi = 10 (share - 0.9) where the liquids make more than 9/10 of the kernel around it, else 0
 * A gas of rho c^2 below the pressures of the flow carries them only if it is squeezed to a fraction, and a lone particle among
 * others at dx cannot be squeezed: its summed density says how many there are around it, so that its pressure would never
 * exceed some rho c^2, a sink to the liquid (schemes/README.md). A flat interface has a share of 1/3, a film of one layer 0.63,
 * a pair 0.82. */
#include "sim/terms/terms.h"

INLINE void bubble_pressure_row(const Row *row, Particles *s, const Model *model, int dim)
{
    (void)model, (void)dim;
    const uint32_t liquids = (uint32_t)s->begin[GROUP_SUMMATION];
    Lanes all = {0}, liquid = {0}, pressure = {0};
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        const uint32_t *j = row_j(row, b);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double weight = b->W[l] * b->V[l], of_liquid = j[l] < liquids ? weight : 0;
            all.of[l] += weight;
            liquid.of[l] += of_liquid;
            pressure.of[l] += of_liquid * b->p[l];
        }
    }
    const double share = lanes_sum(&liquid) / lanes_sum(&all);
    if (share > 0.9) s->p[row->i] += 10 * (share - 0.9) * (lanes_sum(&pressure) / lanes_sum(&liquid));
}
ROW_FUNCTIONS(bubble_pressure_row)

const Term bubble_pressure = {
    .name = "bubble pressure",
    .source = "server/sim/schemes/README.md",
    .equation = "p_i += chi sum_l W V_l p_l / sum_l W V_l,  l: liquids, chi = 10 (their share - 0.9)",
    .on = ON_SUMMATION,
    .needs = NEED_W | NEED_STATE,
    .row = ROW_TABLE(bubble_pressure_row),
};
