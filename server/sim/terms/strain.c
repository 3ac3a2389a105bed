/* SPDX-License-Identifier: BSD-3-Clause */
/* Rates of strain, beside which P3 dissipates. */
#include "sim/terms/strain.h"
#include "sim/fused.h"
#include "sim/terms/terms.h"

static bool reconstructs(const Model *model)
{
    return model->reconstructs;
}

/* Fluids of summed density, and so gases, have no rates of strain. */
INLINE void strain_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    double v[3];
    StrainSums sums = {0};
    if (model_is_gas(model, model->phase[s->phase[i]].rho0)) return;
    if (row->mixed) {
        bool beside = false;
        for (const Block *b = row->block; b < row->block + row->n_fluid && !beside; b++)
            beside = is_beside_gas(s, model, row_j(row, b), b->r, LANES);
        if (beside) {
            no_strain(s, i, how);
            return;
        }
    }
    for (int d = 0; d < how.dim; d++) v[d] = s->v[d][i * s->v_step];
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++)
        strain_block(v, b, row->mixed ? b->other : NO_OTHERS, how, &sums);
    strain_end(s, i, &sums, how);
}
ROW_FUNCTIONS(strain_row)

const Term strain_rate = {
    .name = "strain rate",
    .source = "schemes/riemann.md",
    .equation = "D_i = sym(M_i sum_j V_j grad_i W (x) (v_j - v_i)) over its own fluid; 0 beside a gas",
    .on = ON_CONTINUITY,
    .needed = reconstructs,
    .needs = NEED_F | NEED_V | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(STRAIN) | FIELD(STRAIN_OFF),
    .row = ROW_TABLE(strain_row),
};
