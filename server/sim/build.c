/* SPDX-License-Identifier: BSD-3-Clause */
/* Put a particle on each point of the lattice that belongs to somebody, or where that is moved to, and have fluids start. Rows are filled by
 * all threads at once, each where a count of those before it says, so that every bit is the same for any number. */
#include "sim/belts.h"
#include "sim/displacement.h"
#include "sim/drops.h"
#include "sim/edges.h"
#include "sim/fluid_sum.h"
#include "sim/making.h"
#include "sim/motion.h"
#include "sim/sides.h"
#include "sim/solid.h"
#include "sim/start.h"
#include <math.h>
#include <stdio.h>

static MnsStatus check_counts(const size_t *counts, const MnsCase *c, MnsError *error)
{
    char at[64];
    for (size_t k = 0; k < c->n_fluids; k++) {
        snprintf(at, sizeof at, "fluids[%zu]", k);
        if (counts[k] == 0)
            return mns_fail_at(error, MNS_E_INVALID, at,
                               "%s has no particle: its region is empty, or smaller than the "
                               "particle spacing",
                               c->fluids[k].name);
    }
    for (size_t k = 0; k < c->n_walls; k++) {
        snprintf(at, sizeof at, "walls[%zu].shape", k);
        if (counts[c->n_fluids + k] == 0)
            return mns_fail_at(error, MNS_E_INVALID, at,
                               "%s has no particle within the domain and the kernel's reach "
                               "around it",
                               c->walls[k].name);
    }
    return MNS_OK;
}

static Group group_of(const Model *model, int owner)
{
    if ((size_t)owner >= model->n_phases) return GROUP_WALL;
    return model->phase[owner].summation ? GROUP_SUMMATION : GROUP_CONTINUITY;
}

/* How many particles there are of all. */
static MnsStatus count(const Lattice *lattice, const MnsSim *sim, size_t sizes[GROUPS], MnsError *error)
{
    size_t counts[MNS_MAX_FLUIDS + MNS_MAX_WALLS] = {0};
    for (int g = 0; g < GROUPS; g++) sizes[g] = 0;
    for (size_t r = 0; r < lattice->rows; r++)
        for (size_t k = 0; k < lattice->row[r].n; k++) {
            const LatticeRun *run = &lattice->row[r].runs[k];
            counts[run->owner] += run->n;
            sizes[group_of(&sim->model, run->owner)] += run->n;
        }
    return check_counts(counts, sim->c, error);
}

/* Where the particles of each run are stored: by group, and as they come. */
static void number(Lattice *lattice, const MnsSim *sim)
{
    size_t next[GROUPS];
    uint32_t id = 0;
    for (int g = 0; g < GROUPS; g++) next[g] = sim->s.begin[g];
    for (size_t r = 0; r < lattice->rows; r++) {
        LatticeRow *row = &lattice->row[r];
        row->id = id;
        for (size_t k = 0; k < row->n; k++) {
            size_t *at = &next[group_of(&sim->model, row->runs[k].owner)];
            row->runs[k].at = *at;
            *at += row->runs[k].n;
            id += row->runs[k].n;
        }
    }
}

/* What filling needs to know besides the particles. */
typedef struct Filling {
    MnsSim *sim;
    const Lattice *lattice;
    const Displacement *displacement;
    const Start *starts; /* [n_fluids]; while particles are placed, NULL */
} Filling;

/* By the case's shapes, which are where the walls are at first. */
static void find_surface(MnsSim *sim, size_t i, size_t k)
{
    Particles *s = &sim->s;
    double x[3] = {0}, to[3];
    for (int d = 0; d < s->dim; d++) x[d] = s->x[d][i];
    solid_to_surface(sim, x, k, to);
    for (int d = 0; d < s->dim; d++) s->to_surface[d][i - particles_fluid(s)] = to[d];
}

/* A number in [-1, 1) for each key, as good as random: the finalizer of splitmix64. */
static double noise_of(uint64_t key)
{
    uint64_t z = (key + 1) * UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1;
}

static void set_wall(const Filling *f, size_t i, size_t k)
{
    const Model *model = &f->sim->model;
    Particles *s = &f->sim->s;
    s->rho[i] = model->rho_max;
    s->m[i] = model->rho_max * model->cell_volume;
    for (int d = 0; d < s->dim; d++) s->v[d][i] = model->wall[k].v[d];
    if (s->to_surface[0]) find_surface(f->sim, i, k);
}

/* Off the lattice by a disorder that depends on the particle's number alone. */
static void disorder(const MnsSim *sim, uint32_t id, double x[3])
{
    if (!(sim->c->disorder > 0)) return;
    for (int d = 0; d < sim->s.dim; d++)
        x[d] += sim->c->disorder * sim->model.cell[d] *
                noise_of((uint64_t)sim->c->seed << 34 | (uint64_t)id << 2 | (unsigned)d);
}

static bool is_fluid(const Filling *f, const LatticeRun *run)
{
    return (size_t)run->owner < f->sim->model.n_phases;
}

