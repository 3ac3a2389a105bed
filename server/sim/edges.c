/* SPDX-License-Identifier: BSD-3-Clause */
/* A particle stands for a whole cell of the lattice, so that a fluid whose edge goes through cells has more or less of them than its shape
 * holds. What a cell holds is counted by points within it: few, which show whether it is one fluid's, and where it is not, many. A shape knows how far
 * away its surface is, and so which cells it may go through; the surface of a formula is where cells beside each other differ. */
#include "sim/edges.h"
#include <math.h>
#include <omp.h>
#include <string.h>

static const double MASS_DEVIATION = 0.01; /* beyond which it is said */
enum { FEW = 16, MANY = 128 };

/* Point k of n within a cell, -1/2 to 1/2: of a lattice of its own, turned so that along each direction all n are at places apart and evenly. */
static void place_within(size_t k, size_t n, int dim, double ret[3])
{
    static const size_t turn[2][3] = {{1, 9, 0}, {1, 7, 49}}; /* balls of 1.5 radii and more come out within 0.2 % */
    for (int d = 0; d < 3; d++) ret[d] = ((double)(k * turn[dim - 2][d] % n) + 0.5) / (double)n - 0.5;
}

static int fluid_within(const Surveyor *v, const double middle[3], const double within[3])
{
    const Model *model = &v->sim->model;
    double x[3] = {middle[0], middle[1], middle[2]};
    for (int d = 0; d < model->dim; d++) x[d] += within[d] * model->cell[d];
    return survey_fluid(v, x);
}

/* Is all of a cell of one fluid, or of none, as far as its corners and a few points show? */
static bool is_whole(const Surveyor *v, const double middle[3], int owner)
{
    const int dim = v->sim->model.dim;
    for (int k = 0; k < 1 << dim; k++) {
        const double within[3] = {k & 1 ? 0.49 : -0.49, k & 2 ? 0.49 : -0.49, k & 4 ? 0.49 : -0.49};
        if (fluid_within(v, middle, within) != owner) return false;
    }
    for (size_t k = 0; k < FEW; k++) {
        double within[3];
        place_within(k, FEW, dim, within);
        if (fluid_within(v, middle, within) != owner) return false;
    }
    return true;
}

static void count(const Surveyor *v, const double middle[3], size_t *counts)
{
    for (size_t k = 0; k < MANY; k++) {
        double within[3];
        place_within(k, MANY, v->sim->model.dim, within);
        const int fluid = fluid_within(v, middle, within);
        if (fluid != NOTHING) counts[fluid]++;
    }
}

/* The fluid of point k, and the last point up to which the row has no other; *at goes along its runs. */
static int fluid_from(const LatticeRow *row, size_t k, size_t n, size_t phases, size_t *at, size_t *ret_end)
{
    while (*at < row->n && k >= (size_t)row->runs[*at].first + row->runs[*at].n) ++*at;
    *ret_end = n;
    if (*at == row->n) return NOTHING;
    const LatticeRun *run = &row->runs[*at];
    *ret_end = k < run->first ? run->first : (size_t)run->first + run->n;
    return k >= run->first && (size_t)run->owner < phases ? run->owner : NOTHING;
}

static void mark(Surveyor *v, size_t n, size_t first, size_t end)
{
    for (size_t k = first > 0 ? first - 1 : 0; k < end + 1 && k < n; k++) v->edge[k] = true;
}

/* Mark the points of a row that differ from those of another, or from the next one of their own, and what is beside them. */
static void mark_differences(Surveyor *v, const Lattice *lattice, const LatticeRow *row, const LatticeRow *other)
{
    const size_t n = lattice->n[0], phases = v->sim->model.n_phases;
    size_t mine = 0, its = 0;
    for (size_t k = 0; k < n;) {
        size_t end, its_end;
        const int a = fluid_from(row, k, n, phases, &mine, &end), b = fluid_from(other, k, n, phases, &its, &its_end);
        const size_t until = end < its_end ? end : its_end;
        if (a != b) mark(v, n, k, until);
        if (row == other && k > 0) mark(v, n, k, k);
        k = until;
    }
}

