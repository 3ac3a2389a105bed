/* SPDX-License-Identifier: BSD-3-Clause */
/* The lattice particles start on: fitted to the domain, continued through the sides that walls may close, and to whom each of
 * its points belongs. What is kept of it are runs of points that belong to somebody, so that empty space costs nothing. */
#ifndef SIM_LATTICE_H
#define SIM_LATTICE_H

#include "sim/sim.h"

/* Consecutive points along x that belong to one fluid or wall. */
typedef struct LatticeRun {
    uint32_t first, n;
    int owner;      /* fluid, or number of fluids + wall */
    size_t at;      /* where its first particle is stored */
    uint32_t body;  /* the drop or bubble it is in, counted from 1; 0: none */
    int weighs_as;  /* owner, but in a drop or bubble the fluid around it, for the pressure of what is beside */
    short image[3]; /* periods by which it is beside the rest of its drop or bubble */
} LatticeRun;

/* Consecutive points along x through whose cells some surface goes. */
typedef struct LatticeEdge {
    uint32_t first, n;
} LatticeEdge;

/* All points of one y and z. */
typedef struct LatticeRow {
    LatticeRun *runs; /* [n] */
    size_t n;
    LatticeEdge *edges; /* [n_edges], but those of formulas */
    size_t n_edges;
    uint32_t id; /* of its first particle */
} LatticeRow;

typedef struct Lattice {
    size_t n[3], rows;           /* points along each direction; rows, y before z */
    double low[3], spacing[3];   /* of point (0, 0, 0), between points [m] */
    LatticeRow *row;             /* [rows] */
    size_t points;               /* that belong to a fluid or a wall */
    double most;                 /* that there is memory for */
    double held[MNS_MAX_FLUIDS]; /* cells that the shapes of fluids hold, with parts of cells; 0: not measured */
    bool filled;                 /* no point is left to nobody but inside a wall, and no side is open */
} Lattice;

/* Find out to whom all points belong. MNS_E_INVALID if fluids overlap or a formula fails, or a wall is too thin
 * (solid_check), at the first such point whatever the number of threads; MNS_E_MEMORY. */
MnsStatus lattice_init(Lattice *lattice, const MnsSim *sim, const Constants *constants, MnsError *error);
void lattice_done(Lattice *lattice);

/* Place of point k of a row. */
void lattice_place(const Lattice *lattice, size_t row, size_t k, double x[3]);

/* The run that point k of a row is in; NULL if it is nobody's. */
const LatticeRun *lattice_run(const LatticeRow *row, size_t k);

#endif