static MnsStatus place_row(const Filling *f, size_t r, MnsError *error)
{
    const Model *model = &f->sim->model;
    Particles *s = &f->sim->s;
    const LatticeRow *row = &f->lattice->row[r];
    const int axis = hydrostatic_axis(model);
    uint32_t id = row->id;
    MnsStatus status = MNS_OK;
    for (size_t k = 0; k < row->n && !status; k++) {
        const LatticeRun *run = &row->runs[k];
        for (size_t q = 0; q < run->n && !status; q++) {
            const size_t i = run->at + q;
            double x[3] = {0};
            Stretch stretch;
            lattice_place(f->lattice, r, run->first + q, x);
            if (is_fluid(f, run)) {
                disorder(f->sim, id, x);
                status = displacement_apply(f->displacement, f->sim, x, &stretch, error);
                s->m[i] = stretch.volume * model->cell_volume;
                s->rho[i] = axis < 0 ? 1 : stretch.along[axis];
            }
            s->id[i] = id++;
            s->phase[i] = (uint8_t)run->owner;
            for (int d = 0; d < s->dim; d++) s->x[d][i] = x[d];
            if (!is_fluid(f, run)) set_wall(f, i, (size_t)run->owner - model->n_phases);
        }
    }
    return status;
}

static MnsStatus start_row(const Filling *f, size_t r, MnsError *error)
{
    const LatticeRow *row = &f->lattice->row[r];
    MnsStatus status = MNS_OK;
    for (size_t k = 0; k < row->n; k++)
        for (size_t q = 0; q < row->runs[k].n && is_fluid(f, &row->runs[k]) && !status; q++)
            status = start_particle(f->starts, f->sim, row->runs[k].at + q, error);
    return status;
}

/* What is wrong in the first row that is, as the lattice does it. */
static MnsStatus fill(const Filling *f, MnsError *error)
{
    size_t bad = SIZE_MAX;
    MnsStatus status = MNS_OK;
#pragma omp parallel for schedule(dynamic, 8) num_threads(f->sim->threads)
    for (size_t row = 0; row < f->lattice->rows; row++) {
        MnsError why;
        MnsStatus failed = making_goes_on(&f->sim->making, &why);
        if (!failed) failed = f->starts ? start_row(f, row, &why) : place_row(f, row, &why);
        if (!failed) continue;
#pragma omp critical(build_failed)
        if (row < bad) {
            bad = row;
            status = failed;
            if (error) *error = why;
        }
    }
    return status;
}

static double mass(const Particles *s, const Model *model, size_t i)
{
    (void)model;
    return s->m[i];
}

/* Fluids that fill the domain fill it after they were moved too: volumes by the middles of cells are off by some thousandths. */
static MnsStatus keep_volume(MnsSim *sim, MnsError *error)
{
    Particles *s = &sim->s;
    const size_t n = particles_fluid(s);
    if (!sim->model.filled) return MNS_OK;
    const double cells = (double)n * sim->model.cell_volume;
    const double grown = fluid_sum(s, &sim->model, mass, sim->threads) / cells; /* masses are volumes as yet */
    if (!(fabs(grown - 1) < 0.02))
        return mns_fail_at(
            error, MNS_E_INVALID, "domain.displacement",
            "makes the fluids fill %.3g times the domain that they fill as the lattice is: the sides must "
            "stay where they are, and nothing may be moved over another",
            grown);
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++) s->m[i] /= grown;
    return MNS_OK;
}

/* Count, allocate, fill. */
static MnsStatus populate(MnsSim *sim, Lattice *lattice, const Constants *constants, MnsError *error)
{
    const MnsCase *c = sim->c;
    size_t sizes[GROUPS];
    Start starts[MNS_MAX_FLUIDS] = {0};
    Displacement displacement = {0};
    MnsStatus status = count(lattice, sim, sizes, error);
    if (!status) status = making_fits(sim, sizes, false, error);
    if (!status)
        status =
            particles_init(&sim->s, c->dim, c->n_fluids, sizes, scheme_fields(sim->scheme, &sim->model), FLUID_FIELDS,
                           sim->model.viscous || sim->scheme->projects, sim->threads, &sim->making, error);
    sim->s.made = scheme_made(sim->scheme, &sim->model);
    if (!status) number(lattice, sim);
    if (!status && !sim->resumed) status = displacement_init(&displacement, sim, constants, error);
    Filling filling = {.sim = sim, .lattice = lattice, .displacement = &displacement};
    if (!status) status = fill(&filling, error);
    if (!status) status = drops_find(sim, lattice, error);
    if (!status) status = belts_init(sim, error);
    if (!status) status = sides_find(sim, lattice, error);
    if (!status && displacement.moves) status = keep_volume(sim, error);
    if (!status && !sim->resumed) status = start_init(starts, sim, lattice, constants, error);
    filling.starts = starts;
    if (!status && !sim->resumed) status = fill(&filling, error); /* else they go on from elsewhere */
    displacement_done(&displacement);
    start_done(starts, c->n_fluids);
    return status;
}

MnsStatus build_particles(MnsSim *sim, const Constants *constants, MnsError *error)
{
    Lattice lattice;
    MnsStatus status = lattice_init(&lattice, sim, constants, error);
    sim->model.filled = lattice.filled;
    sim->model.closed = lattice.filled && motion_of_all(sim->c);
    sim->scheme->options(&sim->model, sim->c); /* again, now that this is known, and before particles are grouped */
    if (!status) status = populate(sim, &lattice, constants, error);
    if (!status && !sim->resumed) edges_warn(sim, &lattice);
    lattice_done(&lattice);
    return status;
}
