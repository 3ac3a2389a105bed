/* SPDX-License-Identifier: BSD-3-Clause */
/* Put a particle on each point of the lattice that belongs to somebody: identity, mass, density, initial fields. Rows are
 * filled by all threads at once, each where a count of those before it says, so that every bit is the same for any number. */
#include "base/array.h"
#include "sim/lattice.h"
#include "sim/making.h"
#include "sim/motion.h"
#include "sim/state.h"
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const XYZ[] = {"x", "y", "z", NULL};

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

/* Count the particles of all, and of each row those of the rows before it. */
static MnsStatus count(Lattice *lattice, const MnsSim *sim, size_t sizes[GROUPS], MnsError *error)
{
    size_t counts[MNS_MAX_FLUIDS + MNS_MAX_WALLS] = {0};
    uint32_t id = 0;
    for (int g = 0; g < GROUPS; g++) sizes[g] = 0;
    for (size_t r = 0; r < lattice->rows; r++) {
        LatticeRow *row = &lattice->row[r];
        row->id = id;
        memcpy(row->begin, sizes, sizeof row->begin);
        for (size_t k = 0; k < row->n; k++) {
            counts[row->runs[k].owner] += row->runs[k].n;
            sizes[group_of(&sim->model, row->runs[k].owner)] += row->runs[k].n;
            id += row->runs[k].n;
        }
    }
    return check_counts(counts, sim->c, error);
}

/* --- pressure at rest ------------------------------------------------------------------------------------------------- */

/* The axis gravity points along; -1 if it is zero or oblique. */
static int axis_of(const Model *model)
{
    int axis = -1;
    for (int d = 0; d < model->dim; d++)
        if (model->gravity[d] != 0) {
            if (axis >= 0) return -1;
            axis = d;
        }
    return axis;
}

/* Where the particle of a run's point is stored; next: [GROUPS] as the row goes on. */
static size_t next_of(const MnsSim *sim, const LatticeRun *run, size_t next[GROUPS])
{
    return next[group_of(&sim->model, run->owner)]++;
}

/* Lay a row below what is above its points [Pa], and note the pressure at their middles. */
static void lay_row(MnsSim *sim, const LatticeRow *row, double gdz, double *above)
{
    size_t next[GROUPS];
    for (int g = 0; g < GROUPS; g++) next[g] = sim->s.begin[g] + row->begin[g];
    for (size_t k = 0; k < row->n; k++) {
        const LatticeRun *run = &row->runs[k];
        const bool fluid = (size_t)run->owner < sim->model.n_phases;
        const double weight = fluid ? sim->model.phase[run->owner].rho0 * gdz : 0;
        for (size_t q = run->first; q < run->first + run->n; q++) {
            const size_t i = next_of(sim, run, next);
            if (fluid) sim->s.p[i] = above[q] + 0.5 * weight;
            above[q] += weight;
        }
    }
}

/* The same where the column is the row. */
static void lay_along(MnsSim *sim, const LatticeRow *row, double gdz, bool down)
{
    size_t next[GROUPS];
    double above = 0;
    for (int g = 0; g < GROUPS; g++) next[g] = sim->s.begin[g] + row->begin[g];
    if (down) /* from the end: first to where it is stored */
        for (size_t k = 0; k < row->n; k++) next[group_of(&sim->model, row->runs[k].owner)] += row->runs[k].n;
    for (size_t k = 0; k < row->n; k++) {
        const LatticeRun *run = &row->runs[down ? row->n - 1 - k : k];
        size_t *at = &next[group_of(&sim->model, run->owner)];
        if ((size_t)run->owner >= sim->model.n_phases) {
            *at += down ? -(size_t)run->n : (size_t)run->n;
            continue;
        }
        const double weight = sim->model.phase[run->owner].rho0 * gdz;
        for (size_t q = 0; q < run->n; q++) {
            const size_t i = down ? --*at : (*at)++;
            sim->s.p[i] = above + 0.5 * weight;
            above += weight;
        }
    }
}

/* One sheet of columns across rows: all rows of one z, or of one y, from where gravity comes from. */
static void lay_sheet(MnsSim *sim, const Lattice *lattice, int axis, size_t sheet, double gdz, double *above)
{
    const bool down = sim->model.gravity[axis] < 0;
    const size_t n = lattice->n[axis];
    memset(above, 0, lattice->n[0] * sizeof *above);
    for (size_t q = 0; q < n && !making_goes_on(&sim->making, NULL); q++) {
        const size_t k = down ? n - 1 - q : q;
        lay_row(sim, &lattice->row[axis == 1 ? sheet * n + k : k * lattice->n[1] + sheet], gdz, above);
    }
}

