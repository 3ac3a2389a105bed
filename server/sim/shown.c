/* SPDX-License-Identifier: BSD-3-Clause */
/* What follows from density and mass, or from the colour, is made for whoever looks, each time: to keep it would take 16 bytes of every particle and more. And what only
 * bundles have is copied from there. */
#include "sim/shown.h"
#include "base/array.h"

Fields shown_fields(const MnsSim *sim)
{
    return sim->s.fields | sim->s.made;
}

Fields shown_made(const MnsSim *sim)
{
    return sim->s.made | sim->s.housed | particles_parted(&sim->s);
}

/* Of what is stored; first is NULL of what is made. */
static ShownView view_of(const Particles *s, int field, int d)
{
    const size_t first = particles_owners(s, field).first;
    return (ShownView){first < s->n ? particles_element(s, field, d, first) : NULL, particles_step(s, field)};
}

/* Of what nobody stores. */
static double made_of(const MnsSim *sim, int field, size_t i)
{
    switch (field) {
    case F_VOL: return particles_volume(&sim->s, &sim->model, i);
    case F_Z: return particles_impedance(&sim->s, &sim->model, i);
    case F_RHO_MIXED: return mixed(mixture_of_densities(&sim->model), sim->s.colour[i]);
    case F_MU_MIXED: return mixed(mixture_of_viscosities(&sim->model), sim->s.colour[i]);
    default: return 0;
    }
}

void shown_make(const MnsSim *sim, int field, int d, double *out)
{
    const Particles *s = &sim->s;
    const ShownView view = view_of(s, field, d);
    const Owners owners = particles_owners(s, field);
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < s->n; i++) {
        if (i < owners.first || i >= owners.last) out[i] = 0;
        else if (view.first) out[i] = shown_number(&view, i - owners.first);
        else out[i] = made_of(sim, field, i);
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
