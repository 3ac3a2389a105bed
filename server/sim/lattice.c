/* SPDX-License-Identifier: BSD-3-Clause */
/* To whom the points of the starting lattice belong: what a wall's shape holds, down to the kernel's reach, to the wall, the
 * rest to fluids. Rows are shared out among threads; the answer does not depend on who has which. */
#include "sim/edges.h"
#include "sim/making.h"
#include "sim/solid.h"
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void lattice_place(const Lattice *lattice, size_t row, size_t k, double x[3])
{
    const size_t index[3] = {k, row % lattice->n[1], row / lattice->n[1]};
    for (int d = 0; d < 3; d++) x[d] = lattice->low[d] + (double)index[d] * lattice->spacing[d];
}

const LatticeRun *lattice_run(const LatticeRow *row, size_t k)
{
    size_t low = 0, high = row->n; /* runs before low end before the point, those from high on begin after it */
    while (low < high) {
        const size_t middle = (low + high) / 2;
        const LatticeRun *run = &row->runs[middle];
        if (k < run->first) high = middle;
        else if (k >= (size_t)run->first + run->n) low = middle + 1;
        else return run;
    }
    return NULL;
}

static void fit(Lattice *lattice, const MnsSim *sim)
{
    const Model *model = &sim->model;
    *lattice = (Lattice){.n = {1, 1, 1}, .spacing = {1, 1, 1}, .filled = true};
    for (int d = 0; d < model->dim; d++) {
        const size_t inside = case_fit(sim->c, d, &lattice->spacing[d]);
        const size_t layers =
            model->period[d] > 0 || model->n_walls == 0 ? 0 : (size_t)ceil(model->kernel.support / lattice->spacing[d]);
        lattice->n[d] = inside + 2 * layers;
        if (layers == 0 && model->period[d] == 0) lattice->filled = false;
        lattice->low[d] = model->min[d] + (0.5 - (double)layers) * lattice->spacing[d];
    }
    lattice->rows = lattice->n[1] * lattice->n[2];
}

static void surveyor_done(Surveyor *v)
{
    for (size_t k = 0; k < MNS_MAX_FLUIDS; k++)
        if (v->shape[k].shape) shape_done(&v->shape[k]);
    free(v->runs);
    free(v->edge);
}

static MnsStatus surveyor_init(Surveyor *v, const Lattice *lattice, const MnsSim *sim, const Constants *constants,
                               MnsError *error)
{
    const MnsCase *c = sim->c;
    *v = (Surveyor){
        .sim = sim, .runs = calloc(lattice->n[0], sizeof *v->runs), .edge = calloc(lattice->n[0], sizeof *v->edge)};
    for (int d = 0; d < c->dim; d++) v->diagonal += 0.25 * sim->model.cell[d] * sim->model.cell[d];
    v->diagonal = sqrt(v->diagonal);
    if (!v->runs || !v->edge) return mns_fail(error, MNS_E_MEMORY, "no memory for a row of %zu points", lattice->n[0]);
    for (size_t k = 0; k < c->n_fluids; k++) {
        const MnsStatus status = shape_init(&v->shape[k], &c->fluids[k].shape, c->dim, constants->list, constants->n,
                                            "fluids", error); /* the check has been here */
        if (status) return status;
        shape_repeat(&v->shape[k], sim->model.period);
    }
    return MNS_OK;
}

static bool in_domain(const Model *model, const double x[3])
{
    for (int d = 0; d < model->dim; d++)
        if (x[d] < model->min[d] || x[d] > model->max[d]) return false;
    return true;
}

/* What is around a place. */
typedef struct Place {
    int wall;       /* that holds it; deeper than the kernel reaches it would have no effect */
    size_t nearest; /* wall */
    double away;    /* from it, negative inside [m] */
    double edge;    /* from the nearest surface of all that says how far it is [m] */
} Place;

static Place look_around(const MnsSim *sim, const double x[3])
{
    Place place = {.wall = NOTHING, .away = INFINITY, .edge = INFINITY};
    for (size_t k = 0; k < sim->model.n_walls; k++) {
        const double distance = shape_distance(&sim->solid[k], x);
        if (distance < 0 && place.wall == NOTHING) place.wall = (int)k;
        if (distance < place.away) place.nearest = k;
        place.away = fmin(place.away, distance);
        place.edge = fmin(place.edge, fabs(distance));
    }
    /* Corners of a box are farther from its surface than its sides are. */
    const double reach = sim->model.kernel.support * (sim->model.dim == 2 ? 1.5 : 1.8);
    if (-place.away >= reach) place.wall = NOTHING;
    return place;
}

