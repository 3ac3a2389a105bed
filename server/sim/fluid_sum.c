/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/fluid_sum.h"

enum { BLOCK = 4096 }; /* particles that one thread sums up, whatever the number of threads */

double fluid_sum(Particles *s, const Model *model, Addend addend, int threads)
{
    const size_t n = particles_fluid(s), blocks = (n + BLOCK - 1) / BLOCK;
    double all = 0;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t b = 0; b < blocks; b++) {
        double part = 0;
        for (size_t i = b * BLOCK; i < n && i < (b + 1) * BLOCK; i++) part += addend(s, model, i);
        s->rate[b] = part;
    }
    for (size_t b = 0; b < blocks; b++) all += s->rate[b];
    return all;
}
