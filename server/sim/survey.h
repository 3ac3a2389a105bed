/* SPDX-License-Identifier: BSD-3-Clause */
/* To whom a place belongs, for who goes over the lattice with a thread of his own. */
#ifndef SIM_SURVEY_H
#define SIM_SURVEY_H

#include "sim/lattice.h"

enum { NOTHING = -1 };

/* What one thread needs: formulas of its own, and room for a row. */
typedef struct Surveyor {
    const MnsSim *sim;
    Shape shape[MNS_MAX_FLUIDS];
    LatticeRun *runs; /* [n[0]] */
    size_t n;
    bool *edge;      /* [n[0]] does some surface go through the cell of a point? */
    double diagonal; /* half of that of a cell: a surface farther from its middle is not in it [m] */
    bool gap;        /* a point of some row is nobody's, and not inside a wall */
} Surveyor;

/* The fluid that a place belongs to by the case's shapes, on the lattice or off it; NOTHING: none. */
int survey_fluid(const Surveyor *v, const double x[3]);

#endif
