/* SPDX-License-Identifier: BSD-3-Clause */
/* Place the particles: a lattice fitted to the domain and continued through its sides; what a wall's shape holds of it, down
 * to the kernel's reach, becomes dummy particles, the rest fluid. */
#include "base/array.h"
#include "sim/sim.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const XYZ[] = {"x", "y", "z", NULL};
enum { NOTHING = -1 };

/* The lattice, walls' layers included, and to whom each of its points belongs. */
typedef struct Lattice {
    size_t n[3], points;
    double low[3], spacing[3]; /* of point (0, 0, 0), between points [m] */
    bool filled;               /* no point is left to nobody but inside a wall */
    int16_t *owner;            /* [points] phase, n_phases + wall, or NOTHING */
    double *head;              /* [points] hydrostatic pressure [Pa]; NULL if nobody asks */
} Lattice;

static void place(const Lattice *lattice, size_t point, double x[3])
{
    for (int d = 0; d < 3; d++) {
        x[d] = lattice->low[d] + (double)(point % lattice->n[d]) * lattice->spacing[d];
        point /= lattice->n[d];
    }
}

static MnsStatus lattice_init(Lattice *lattice, const MnsSim *sim, MnsError *error)
{
    const Model *model = &sim->model;
    *lattice = (Lattice){.n = {1, 1, 1}, .points = 1, .spacing = {1, 1, 1}, .filled = true};
    for (int d = 0; d < model->dim; d++) {
        const size_t inside = case_fit(sim->c, d, &lattice->spacing[d]);
        const size_t layers =
            model->period[d] > 0 || model->n_walls == 0 ? 0 : (size_t)ceil(model->kernel.support / lattice->spacing[d]);
        lattice->n[d] = inside + 2 * layers;
        if (layers == 0 && model->period[d] == 0) lattice->filled = false; /* open sides */
        lattice->low[d] = model->min[d] + (0.5 - (double)layers) * lattice->spacing[d];
        lattice->points *= lattice->n[d];
    }
    lattice->owner = array_new(lattice->points, sizeof *lattice->owner);
    return lattice->owner ? MNS_OK
                          : mns_fail(error, MNS_E_MEMORY, "no memory for a lattice of %zu points", lattice->points);
}

static bool in_domain(const Model *model, const double x[3])
{
    for (int d = 0; d < model->dim; d++)
        if (x[d] < model->min[d] || x[d] > model->max[d]) return false;
    return true;
}

/* The wall that holds a point; deeper than the kernel reaches, nobody would feel it. */
static int wall_at(const MnsSim *sim, const double x[3], bool *ret_solid)
{
    double depth = 0;
    int owner = NOTHING;
    for (size_t k = 0; k < sim->model.n_walls; k++) {
        const double inside = -shape_distance(&sim->solid[k], x);
        if (inside > 0 && owner == NOTHING) owner = (int)k;
        depth = fmax(depth, inside);
    }
    *ret_solid = owner != NOTHING;
    /* Corners of a box are farther from its surface than its sides are. */
    const double reach = sim->model.kernel.support * (sim->model.dim == 2 ? 1.5 : 1.8);
    return depth < reach ? owner : NOTHING;
}

static MnsStatus fluid_at(const MnsSim *sim, const Shape *shapes, const double x[3], int *ret, MnsError *error)
{
    const MnsCase *c = sim->c;
    int owner = NOTHING, rest = NOTHING;
    for (size_t k = 0; k < c->n_fluids; k++) {
        if (c->fluids[k].shape.n == 0) rest = (int)k;
        else if (shape_distance(&shapes[k], x) < 0) {
            char at[64];
            snprintf(at, sizeof at, "fluids[%zu].shape", k);
            if (owner != NOTHING)
                return mns_fail_at(error, MNS_E_INVALID, at,
                                   "%s and %s overlap at (%g, %g, %g) m; subtract one from the "
                                   "other, or leave out one shape to fill the rest",
                                   c->fluids[owner].name, c->fluids[k].name, x[0], x[1], x[2]);
            owner = (int)k;
        }
    }
    *ret = owner != NOTHING ? owner : rest;
    return MNS_OK;
}