/* p of a particle: the weight of the fluid between it and the end of its column that gravity points away from. */
static MnsStatus hydrostatic(MnsSim *sim, const Lattice *lattice, size_t fluid, MnsError *error)
{
    const Model *model = &sim->model;
    const int axis = axis_of(model);
    char at[64];
    snprintf(at, sizeof at, "fluids[%zu].pressure", fluid);
    if (axis < 0)
        return mns_fail_at(error, MNS_E_INVALID, at,
                           "a hydrostatic start needs gravity along one axis at t = 0: found (%g, %g, %g) m/s^2",
                           model->gravity[0], model->gravity[1], model->gravity[2]);
    const double g = fabs(model->gravity[axis]), step = lattice->spacing[axis];
    const size_t sheets = axis == 0 ? lattice->rows : axis == 1 ? lattice->n[2] : lattice->n[1];
    double *above = array_new(lattice->n[0] * (size_t)sim->threads, sizeof *above);
    if (!above) return mns_fail(error, MNS_E_MEMORY, "no memory for the pressure of %zu columns", lattice->n[0]);
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t k = 0; k < sheets; k++) {
        if (making_goes_on(&sim->making, NULL)) continue;
        if (axis == 0) lay_along(sim, &lattice->row[k], g * step, model->gravity[0] < 0);
        else lay_sheet(sim, lattice, axis, k, g * step, above + (size_t)omp_get_thread_num() * lattice->n[0]);
    }
    free(above);
    return making_goes_on(&sim->making, error);
}

/* --- initial fields --------------------------------------------------------------------------------------------------- */

/* Of one fluid, as formulas. */
typedef struct Start {
    FormulaTeam velocity[3], pressure;
    bool at_rest; /* the pressure is hydrostatic, and there already */
} Start;

static MnsStatus start_init(Start *start, const MnsSim *sim, size_t k, const Constants *constants, MnsError *error)
{
    const MnsFluid *f = &sim->c->fluids[k];
    MnsStatus status = MNS_OK;
    start->at_rest = strcmp(f->pressure, "hydrostatic") == 0;
    for (int d = 0; d < sim->c->dim && !status; d++)
        status = formula_team_init(&start->velocity[d], sim->threads, f->velocity[d], XYZ, constants->list,
                                   constants->n, error);
    if (status || start->at_rest) return status;
    return formula_team_init(&start->pressure, sim->threads, f->pressure, XYZ, constants->list, constants->n, error);
}

static void start_done(Start *start)
{
    for (int d = 0; d < 3; d++) formula_team_done(&start->velocity[d]);
    formula_team_done(&start->pressure);
}

/* Why one of the formulas of thread `me` failed, if it did. */
static const char *start_failure(const Start *start, int dim, int me)
{
    const char *why = start->at_rest ? NULL : formula_failure(formula_of(&start->pressure, me));
    for (int d = 0; d < dim && !why; d++) why = formula_failure(formula_of(&start->velocity[d], me));
    return why;
}

/* What filling needs to know besides the particles. */
typedef struct Filling {
    MnsSim *sim;
    const Lattice *lattice;
    const Start *starts; /* [n_fluids]; NULL: what they are comes later */
} Filling;

static bool in_bounds(const Model *model, double ratio)
{
    return ratio > model->density_min && ratio < model->density_max;
}

static MnsStatus fail_fluid(const Filling *f, size_t i, double p, const double x[3], int me, MnsError *error)
{
    const unsigned phase = f->sim->s.phase[i];
    const char *why = start_failure(&f->starts[phase], f->sim->s.dim, me);
    char at[64];
    snprintf(at, sizeof at, "fluids[%u]", phase);
    if (why)
        return mns_fail_at(error, MNS_E_INVALID, at, "a formula of pressure or velocity fails at (%g, %g, %g) m: %s",
                           x[0], x[1], x[2], why);
    if (!isfinite(p) || in_bounds(&f->sim->model, f->sim->s.rho[i] / f->sim->model.phase[phase].rho0))
        return mns_fail_at(error, MNS_E_INVALID, at, "pressure or velocity is not finite at (%g, %g, %g) m", x[0], x[1],
                           x[2]);
    snprintf(at, sizeof at, "fluids[%u].pressure", phase);
    return mns_fail_at(error, MNS_E_INVALID, at,
                       "the pressure %g Pa is too %s for the sound speed at (%g, %g, %g) m: the density would be %.3g "
                       "times that of reference, allowed (%g, %g)",
                       p, p < 0 ? "low" : "high", x[0], x[1], x[2], f->sim->s.rho[i] / f->sim->model.phase[phase].rho0,
                       f->sim->model.density_min, f->sim->model.density_max);
}

