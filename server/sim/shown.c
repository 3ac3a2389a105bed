/* SPDX-License-Identifier: BSD-3-Clause */
/* What follows from density and mass is made for whoever looks, each time: to keep it would take 16 bytes of every particle. */
#include "sim/shown.h"
#include "base/array.h"

Fields shown_fields(const MnsSim *sim)
{
    return sim->s.fields | sim->s.made;
}

void shown_make(const MnsSim *sim, int field, double *out)
{
    const Particles *s = &sim->s;
    const Model *model = &sim->model;
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < s->n; i++)
        out[i] = field == F_VOL ? particles_volume(s, model, i) : particles_impedance(s, model, i);
}

const void *shown_field(const MnsSim *sim, int field, int d)
{
    if (!(sim->s.made >> field & 1)) return particles_field(&sim->s, field, d);
    if (d > 0) return NULL;
    double **room = &sim->shown->of[field];
    if (!*room) *room = array_room(sim->s.n, sizeof **room);
    if (*room) shown_make(sim, field, *room);
    return *room;
}
