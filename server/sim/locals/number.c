/* SPDX-License-Identifier: BSD-3-Clause */
/* From the number density of an incompressible fluid to what a particle takes up. Its density is a measure of the error only: what
 * the equations use is that of reference. */
#include "sim/locals/locals.h"

static void number(Particles *s, const Model *model, size_t first, size_t last)
{
    (void)model;
#pragma omp simd
    for (size_t i = first; i < last; i++) s->rho[i] = s->m[i] * s->rate[i];
}

const Local volume_of_number = {
    .name = "volume",
    .source = "P4 eq. 7, 8",
    .equation = "V_i = 1 / (W(0) + sum_j W_ij),  rho_i = m_i / V_i",
    .on = ON_SUMMATION,
    .apply = number,
    .writes = FIELD(RHO) | FIELD(VOL),
};