static MnsStatus fail_overlap(const MnsCase *c, size_t one, size_t other, const double x[3], MnsError *error)
{
    char at[64];
    snprintf(at, sizeof at, "fluids[%zu].shape", other);
    return mns_fail_at(
        error, MNS_E_INVALID, at,
        "%s and %s overlap at (%g, %g, %g) m; subtract one from the other, or leave out one shape to fill "
        "the rest",
        c->fluids[one].name, c->fluids[other].name, x[0], x[1], x[2]);
}

static MnsStatus fluid_at(const Surveyor *v, const double x[3], Place *place, int *ret, MnsError *error)
{
    const MnsCase *c = v->sim->c;
    int owner = NOTHING, rest = NOTHING;
    for (size_t k = 0; k < c->n_fluids; k++) {
        if (c->fluids[k].shape.n == 0) {
            rest = (int)k;
            continue;
        }
        const double distance = shape_distance(&v->shape[k], x);
        place->edge = fmin(place->edge, fabs(distance));
        if (!(distance < 0)) continue;
        if (owner != NOTHING) return fail_overlap(c, (size_t)owner, k, x, error);
        owner = (int)k;
    }
    *ret = owner != NOTHING ? owner : rest;
    return MNS_OK;
}

int survey_fluid(const Surveyor *v, const double x[3])
{
    const MnsCase *c = v->sim->c;
    int rest = NOTHING;
    if (!in_domain(&v->sim->model, x)) return NOTHING;
    for (size_t k = 0; k < v->sim->model.n_walls; k++)
        if (shape_distance(&v->sim->solid[k], x) < 0) return NOTHING;
    for (size_t k = 0; k < c->n_fluids; k++) {
        if (c->fluids[k].shape.n == 0) rest = (int)k;
        else if (shape_distance(&v->shape[k], x) < 0) return (int)k;
    }
    return rest;
}

static MnsStatus owner_of(Surveyor *v, const double x[3], bool *ret_edge, int *ret, MnsError *error)
{
    const Model *model = &v->sim->model;
    Place place = look_around(v->sim, x);
    const bool solid = place.away < 0, room = !solid && in_domain(model, x);
    *ret = place.wall == NOTHING ? NOTHING : place.wall + (int)model->n_phases;
    MnsStatus status = room ? fluid_at(v, x, &place, ret, error) : MNS_OK;
    if (!status && room) status = solid_check(v->sim, x, place.away, place.nearest, error);
    if (!solid && *ret == NOTHING) v->gap = true;
    *ret_edge = place.edge < v->diagonal;
    return status;
}

/* Has a condition failed somewhere in the row? */
static MnsStatus check_conditions(const Surveyor *v, const double x[3], MnsError *error)
{
    for (size_t k = 0; k < v->sim->c->n_fluids; k++)
        for (size_t p = 0; p < v->shape[k].shape->n; p++) {
            const Formula *formula = v->shape[k].formulas[p];
            const char *why = formula ? formula_failure(formula) : NULL;
            char at[96];
            if (!why) continue;
            snprintf(at, sizeof at, "fluids[%zu].shape[%zu].formula", k, p);
            return mns_fail_at(error, MNS_E_INVALID, at, "it fails for some x at y = %g m, z = %g m: %s", x[1], x[2],
                               why);
        }
    return MNS_OK;
}

static MnsStatus survey(Surveyor *v, const Lattice *lattice, size_t row, MnsError *error)
{
    double x[3];
    MnsStatus status = MNS_OK;
    int last = NOTHING;
    v->n = 0;
    for (size_t k = 0; k < lattice->n[0] && !status; k++) {
        int owner = NOTHING;
        lattice_place(lattice, row, k, x);
        status = owner_of(v, x, &v->edge[k], &owner, error);
        if (owner == NOTHING) last = NOTHING;
        else if (owner == last) v->runs[v->n - 1].n++;
        else v->runs[v->n++] = (LatticeRun){.first = (uint32_t)k, .n = 1, .owner = last = owner, .weighs_as = owner};
    }
    const MnsStatus failed = check_conditions(v, x, error); /* which may be why fluids overlap */
    return failed ? failed : status;
}

