/* SPDX-License-Identifier: BSD-3-Clause */
/* Size of the surface of a body, and of the body, in a cell whose corners are inside or outside. The cell is cut into simplices,
 * triangles or tetrahedra, in which what is given at corners is linear: so surfaces are polygons or polyhedra without gaps
 * between cells. It is cut along each of its diagonals in turn, and the mean counts: one alone has another surface for a body's
 * mirror image, by some per cent. */
#ifndef SIM_PROBES_SIMPLEX_H
#define SIM_PROBES_SIMPLEX_H

#include "sim/probes/measure.h"

enum { VOLUME, SURFACE, FREE_SURFACE }; /* places in the sums; the last without what is on walls or within */

typedef struct Corner {
    double x[3];
    double fluid, open; /* shares less a half: above 0 in the fluid, outside walls */
} Corner;

/* Corners in the order of their coordinates, the first axis fastest: four in two dimensions, eight in three.
 *  volume  of the cell [m^dim] */
void simplex_add_cell(int dim, double volume, const Corner corner[8], double sums[static TALLIES]);

#endif
