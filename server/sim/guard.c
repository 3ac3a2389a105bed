/* SPDX-License-Identifier: BSD-3-Clause */
/* The guard against penetration: a fluid particle that drifted closer to a wall's surface than the guard distance goes back
 * to that distance and loses its velocity into the wall, relative to the wall. No paper has it; violent impacts at low
 * resolution need it (schemes/riemann.md). */
#include "sim/sim.h"

/* Guard one particle against one wall, whose shape stands where the case put it: so move the particle instead. */
static bool guard_one(MnsSim *sim, size_t i, size_t k)
{
    Particles *s = &sim->s;
    const WallState *wall = &sim->model.wall[k];
    double x[3] = {0, 0, 0}, normal[3];
    for (int d = 0; d < s->dim; d++) x[d] = s->x[d][i * s->x_step] - wall->x[d];
    const double depth = sim->model.guard - shape_distance(&sim->solid[k], x);
    if (!(depth > 0)) return false;
    shape_normal(&sim->solid[k], x, 1e-3 * sim->model.dx, normal);
    double into = 0;
    for (int d = 0; d < s->dim; d++) into += (s->v[d][i * s->v_step] - wall->v[d]) * normal[d];
    for (int d = 0; d < s->dim; d++) {
        s->x[d][i * s->x_step] += depth * normal[d];
        if (into < 0) s->v[d][i * s->v_step] -= into * normal[d];
    }
    return true;
}

uint64_t guard_walls(MnsSim *sim)
{
    const size_t n = particles_fluid(&sim->s);
    uint64_t guarded = 0;
    if (!(sim->model.guard > 0) || sim->model.n_walls == 0) return 0;
#pragma omp parallel for schedule(static) reduction(+ : guarded) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++) {
        if (!(sim->nb.has[i] & (LIST_WALLS | LIST_MIRRORS))) continue; /* no wall near */
        bool kept = false;                                             /* between two walls it is still one particle */
        for (size_t k = 0; k < sim->model.n_walls; k++) kept = guard_one(sim, i, k) || kept;
        guarded += kept;
    }
    return guarded;
}
