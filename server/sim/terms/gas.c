/* SPDX-License-Identifier: BSD-3-Clause */
/* A gas beside a liquid, in a scheme that dissipates densities alone: pairs of which one is of the gas, and which close, resist as two halves of a
 * Riemann problem do (P3 eq. 9, without its limiter), and where its pressure is below zero a gas feels no more than differences of it.
 *   m_i dv_i/dt -= sum_j V_i V_j (s 2 z_i z_j/(z_i + z_j) dU - 2 min(0, P_i)) grad_i W,   dU = max(0, -v_ij . x_ij/r), the second of a gas only
 * A light liquid beside a heavy one is treated as a gas is, but resists the less (s = `resists`), the nearer its density is to the other's.
 * What little the liquid's pressure is off moves a gas of a thousandth of its density, and nothing in P1 takes that motion away again. A gas has no
 * structure that this would smear: between two particles of water nothing is dissipated.
 * Particles that pull at each other clump at walls. There the shift takes them back without a change of density, which falls at each turn, the more
 * the lower the pressure is: in a closed tank a gas whose sound is twice the water's was torn within 0.3 s. Differences alone do not pull: the sum over
 * neighbours of what is left out would be none if they lay evenly. The force on a liquid is as it was.
 *   d rho_i/dt += rho_i c/h max(0, Gamma_i - 1.25) of a fluid that fills
 * A particle of gas between drops of water and a wall is left by slow ones while it slips past them, and nothing of the same fluid is near whose pressure would
 * hold its density: that of dambreak2d at H/20 fell to a tenth, so that it counted for ten. No particle takes more room than there is. */
#include "sim/terms/gas.h"
#include "sim/terms/terms.h"

static bool any_fills(const Model *model)
{
    return model->any_fills;
}

INLINE void gas_dissipation_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const Pushed a = pushed_of(s, model, i);
    const double tiny = gas_tiny(model);
    double resists[MNS_MAX_FLUIDS], v[3];
    Lanes sum[3] = {0};
    if (!row->mixed && !model->phase[s->phase[i]].fills) return;
    resistances(model, s->phase[i], resists);
    for (int d = 0; d < how.dim; d++) v[d] = s->v[d][i * s->v_step];
    const double lift = gas_lift(model, s->phase[i], &a);
    const Block *const walls = row->block + row->n_fluid, *const end = row->block + row->n;
    for (const Block *b = row->block; b < walls; b++) {
        double against[LANES];
        by_fluid(s, row_j(row, b), resists, against);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            gas_pair(&a, v, lift, &pair, against[l], tiny, how, l, sum);
        }
    }
    for (const Block *b = walls; b < end; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            gas_wall(&a, lift, &pair, how, l, sum);
        }
    pressure_end(s, i, sum, how);
    gas_end(s, model, i);
}
ROW_FUNCTIONS(gas_dissipation_row)

const Term gas_dissipation = {
    .name = "dissipation beside a gas",
    .source = "P3 eq. 9",
    .equation =
        "m_i dv_i/dt -= sum_j V_i V_j (s 2 z_i z_j/(z_i + z_j) max(0, -v_ij . x_ij/r) - 2 min(0, p_i/Gamma_i) of a "
        "gas) grad_i W,  s = 1, ((rho_heaviest/rho_0 - 1)/49)^2 of a light liquid;  d rho_i/dt += rho_i c/h "
        "max(0, Gamma_i - 1.25) of a gas",
    .on = ON_FLUID,
    .needed = any_fills,
    .needs = NEED_F | NEED_V | NEED_STATE | NEED_SHEPARD | NEED_OTHERS,
    .writes = FIELD(A),
    .row = ROW_TABLE(gas_dissipation_row),
};