/* Count the points of the row that are somebody's. There are enough of them for a verdict long before all rows are done. */
static MnsStatus add_up(const Surveyor *v, Lattice *lattice, MnsError *error)
{
    size_t points = 0, sum;
    for (size_t k = 0; k < v->n; k++) points += v->runs[k].n;
#pragma omp atomic capture
    sum = lattice->points += points;
    if ((double)sum <= lattice->most) return MNS_OK;
    return making_fits(v->sim, (size_t[GROUPS]){[GROUP_CONTINUITY] = sum}, true, error);
}

static MnsStatus keep(const Surveyor *v, LatticeRow *row, MnsError *error)
{
    if (!v->n) return MNS_OK;
    row->runs = malloc(v->n * sizeof *row->runs);
    if (!row->runs) return mns_fail(error, MNS_E_MEMORY, "no memory for the lattice");
    memcpy(row->runs, v->runs, v->n * sizeof *row->runs);
    row->n = v->n;
    return MNS_OK;
}

/* And where surfaces go through its cells, as runs. */
static MnsStatus keep_edges(const Surveyor *v, size_t n, LatticeRow *row, MnsError *error)
{
    size_t runs = 0;
    for (size_t k = 0; k < n; k++) runs += v->edge[k] && !(k && v->edge[k - 1]);
    if (!runs) return MNS_OK;
    row->edges = malloc(runs * sizeof *row->edges);
    if (!row->edges) return mns_fail(error, MNS_E_MEMORY, "no memory for the lattice");
    for (size_t k = 0; k < n; k++) {
        if (!v->edge[k]) continue;
        if (!(k && v->edge[k - 1])) row->edges[row->n_edges++] = (LatticeEdge){.first = (uint32_t)k};
        row->edges[row->n_edges - 1].n++;
    }
    return MNS_OK;
}

/* Each row is done by somebody, unless one before it has failed: so the first failure is the same for any number of threads,
 * but for that of too many particles, which is told as soon as it is known. */
static MnsStatus survey_all(Lattice *lattice, Surveyor *surveyors, int threads, MnsError *error)
{
    size_t bad = SIZE_MAX;
    MnsStatus status = MNS_OK;
#pragma omp parallel for schedule(dynamic, 8) num_threads(threads)
    for (size_t row = 0; row < lattice->rows; row++) {
        MnsError why;
        size_t first_bad;
#pragma omp atomic read
        first_bad = bad;
        if (row > first_bad) continue;
        Surveyor *mine = &surveyors[omp_get_thread_num()];
        MnsStatus failed = making_goes_on(&mine->sim->making, &why);
        if (!failed) failed = survey(mine, lattice, row, &why);
        if (!failed) failed = add_up(mine, lattice, &why);
        if (!failed) failed = keep(mine, &lattice->row[row], &why);
        if (!failed) failed = keep_edges(mine, lattice->n[0], &lattice->row[row], &why);
        if (!failed) continue;
#pragma omp critical(lattice_failed)
        if (row < bad) {
#pragma omp atomic write
            bad = row;
            status = failed;
            if (error) *error = why;
        }
    }
    return status;
}

MnsStatus lattice_init(Lattice *lattice, const MnsSim *sim, const Constants *constants, MnsError *error)
{
    const size_t threads = (size_t)sim->threads;
    MnsStatus status = MNS_OK;
    fit(lattice, sim);
    lattice->most = making_most(sim);
    const double bytes = (double)lattice->rows * sizeof *lattice->row;
    if (!sim->making.memory || bytes <= (double)sim->making.memory)
        lattice->row = calloc(lattice->rows, sizeof *lattice->row);
    Surveyor *surveyors = calloc(threads, sizeof *surveyors);
    if (!lattice->row || !surveyors)
        status = mns_fail(error, MNS_E_MEMORY, "no memory for a lattice of %zu rows", lattice->rows);
    for (size_t k = 0; k < threads && !status; k++)
        status = surveyor_init(&surveyors[k], lattice, sim, constants, error);
    if (!status) status = survey_all(lattice, surveyors, sim->threads, error);
    if (!status && !sim->resumed) edges_measure(lattice, surveyors, sim->threads);
    for (size_t k = 0; surveyors && k < threads; k++) {
        if (surveyors[k].gap) lattice->filled = false;
        surveyor_done(&surveyors[k]);
    }
    free(surveyors);
    return status;
}

void lattice_done(Lattice *lattice)
{
    for (size_t k = 0; lattice->row && k < lattice->rows; k++) {
        free(lattice->row[k].runs);
        free(lattice->row[k].edges);
    }
    free(lattice->row);
    lattice->row = NULL;
}
