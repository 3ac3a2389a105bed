/* SPDX-License-Identifier: BSD-3-Clause */
/* Size of the surface of a body, and of the body, in a cell whose corners are inside or outside. The cell is cut into simplices, two
 * triangles or six tetrahedra, in which what is given at corners is linear: so surfaces are polygons or polyhedra without gaps
 * between cells. */
#ifndef SIM_PROBES_SIMPLEX_H
#define SIM_PROBES_SIMPLEX_H

#include "sim/probes/measure.h"

enum { VOLUME, SURFACE, FREE_SURFACE }; /* places in the sums; the last without what is on walls */

typedef struct Corner {
    double x[3];
    double inside; /* above 0 in the fluid: the share less a half, or as far as there is wall */
    bool wall;     /* it is the wall that is nearer */
} Corner;

/* Corners in the order of their coordinates, the first axis fastest: four in two dimensions, eight in three.
 *  volume  of the cell [m^dim] */
void simplex_add_cell(int dim, double volume, const Corner *const corner[8], double sums[static TALLIES]);

#endif
