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

/* Of what is in a bundle. */
static ShownView view_of(const Particles *s, int field, int d)
{
    return (ShownView){particles_element(s, field, d, 0), particles_step(s, field)};
}

void shown_make(const MnsSim *sim, int field, int d, double *out)
{
    const Particles *s = &sim->s;
    const ShownView view = view_of(s, field, d);
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < s->n; i++) {
        if (view.first) out[i] = shown_number(&view, i);
        else out[i] = field == F_VOL ? particles_volume(s, &sim->model, i) : particles_impedance(s, &sim->model, i);
    }
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

ShownView shown_view(const MnsSim *sim, int field, int d)
{
    if (sim->s.housed >> field & 1) return view_of(&sim->s, field, d);
    return (ShownView){shown_field(sim, field, d), 1};
}
