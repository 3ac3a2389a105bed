/* SPDX-License-Identifier: BSD-3-Clause */
/* The drops and bubbles of a fluid at the start: what of its lattice points hangs together, across periodic seams too. */
#ifndef SIM_BODIES_H
#define SIM_BODIES_H

#include "sim/lattice.h"

typedef struct Body {
    size_t fluid, around; /* the fluid it is of; the one that most of the points beside it belong to */
    size_t points;
    unsigned mirrors;      /* that it touches, a bit each (mirrors.h) */
    double centre[3];      /* of its points, beyond the domain perhaps where it reaches across a seam [m] */
    double min[3], max[3]; /* of its points, in the same way [m] */
    unsigned beside;       /* fluids that it touches, a bit each */
    unsigned spans;        /* periodic directions around which it reaches to itself, a bit each */
    /* Of those that bodies_survey() found: sides 2 d and 2 d + 1 where it lies against a wall, a bit each, and which of these walls
     * are not flat; does it touch an empty place, or an end of the domain? */
    unsigned walls, uneven;
    bool open;
} Body;

typedef struct Bodies {
    Body *body; /* [n] */
    size_t n;
} Bodies;

/* Add those of one fluid, and note in the runs of the lattice which is whose. Points hang together across edges and corners
 * too. MNS_E_INVALID if one touches no other fluid, or reaches around a periodic direction to itself; MNS_E_MEMORY;
 * MNS_E_INTERRUPTED. */
MnsStatus bodies_find(Bodies *bodies, const MnsSim *sim, Lattice *lattice, size_t fluid, MnsError *error);
void bodies_done(Bodies *bodies);

/* All parts of a fluid, whatever they are, and leave the lattice as it was. MNS_E_MEMORY, MNS_E_INTERRUPTED. */
MnsStatus bodies_survey(Bodies *bodies, const MnsSim *sim, Lattice *lattice, size_t fluid, MnsError *error);

/* Its points with those behind the mirrors that cut it. */
size_t bodies_whole(const Body *body);

/* Radius of the disc or ball of as many points [m]. */
double bodies_radius(const Model *model, size_t points);

#endif
