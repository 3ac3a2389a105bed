/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the sides of the domain are now: walls that close them take them along, as a tank does, however it is told. */
#ifndef SIM_SIDES_H
#define SIM_SIDES_H

#include "sim/lattice.h"

/* While particles are placed: which walls close which sides. MNS_E_MEMORY. */
MnsStatus sides_find(MnsSim *sim, const Lattice *lattice, MnsError *error);

/* Lower and upper end along each direction [m], infinite where it is periodic. Returns a wall that takes all of them along, -1: there is none. */
int sides_now(const MnsSim *sim, double ret_min[3], double ret_max[3]);

#endif
