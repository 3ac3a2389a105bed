/* SPDX-License-Identifier: BSD-3-Clause */
/* All walls together as one solid, where the case puts them. */
#ifndef SIM_SOLID_H
#define SIM_SOLID_H

#include "sim/sim.h"

/* Distance from the nearest wall, negative inside of any [m], and which it is; INFINITY where there are no walls. */
double solid_distance(const MnsSim *sim, const double x[3], size_t *ret_wall);

/* The same where the walls are now: by their shapes, as particles of a sloping wall are a staircase, and hollow deep inside. */
double solid_distance_now(const MnsSim *sim, const double x[3]);

/* Is x, `away` from the walls where they are now, inside of them? On a surface it is not, and where two walls touch it is. */
bool solid_covers(const MnsSim *sim, const double x[3], double away);

/* Is x in the domain, beyond periodic sides too, and in no wall? */
bool solid_leaves_room(const MnsSim *sim, const double x[3]);

/* From x within a wall to the nearest point of the plane that touches its surface there [m]. Where another wall covers what is nearest, it is the
 * surface of all walls that counts, the nearest along rows and diagonals. */
void solid_to_surface(const MnsSim *sim, const double x[3], size_t wall, double ret[3]);

/* Unit vectors along rows and diagonals of the lattice, 8 in the plane and 26 in space. */
int solid_ways(int dim);
void solid_way(int dim, int k, double ret[3]);

/* At a point of the lattice where there is room, `away` from `wall`, which is the nearest: refuse a solid that is thinner than the kernel's
 * support there and has room for particles on its other side as well. Its edges and tips are no sides. MNS_E_INVALID with the place. */
MnsStatus solid_check(const MnsSim *sim, const double x[3], double away, size_t wall, MnsError *error);

#endif
