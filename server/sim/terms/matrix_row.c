/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/terms/matrix_row.h"

static size_t blocks_for(size_t entries)
{
    return (entries + LANES - 1) / LANES;
}

bool matrix_rows_lay(Particles *s, const Neighbours *nb)
{
    const size_t n = particles_fluid(s);
    const int threads = s->system->threads;
    Matrix *m = &s->system->matrix;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < m->n; i++) {
        const size_t fluid = nb->end[i][END_FLUID], walls = i < n ? nb->end[i][END_WALLS] - fluid : 0;
        m->blocks[i] = (uint32_t)(blocks_for(fluid) + blocks_for(walls));
    }
    return matrix_lay(m, threads);
}
