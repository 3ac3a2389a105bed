/* SPDX-License-Identifier: BSD-3-Clause */
/* What follows from density and mass is made for whoever looks, each time: to keep it would take 16 bytes of every particle. And what only
 * bundles have is copied from there. */
#include "sim/shown.h"
#include "base/array.h"

Fields shown_fields(const MnsSim *sim)
{
    return sim->s.fields | sim->s.made;
}

Fields shown_made(const MnsSim *sim)
{
    return sim->s.made | sim->s.housed;
}

static double value_of(const MnsSim *sim, int field, int d, size_t i)
{
    const Particles *s = &sim->s;
    if (field == F_VOL) return particles_volume(s, &sim->model, i);
    if (field == F_Z) return particles_impedance(s, &sim->model, i);
    return *(const double *)particles_element(s, field, d, i);
}

void shown_make(const MnsSim *sim, int field, int d, double *out)
{
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < sim->s.n; i++) out[i] = value_of(sim, field, d, i);
}

const void *shown_field(const MnsSim *sim, int field, int d)
{
    if (!(shown_made(sim) >> field & 1)) return particles_field(&sim->s, field, d);
    if (d >= (mns_fields()[field].components == 1 ? 1 : sim->s.dim)) return NULL;
    double **room = &sim->shown->of[field][d];
    if (!*room) *room = array_room(sim->s.n, sizeof **room);
    if (*room) shown_make(sim, field, d, *room);
    return *room;
}
