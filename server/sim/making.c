/* SPDX-License-Identifier: BSD-3-Clause */
/* What a simulation will take, found out before it takes it. */
#include "sim/making.h"
#include "sim/belts.h"
#include "sim/energy.h"
#include "sim/sort.h"
#include <math.h>

/* Of a neighbour list: as many as the lattice has points in reach and a tenth more. */
static double list_entries(const Model *model)
{
    const double crowded = 1.1;
    const double reach = model->kernel.support + model->skin;
    const double ball = model->dim == 2 ? M_PI * reach * reach : 4 * M_PI / 3 * reach * reach * reach;
    return crowded * ball / model->cell_volume;
}

/* Of what is in reach of a wall particle, which lists fluid alone: of a cube as thick as the support and with the skin around it, the least that
 * walls are. */
static const double SEEN_BY_WALLS = 0.85;

/* Entries and their marks. */
static double list_bytes(const Model *model)
{
    const double entries = list_entries(model);
    return entries * sizeof(uint32_t) + entries / 8 + 8;
}

/* Vectors of the pressure system; its rows, of which half a block is empty and a twentieth is to spare; and what multigrid keeps of them, of
 * two matrices that take turns where densities are corrected by weights of their own. */
static double system_need(const MnsSim *sim, const Particles *s)
{
    const Model *model = &sim->model;
    const double rows = (double)s->n, spare = 1.05;
    const Projection *options = &model->projection;
    const System none = {.matrix.n = 1};
    double multigrid = 0;
    const double entries = list_entries(model);
    if (amg_exists() && solve_takes_amg(options->solver, rows, entries / ENTRIES, sim->scheme->symmetric))
        multigrid = (options->unit_mobility ? 2 : 1) * amg_bytes(rows, entries);
    return multigrid + rows * (double)system_bytes(&none) +
           spare * rows * (entries + 0.5 * ENTRIES) * (sizeof(uint32_t) + sizeof(float));
}

/* Asked of lists for nobody, whose layout is that of any. */
static double neighbours_need(const MnsSim *sim, const Particles *s)
{
    Neighbours nb;
    const Model *model = &sim->model;
    if (neighbours_init(&nb, 0, model->dim, scheme_needs(sim->scheme, model), sim->threads, NULL)) return INFINITY;
    nb.n = s->n;
    nb.start_capacity = sort_groups(s) * grid_cells_most(model, model->kernel.support + model->skin, s->n);
    const double bytes = (double)neighbours_bytes(&nb);
    neighbours_done(&nb);
    const double fluid = (double)particles_fluid(s), walls = (double)s->n - fluid;
    return bytes + (fluid + SEEN_BY_WALLS * walls) * list_bytes(model);
}

static double capture_bytes(int dim, Fields state)
{
    const MnsFieldInfo *info = mns_fields();
    double each = 0;
    for (int f = 0; info[f].name; f++)
        if (state >> f & 1) each += (double)field_size(&info[f]) * (info[f].components == 1 ? 1 : dim);
    return each;
}

/* How many wall particles belong to belts is known only once they are placed: all of them are counted. */
static bool has_belts(const MnsSim *sim)
{
    for (size_t k = 0; k < sim->model.n_walls; k++)
        if (sim->model.wall[k].has_belt) return true;
    return false;
}

double making_bytes(const MnsSim *sim, const size_t sizes[GROUPS])
{
    Particles s = {.dim = sim->model.dim,
                   .n_phases = sim->model.n_phases,
                   .fields = scheme_fields(sim->scheme, &sim->model),
                   .of_fluid = FLUID_FIELDS};
    for (int g = 0; g < GROUPS; g++) s.begin[g + 1] = s.begin[g] + sizes[g];
    s.n = s.begin[GROUPS];
    double bytes =
        (double)particles_bytes(&s) + neighbours_need(sim, &s) + (double)s.n * capture_bytes(s.dim, sim->scheme->state);
    if (sim->scheme->projects) bytes += system_need(sim, &s);
    if (energy_needs_power(sim)) bytes += (double)particles_fluid(&s) * sizeof *s.power;
    if (has_belts(sim)) bytes += (double)belts_bytes(sizes[GROUP_WALL]);
    if (sim->model.viscous || sim->scheme->projects) bytes += (double)sizes[GROUP_WALL] * sizeof(double) * s.dim;
    return bytes;
}

double making_most(const MnsSim *sim)
{
    enum { MANY = 1 << 20 };
    if (!sim->making.memory) return INFINITY;
    return (double)sim->making.memory / making_bytes(sim, (size_t[GROUPS]){[GROUP_CONTINUITY] = MANY}) * MANY;
}

MnsStatus making_fits(const MnsSim *sim, const size_t sizes[GROUPS], bool more, MnsError *error)
{
    const MnsMaking *making = &sim->making;
    const double needed = making_bytes(sim, sizes), n = (double)(sizes[0] + sizes[1] + sizes[2]);
    if (!making->memory || needed <= (double)making->memory) return MNS_OK;
    return mns_fail_at(error, MNS_E_MEMORY, "resolution",
                       "%s%.3g particles take %s%.3g GB of memory, and %.3g GB are %s: lower the resolution, make the "
                       "domain smaller, or compute where there is more memory",
                       more ? "more than " : "", n, more ? "more than " : "", 1e-9 * needed,
                       1e-9 * (double)making->memory, making->memory_is ? making->memory_is : "allowed");
}

MnsStatus making_goes_on(const MnsMaking *making, MnsError *error)
{
    if (!making->given_up || !making->given_up(making->arg)) return MNS_OK;
    return mns_fail(error, MNS_E_INTERRUPTED, "given up before it was ready");
}
