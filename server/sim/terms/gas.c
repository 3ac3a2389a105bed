/* SPDX-License-Identifier: BSD-3-Clause */
/* A gas beside a liquid, in a scheme that dissipates densities alone: pairs of which one is of the gas, and which close, resist as two halves of a
 * Riemann problem do (P3 eq. 9, without its limiter).
 *   m_i dv_i/dt -= sum_j V_i V_j 2 z_i z_j/(z_i + z_j) dU grad_i W,   dU = max(0, -v_ij . x_ij/r)
 * What little the liquid's pressure is off moves a gas of a thousandth of its density, and nothing in P1 takes that motion away again. A gas has no
 * structure that this would smear: between two particles of water nothing is dissipated. */
#include "sim/terms/gas.h"
#include "sim/terms/terms.h"

static bool has_gas(const Model *model)
{
    return model->has_gas;
}

INLINE void gas_dissipation_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const Pushed a = pushed_of(s, model, i);
    const double tiny = gas_tiny(model);
    double gases[MNS_MAX_FLUIDS], v[3];
    Lanes sum[3] = {0};
    if (!row->mixed && !model->phase[s->phase[i]].fills) return;
    gases_beside(model, s->phase[i], gases);
    for (int d = 0; d < how.dim; d++) v[d] = s->v[d][i * s->v_step];
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        double counts[LANES];
        by_fluid(s, row_j(row, b), gases, counts);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            gas_pair(&a, v, &pair, counts[l], tiny, how, l, sum);
        }
    }
    pressure_end(s, i, sum, how);
}
ROW_FUNCTIONS(gas_dissipation_row)

const Term gas_dissipation = {
    .name = "dissipation beside a gas",
    .source = "P3 eq. 9",
    .equation = "m_i dv_i/dt -= sum_j V_i V_j 2 z_i z_j/(z_i + z_j) max(0, -v_ij . x_ij/r) grad_i W",
    .on = ON_FLUID,
    .needed = has_gas,
    .needs = NEED_F | NEED_V | NEED_STATE | NEED_SHEPARD | NEED_OTHERS,
    .writes = FIELD(A),
    .row = ROW_TABLE(gas_dissipation_row),
};
