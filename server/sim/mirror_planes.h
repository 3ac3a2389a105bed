/* SPDX-License-Identifier: BSD-3-Clause */
/* Planes that mirror the fluid, as planes of symmetry do: sides of the domain, or where there are nothing but walls before one, the border between
 * cells of the lattice at which room begins. One is a mirror if a wall along which fluid slips, and that moves along it at most, always covers all of it that fluid can come to and,
 * but in schemes that tell images the pressure of their depth, no gravity acts across it. */
#ifndef SIM_MIRROR_PLANES_H
#define SIM_MIRROR_PLANES_H

#include "sim/formula.h"
#include "sim/model.h"
#include <meniscus/sim.h>

/* Find where planes may be, once the walls have their shapes. */
void mirror_planes_place(MnsSim *sim);

/* Those of these that are mirrors under a gravity, a bit each: bit 2 d of the lower one in direction d, 2 d + 1 of the upper one. Walls that move across, have
 * a surface velocity, are not flat, or cover a part of a plane are none; nor are two planes that are nearer to each other than the kernel's support, as
 * there would be images of images without end. None are where a kernel is so wide that rows have no room for images in a corner: more than some 500
 * neighbours. */
unsigned mirror_planes_find(const MnsSim *sim, Formula *const gravity[3]);

/* Does a flat face of a wall lie in a mirror? */
bool mirror_planes_have(const Model *model, const Face *face);

/* Tell of the first face that several fluids slip along and that stands as a plane of symmetry does, but is no mirror. */
void mirror_planes_look(MnsSim *sim);

#endif