/* A particle stands for a cell of the lattice; what is summed there is the density that the pressure asks for. */
static MnsStatus set_fluid(const Filling *f, size_t i, const double x[3], MnsError *error)
{
    const Model *model = &f->sim->model;
    Particles *s = &f->sim->s;
    const Phase *phase = &model->phase[s->phase[i]];
    const Start *start = &f->starts[s->phase[i]];
    const int me = omp_get_thread_num();
    const double p = start->at_rest ? s->p[i] : formula_eval(formula_of(&start->pressure, me), x);
    s->rho[i] = state_density(phase, p);
    s->m[i] = s->rho[i] * model->wall_volume;
    const double ratio = s->rho[i] / phase->rho0;
    bool finite = isfinite(p) && in_bounds(model, ratio);
    for (int d = 0; d < s->dim; d++) {
        s->v[d][i] = formula_eval(formula_of(&start->velocity[d], me), x);
        finite = finite && isfinite(s->v[d][i]);
    }
    return finite ? MNS_OK : fail_fluid(f, i, p, x, me, error);
}

static void set_wall(const Filling *f, size_t i, size_t k)
{
    const Model *model = &f->sim->model;
    Particles *s = &f->sim->s;
    s->rho[i] = model->rho_max;
    s->m[i] = model->rho_max * model->wall_volume;
    for (int d = 0; d < s->dim; d++) s->v[d][i] = model->wall[k].v[d];
}

static MnsStatus fill_row(const Filling *f, size_t r, MnsError *error)
{
    const Model *model = &f->sim->model;
    Particles *s = &f->sim->s;
    const LatticeRow *row = &f->lattice->row[r];
    size_t next[GROUPS];
    uint32_t id = row->id;
    MnsStatus status = making_goes_on(&f->sim->making, error);
    for (int g = 0; g < GROUPS; g++) next[g] = s->begin[g] + row->begin[g];
    for (size_t k = 0; k < row->n && !status; k++) {
        const LatticeRun *run = &row->runs[k];
        for (size_t q = run->first; q < run->first + run->n && !status; q++) {
            const size_t i = next_of(f->sim, run, next);
            double x[3];
            lattice_place(f->lattice, r, q, x);
            s->id[i] = id++;
            s->phase[i] = (uint8_t)run->owner;
            s->vol[i] = model->wall_volume;
            for (int d = 0; d < s->dim; d++) s->x[d][i] = x[d];
            if ((size_t)run->owner < model->n_phases) status = f->starts ? set_fluid(f, i, x, error) : MNS_OK;
            else set_wall(f, i, (size_t)run->owner - model->n_phases);
        }
    }
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
        const MnsStatus failed = fill_row(f, row, &why);
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

/* Count, allocate, fill. */
static MnsStatus populate(MnsSim *sim, Lattice *lattice, const Constants *constants, MnsError *error)
{
    const MnsCase *c = sim->c;
    size_t sizes[GROUPS];
    Start starts[MNS_MAX_FLUIDS] = {0};
    bool laid = false;
    MnsStatus status = count(lattice, sim, sizes, error);
    if (!status) status = making_fits(sim, sizes, false, error);
    if (!status)
        status = particles_init(&sim->s, c->dim, c->n_fluids, sizes, scheme_fields(sim->scheme), sim->model.viscous,
                                &sim->making, error);
    for (size_t k = 0; k < c->n_fluids && !status && !sim->resumed; k++) {
        status = start_init(&starts[k], sim, k, constants, error);
        if (!status && starts[k].at_rest && !laid) status = hydrostatic(sim, lattice, k, error);
        laid = laid || starts[k].at_rest;
    }
    const Filling filling = {.sim = sim, .lattice = lattice, .starts = sim->resumed ? NULL : starts};
    if (!status) status = fill(&filling, error);
    for (size_t k = 0; k < c->n_fluids; k++) start_done(&starts[k]);
    return status;
}

MnsStatus build_particles(MnsSim *sim, const Constants *constants, MnsError *error)
{
    Lattice lattice;
    MnsStatus status = lattice_init(&lattice, sim, constants, error);
    sim->model.filled = sim->model.closed = lattice.filled;
    for (size_t k = 1; k < sim->c->n_walls; k++)
        if (!motion_same(&sim->c->walls[k].motion, &sim->c->walls[0].motion)) sim->model.closed = false;
    sim->scheme->options(&sim->model, sim->c); /* again, now that this is known, and before particles are grouped */
    if (!status) status = populate(sim, &lattice, constants, error);
    lattice_done(&lattice);
    return status;
}
