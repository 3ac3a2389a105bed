/* SPDX-License-Identifier: BSD-3-Clause */
/* The pressure of fluids at rest: in each column of lattice points along gravity, the weight of the fluid above. */
#include "base/array.h"
#include "sim/making.h"
#include "sim/start.h"
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* Columns of points that are laid from where gravity comes from. */
typedef struct Laying {
    MnsSim *sim;
    const Lattice *lattice;
    int axis;
    bool down;  /* gravity points to lower coordinates */
    double gdz; /* pressure over density of one point [m^2/s^2] */
} Laying;

/* Lay a row below what is above its points [Pa], and note the pressure at their middles. */
static void lay_row(const Laying *l, const LatticeRow *row, double *above)
{
    const Model *model = &l->sim->model;
    for (size_t k = 0; k < row->n; k++) {
        const LatticeRun *run = &row->runs[k];
        if ((size_t)run->owner >= model->n_phases) continue;
        const double weight = model->phase[run->owner].rho0 * l->gdz;
        for (size_t q = 0; q < run->n; q++) {
            l->sim->s.p[run->at + q] = above[run->first + q] + 0.5 * weight;
            above[run->first + q] += weight;
        }
    }
}

/* The same where the column is the row. */
static void lay_along(const Laying *l, const LatticeRow *row)
{
    const Model *model = &l->sim->model;
    double above = 0;
    for (size_t k = 0; k < row->n; k++) {
        const LatticeRun *run = &row->runs[l->down ? row->n - 1 - k : k];
        if ((size_t)run->owner >= model->n_phases) continue;
        const double weight = model->phase[run->owner].rho0 * l->gdz;
        for (size_t q = 0; q < run->n; q++) {
            l->sim->s.p[run->at + (l->down ? run->n - 1 - q : q)] = above + 0.5 * weight;
            above += weight;
        }
    }
}

/* One sheet of columns across rows: all rows of one z, or of one y. */
static void lay_sheet(const Laying *l, size_t sheet, double *above)
{
    const Lattice *lattice = l->lattice;
    const size_t n = lattice->n[l->axis];
    memset(above, 0, lattice->n[0] * sizeof *above);
    for (size_t q = 0; q < n && !making_goes_on(&l->sim->making, NULL); q++) {
        const size_t k = l->down ? n - 1 - q : q;
        lay_row(l, &lattice->row[l->axis == 1 ? sheet * n + k : k * lattice->n[1] + sheet], above);
    }
}

static MnsStatus lay(const Laying *l, MnsError *error)
{
    const size_t *n = l->lattice->n, sheets = l->axis == 0 ? l->lattice->rows : l->axis == 1 ? n[2] : n[1];
    const int threads = l->sim->threads;
    double *above = array_new(n[0] * (size_t)threads, sizeof *above);
    if (!above) return mns_fail(error, MNS_E_MEMORY, "no memory for the pressure of %zu columns", n[0]);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t k = 0; k < sheets; k++) {
        if (making_goes_on(&l->sim->making, NULL)) continue;
        if (l->axis == 0) lay_along(l, &l->lattice->row[k]);
        else lay_sheet(l, k, above + (size_t)omp_get_thread_num() * n[0]);
    }
    free(above);
    return making_goes_on(&l->sim->making, error);
}

MnsStatus hydrostatic(MnsSim *sim, const Lattice *lattice, size_t fluid, MnsError *error)
{
    const Model *model = &sim->model;
    const int axis = axis_of(model);
    char at[64];
    snprintf(at, sizeof at, "fluids[%zu].pressure", fluid);
    if (axis < 0)
        return mns_fail_at(error, MNS_E_INVALID, at,
                           "a hydrostatic start needs gravity along one axis at t = 0: found (%g, %g, %g) m/s^2",
                           model->gravity[0], model->gravity[1], model->gravity[2]);
    const Laying laying = {.sim = sim,
                           .lattice = lattice,
                           .axis = axis,
                           .down = model->gravity[axis] < 0,
                           .gdz = fabs(model->gravity[axis]) * lattice->spacing[axis]};
    return lay(&laying, error);
}
