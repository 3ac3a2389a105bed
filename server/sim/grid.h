/* SPDX-License-Identifier: BSD-3-Clause */
/* A grid of cells over the particles and which cells can hold neighbours of a cell. */
#ifndef SIM_GRID_H
#define SIM_GRID_H

#include "sim/model.h"
#include "sim/particles.h"

enum { GRID_RUNS_MAX = 3 * 25 };

typedef struct Grid {
    int dim, n[3];
    int width[3], columns[3];     /* of the columns of storage: cells along each direction, and how many columns */
    size_t step[3], stride[3];    /* in the order of storage, to the next cell of a column and to the next column */
    size_t cells;                 /* with those that make all columns as wide */
    double min[3], per_length[3]; /* lower corner [m], cells per metre */
    bool wraps[3];                /* the last cell is beside the first: periodic, fluid outside, or halved (halve()) */
    int reach;                    /* cells on each side that can hold neighbours */
    double ratio;                 /* largest distance of neighbours, in cells */
} Grid;

/* Consecutive cells [first, last] in the order of storage. */
typedef struct Run {
    size_t first, last;
} Run;

/* A grid for neighbours up to `distance` over the domain and the walls. Fluid particles outside, which have left through an
 * open side or broken through a wall, are in the cells that are there again and again beyond it, so that many of them cost no
 * more than inside; near in cells is then not always near in space.
 * A domain that is almost empty has cells in proportion to its particles in the same way. */
Grid grid_make(const Particles *s, const Model *model, double distance, int threads);

/* No grid for n particles has more cells, as long as none of them is outside the domain and the walls around it. */
size_t grid_cells_most(const Model *model, double distance, size_t n);

size_t grid_cell(const Grid *grid, const double x[3]);

/* The runs of cells that can hold neighbours of particles in this cell, each cell once. Returns how many runs. */
int grid_runs(const Grid *grid, size_t cell, Run runs[static GRID_RUNS_MAX]);

#endif