/* With rows beyond periodic sides; beyond others there is nothing that a fluid has. */
static void mark_around(Surveyor *v, const Lattice *lattice, size_t row)
{
    const Model *model = &v->sim->model;
    const size_t ny = lattice->n[1], nz = lattice->n[2], y = row % ny, z = row / ny;
    const size_t around_y = ny > 1 ? 3 : 1, around_z = nz > 1 ? 3 : 1;
    for (size_t a = 0; a < around_z; a++)
        for (size_t b = 0; b < around_y; b++) {
            const size_t its_y = (y + ny + b - around_y / 2) % ny, its_z = (z + nz + a - around_z / 2) % nz;
            const bool wraps_y = b == 0 ? its_y > y : its_y < y, wraps_z = a == 0 ? its_z > z : its_z < z;
            if ((wraps_y && !(model->period[1] > 0)) || (wraps_z && !(model->period[2] > 0))) continue;
            mark_differences(v, lattice, &lattice->row[row], &lattice->row[its_z * ny + its_y]);
        }
    if (model->period[0] > 0) v->edge[0] = v->edge[lattice->n[0] - 1] = true;
}

static bool has_formulas(const MnsCase *c)
{
    for (size_t k = 0; k < c->n_fluids; k++)
        for (size_t p = 0; p < c->fluids[k].shape.n; p++)
            if (c->fluids[k].shape.parts[p].primitive == MNS_FORMULA) return true;
    return false;
}

/* Points within the cells of a row that each fluid has, many for each cell. */
static void measure_row(Surveyor *v, const Lattice *lattice, size_t r, bool formulas, size_t *counts)
{
    const LatticeRow *row = &lattice->row[r];
    const size_t n = lattice->n[0], phases = v->sim->model.n_phases;
    memset(v->edge, 0, n * sizeof *v->edge);
    for (size_t k = 0; k < row->n_edges; k++)
        memset(v->edge + row->edges[k].first, 1, row->edges[k].n * sizeof *v->edge);
    if (formulas) mark_around(v, lattice, r);
    for (size_t k = 0, at = 0, end; k < n; k++) {
        const int fluid = fluid_from(row, k, n, phases, &at, &end);
        double x[3];
        if (v->edge[k]) lattice_place(lattice, r, k, x);
        if (v->edge[k] && !is_whole(v, x, fluid)) count(v, x, counts);
        else if (fluid != NOTHING) counts[fluid] += MANY;
    }
}

void edges_measure(Lattice *lattice, Surveyor *surveyors, int threads)
{
    const MnsCase *c = surveyors[0].sim->c;
    const bool formulas = has_formulas(c);
    size_t counts[MNS_MAX_FLUIDS] = {0};
#pragma omp parallel for schedule(dynamic, 8) reduction(+ : counts) num_threads(threads)
    for (size_t row = 0; row < lattice->rows; row++)
        measure_row(&surveyors[omp_get_thread_num()], lattice, row, formulas, counts);
    for (size_t k = 0; k < c->n_fluids; k++) lattice->held[k] = (double)counts[k] / (double)MANY;
}

void edges_warn(MnsSim *sim, const Lattice *lattice)
{
    size_t cells[MNS_MAX_FLUIDS] = {0};
    for (size_t r = 0; r < lattice->rows; r++)
        for (size_t k = 0; k < lattice->row[r].n; k++) {
            const LatticeRun *run = &lattice->row[r].runs[k];
            if ((size_t)run->owner < sim->model.n_phases) cells[run->owner] += run->n;
        }
    for (size_t k = 0; k < sim->c->n_fluids; k++) {
        const double off = (double)cells[k] / lattice->held[k] - 1;
        if (!(lattice->held[k] > 0) || !(fabs(off) > MASS_DEVIATION)) continue;
        plan_warn(sim,
                  "fluids[%zu]%s: %.60s starts with %.1f %% %s mass than its shape holds, as its edges are off the "
                  "lattice of spacing %.4g m: put them on it, or raise the resolution",
                  k, sim->c->fluids[k].shape.n ? ".shape" : "", sim->c->fluids[k].name, 100 * fabs(off),
                  off > 0 ? "more" : "less", sim->model.dx);
    }
}
