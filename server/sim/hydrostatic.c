/* SPDX-License-Identifier: BSD-3-Clause */
/* The pressure of fluids at rest. Columns of lattice points along gravity are laid from where gravity comes from, each point
 * below the weight of what is over it (s.rho: heights yet, over that of a cell), and begin anew under a wall or where nothing is. */
#include "sim/hydrostatic.h"
#include "base/array.h"
#include "sim/making.h"
#include "sim/start.h"
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

int hydrostatic_axis(const Model *model)
{
    int axis = -1;
    for (int d = 0; d < model->dim; d++)
        if (model->gravity[d] != 0) {
            if (axis >= 0) return -1;
            axis = d;
        }
    return axis;
}

typedef enum Over { OVER_NOTHING, OVER_WALL, OVER_FLUID } Over;

/* A column, as far as it has been laid. */
typedef struct Column {
    double above; /* weight of the fluid that reaches down to here [Pa] */
    Over over;    /* the last point */
} Column;

/* Where columns of fluid begin. */
typedef struct Tops {
    size_t n, open;     /* of all; of those with nothing over them */
    size_t first, last; /* levels of the others, counted along gravity */
} Tops;

static const Tops NO_TOPS = {.first = SIZE_MAX};

static void add_top(Tops *tops, Over over, size_t level)
{
    tops->n++;
    if (over == OVER_NOTHING) tops->open++;
    else if (level < tops->first) tops->first = level;
    if (over == OVER_WALL && level > tops->last) tops->last = level;
}

static void merge_tops(Tops *tops, const Tops *more)
{
    tops->n += more->n;
    tops->open += more->open;
    if (more->first < tops->first) tops->first = more->first;
    if (more->last > tops->last) tops->last = more->last;
}

/* One more point of fluid; the pressure at its middle. */
static double lay_point(Column *column, double weight, size_t level, Tops *tops)
{
    if (column->over != OVER_FLUID) add_top(tops, column->over, level);
    const double p = column->above + 0.5 * weight;
    column->above += weight;
    column->over = OVER_FLUID;
    return p;
}

/* Of particle i, which is higher or lower than a cell where the lattice was moved. */
static double weight_of(const Laying *l, const LatticeRun *run, size_t i)
{
    return l->sim->model.phase[run->weighs_as].rho0 * l->gdz * l->sim->s.rho[i];
}

/* The points of a row, each of another column. */
static void lay_row(const Laying *l, const LatticeRow *row, size_t level, Column *columns, Tops *tops)
{
    size_t q = 0;
    for (size_t k = 0; k < row->n; k++) {
        const LatticeRun *run = &row->runs[k];
        while (q < run->first) columns[q++] = (Column){0, OVER_NOTHING};
        if (is_fluid(l, run))
            for (size_t i = run->at; i < run->at + run->n; i++)
                l->sim->s.p[i] = lay_point(&columns[q++], weight_of(l, run, i), level, tops);
        else
            while (q < (size_t)run->first + run->n) columns[q++] = (Column){0, OVER_WALL};
    }
    while (q < l->lattice->n[0]) columns[q++] = (Column){0, OVER_NOTHING};
}

/* A row that is a column. */
static void lay_along(const Laying *l, const LatticeRow *row, Tops *tops)
{
    const size_t n = l->lattice->n[0];
    Column column = {0, OVER_NOTHING};
    for (size_t level = 0; level < n; level++) {
        const size_t q = l->down ? n - 1 - level : level;
        const LatticeRun *run = lattice_run(row, q);
        const size_t i = run ? run->at + q - run->first : 0;
        if (is_fluid(l, run)) l->sim->s.p[i] = lay_point(&column, weight_of(l, run, i), level, tops);
        else column = (Column){0, run ? OVER_WALL : OVER_NOTHING};
    }
}

/* One sheet of columns across rows: all rows of one z, or of one y. */
static void lay_sheet(const Laying *l, size_t sheet, Column *columns, Tops *tops)
{
    const Lattice *lattice = l->lattice;
    const size_t n = lattice->n[l->axis];
    for (size_t q = 0; q < lattice->n[0]; q++) columns[q] = (Column){0, OVER_NOTHING};
    for (size_t level = 0; level < n && !making_goes_on(&l->sim->making, NULL); level++) {
        const size_t k = l->down ? n - 1 - level : level;
        lay_row(l, &lattice->row[l->axis == 1 ? sheet * n + k : k * lattice->n[1] + sheet], level, columns, tops);
    }
}

static MnsStatus lay(const Laying *l, Tops *tops, MnsError *error)
{
    const size_t *n = l->lattice->n, sheets = l->axis == 0 ? l->lattice->rows : l->axis == 1 ? n[2] : n[1];
    const int threads = l->sim->threads;
    Column *columns = array_new(n[0] * (size_t)threads, sizeof *columns);
    if (!columns) return mns_fail(error, MNS_E_MEMORY, "no memory for the pressure of %zu columns", n[0]);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t k = 0; k < sheets; k++) {
        Tops mine = NO_TOPS;
        if (making_goes_on(&l->sim->making, NULL)) continue;
        if (l->axis == 0) lay_along(l, &l->lattice->row[k], &mine);
        else lay_sheet(l, k, columns + (size_t)omp_get_thread_num() * n[0], &mine);
#pragma omp critical(hydrostatic_tops)
        merge_tops(tops, &mine);
    }
    free(columns);
    return making_goes_on(&l->sim->making, error);
}

MnsStatus start_hydrostatic(MnsSim *sim, const Lattice *lattice, size_t fluid, MnsError *error)
{
    const Model *model = &sim->model;
    const int axis = hydrostatic_axis(model);
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
    Tops tops = NO_TOPS;
    const MnsStatus status = lay(&laying, &tops, error);
    const bool all_begin = tops.open == tops.n || (tops.open == 0 && tops.first == tops.last);
    return status || all_begin ? status : hydrostatic_hang(&laying, tops.n, error);
}
