/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the lattice's points are moved to, so that rows of particles follow an interface. On a lattice as it is, an interface that is not
 * along it starts as a staircase, and an unstable one grows each step of that as well (schemes/interfacial.md). */
#ifndef SIM_DISPLACEMENT_H
#define SIM_DISPLACEMENT_H

#include "sim/sim.h"

typedef struct Displacement {
    FormulaTeam by[3]; /* of x, y, z [m] */
    bool moves;        /* any of them is not "0" */
} Displacement;

/* With displacement_done() also where it fails. MNS_E_INVALID; MNS_E_MEMORY. */
MnsStatus displacement_init(Displacement *displacement, const MnsSim *sim, const Constants *constants, MnsError *error);
void displacement_done(Displacement *displacement);

/* By how much what is around a point grows: its volume, and each direction along itself. */
typedef struct Stretch {
    double volume, along[3];
} Stretch;

/* Move x, to within the period of a domain that repeats itself. MNS_E_INVALID where a formula fails, a volume grows beyond (0.5, 2), or x
 * leaves the domain or enters a wall. Any thread. */
MnsStatus displacement_apply(const Displacement *displacement, const MnsSim *sim, double x[3], Stretch *stretch,
                             MnsError *error);

#endif
