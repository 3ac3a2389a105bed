/* SPDX-License-Identifier: BSD-3-Clause */
/* Faces of walls whose surface has a velocity: what of it is across them, and lost. */
#ifndef SIM_BELT_FACES_H
#define SIM_BELT_FACES_H

#include "sim/sim.h"

/* What a particle of a belt has to do with the surface. */
typedef struct BeltTouch {
    bool room;        /* there is some before the surface that is nearest */
    int n;            /* faces that are nearest */
    double normal[3]; /* of the first */
    double place[3];  /* on it [m] */
} BeltTouch;

/* What is left of a velocity along the surface; along: the matrix of a particle (belts.c), xx, yy, zz, xy, xz, yz. */
void belt_along(const double along[6], const double u[3], double ret[3]);

/* Warn of each face of wall k that loses more than 1 % at any moment, and of a wall along which fluids slip. touches: of the particles of all belts.
 * MNS_E_INVALID where a wall has no point along which any of it is, with the entry. */
MnsStatus belt_faces_judge(MnsSim *sim, size_t k, const BeltTouch touches[], MnsError *error);

#endif