static MnsStatus assign(Lattice *lattice, const MnsSim *sim, const Shape *shapes, MnsError *error)
{
    for (size_t k = 0; k < lattice->points; k++) {
        double x[3];
        bool solid = false;
        place(lattice, k, x);
        int owner = wall_at(sim, x, &solid);
        if (owner != NOTHING) owner += (int)sim->model.n_phases;
        else if (!solid && in_domain(&sim->model, x)) {
            const MnsStatus status = fluid_at(sim, shapes, x, &owner, error);
            if (status) return status;
        }
        lattice->owner[k] = (int16_t)owner;
        if (owner == NOTHING && !solid) lattice->filled = false;
    }
    return MNS_OK;
}

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

/* p of a point: the weight of the fluid between it and the end of its column that gravity points away from. */
static MnsStatus hydrostatic(Lattice *lattice, const Model *model, size_t fluid, MnsError *error)
{
    const int axis = axis_of(model);
    char at[64];
    snprintf(at, sizeof at, "fluids[%zu].pressure", fluid);
    if (axis < 0)
        return mns_fail_at(error, MNS_E_INVALID, at,
                           "a hydrostatic start needs gravity along one axis at t = 0: found (%g, %g, %g) m/s^2",
                           model->gravity[0], model->gravity[1], model->gravity[2]);
    if (!(lattice->head = array_new(lattice->points, sizeof *lattice->head)))
        return mns_fail(error, MNS_E_MEMORY, "no memory for the pressure of %zu points", lattice->points);
    size_t stride = 1;
    for (int d = 0; d < axis; d++) stride *= lattice->n[d];
    const double g = fabs(model->gravity[axis]), step = lattice->spacing[axis];
    const bool down = model->gravity[axis] < 0;
    for (size_t k = 0; k < lattice->points; k++) {
        if (k / stride % lattice->n[axis] != 0) continue; /* once for each column */
        double above = 0;
        for (size_t q = 0; q < lattice->n[axis]; q++) {
            const size_t point = k + stride * (down ? lattice->n[axis] - 1 - q : q);
            const int owner = lattice->owner[point];
            const double weight =
                owner >= 0 && (size_t)owner < model->n_phases ? model->phase[owner].rho0 * g * step : 0;
            lattice->head[point] = above + 0.5 * weight;
            above += weight;
        }
    }
    return MNS_OK;
}

/* Initial fields of one fluid, as formulas. */
typedef struct Start {
    Formula *velocity[3], *pressure; /* pressure NULL: hydrostatic */
} Start;

static MnsStatus start_init(Start *start, const MnsSim *sim, size_t k, const Constants *constants, MnsError *error)
{
    const MnsFluid *f = &sim->c->fluids[k];
    MnsStatus status = MNS_OK;
    for (int d = 0; d < sim->c->dim && !status; d++)
        status = formula_new(f->velocity[d], XYZ, constants->list, constants->n, &start->velocity[d], error);
    if (!status && strcmp(f->pressure, "hydrostatic") != 0)
        status = formula_new(f->pressure, XYZ, constants->list, constants->n, &start->pressure, error);
    return status;
}

static void start_done(Start *start)
{
    for (int d = 0; d < 3; d++) formula_free(start->velocity[d]);
    formula_free(start->pressure);
}

/* A summed density comes from the masses: they are such that the lattice gives the density that the pressure asks for. */
static MnsStatus set_fluid(MnsSim *sim, size_t i, const Start *start, const double x[3], double head, double volume,
                           double lattice_sum, MnsError *error)
{
    Particles *s = &sim->s;
    const Phase *phase = &sim->model.phase[s->phase[i]];
    const double p = start->pressure ? formula_eval(start->pressure, x) : head;
    s->rho[i] = phase->rho0 + p / (phase->c * phase->c);
    s->m[i] = phase->summation ? s->rho[i] / lattice_sum : s->rho[i] * volume;
    const double ratio = s->rho[i] / phase->rho0;
    bool finite = isfinite(p) && ratio > sim->model.density_min && ratio < sim->model.density_max;
    for (int d = 0; d < s->dim; d++) {
        s->v[d][i] = formula_eval(start->velocity[d], x);
        finite = finite && isfinite(s->v[d][i]);
    }
    if (finite) return MNS_OK;
    char at[64];
    snprintf(at, sizeof at, "fluids[%u]", (unsigned)s->phase[i]);
    return mns_fail_at(error, MNS_E_INVALID, at,
                       "pressure or velocity is not finite, or the pressure %g Pa too low for the "
                       "sound speed, at (%g, %g, %g) m",
                       p, x[0], x[1], x[2]);
}

static MnsStatus fill(MnsSim *sim, const Lattice *lattice, const Start *starts, MnsError *error)
{
    Particles *s = &sim->s;
    const Model *model = &sim->model;
    size_t next[GROUPS] = {s->begin[0], s->begin[1], s->begin[2]};
    const double sum = kernel_lattice_sum(&model->kernel, model->dim, model->cell);
    uint32_t id = 0;
    for (size_t k = 0; k < lattice->points; k++) {
        const int owner = lattice->owner[k];
        if (owner == NOTHING) continue;
        double x[3];
        place(lattice, k, x);
        const size_t i = next[group_of(model, owner)]++;
        s->id[i] = id++;
        s->phase[i] = (uint8_t)owner;
        for (int d = 0; d < s->dim; d++) s->x[d][i] = x[d];
        s->vol[i] = model->wall_volume;
        if ((size_t)owner >= model->n_phases) {
            s->rho[i] = model->rho_max;
            s->m[i] = model->rho_max * model->wall_volume;
            for (int d = 0; d < s->dim; d++) s->v[d][i] = model->wall[(size_t)owner - model->n_phases].v[d];
            continue;
        }
        const MnsStatus status =
            set_fluid(sim, i, &starts[owner], x, lattice->head ? lattice->head[k] : 0, model->wall_volume, sum, error);
        if (status) return status;
    }
    return MNS_OK;
}

/* Count, allocate, fill. */
static MnsStatus populate(MnsSim *sim, Lattice *lattice, const Constants *constants, MnsError *error)
{
    const MnsCase *c = sim->c;
    size_t counts[MNS_MAX_FLUIDS + MNS_MAX_WALLS] = {0}, sizes[GROUPS] = {0};
    for (size_t k = 0; k < lattice->points; k++)
        if (lattice->owner[k] != NOTHING) counts[lattice->owner[k]]++;
    MnsStatus status = check_counts(counts, c, error);
    if (status) return status;
    for (size_t k = 0; k < c->n_fluids + c->n_walls; k++) sizes[group_of(&sim->model, (int)k)] += counts[k];
    Start starts[MNS_MAX_FLUIDS] = {0};
    for (size_t k = 0; k < c->n_fluids && !status; k++) {
        status = start_init(&starts[k], sim, k, constants, error);
        if (!status && !starts[k].pressure && !lattice->head) status = hydrostatic(lattice, &sim->model, k, error);
    }
    if (!status) status = particles_init(&sim->s, c->dim, c->n_fluids, sizes, sim->model.viscous, error);
    if (!status) status = fill(sim, lattice, starts, error);
    for (size_t k = 0; k < c->n_fluids; k++) start_done(&starts[k]);
    return status;
}

MnsStatus build_particles(MnsSim *sim, const Constants *constants, MnsError *error)
{
    const MnsCase *c = sim->c;
    Shape shapes[MNS_MAX_FLUIDS] = {0};
    Lattice lattice = {0};
    MnsStatus status = MNS_OK;
    for (size_t k = 0; k < c->n_fluids && !status; k++) {
        status = shape_init(&shapes[k], &c->fluids[k].shape, c->dim, constants->list, constants->n, "fluids", error);
        if (!status) shape_repeat(&shapes[k], sim->model.period);
    }
    if (!status) status = lattice_init(&lattice, sim, error);
    if (!status) status = assign(&lattice, sim, shapes, error);
    if (!status) status = populate(sim, &lattice, constants, error);
    sim->model.filled = lattice.filled;
    for (size_t k = 0; k < c->n_fluids; k++)
        if (shapes[k].shape) shape_done(&shapes[k]);
    free(lattice.owner);
    free(lattice.head);
    return status;
}
