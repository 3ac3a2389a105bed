/* SPDX-License-Identifier: BSD-3-Clause */
/* Sides of the domain that mirror the fluid, as planes of symmetry do. A side is one if a still wall along which fluid slips covers all of it and,
 * but in schemes that tell images the pressure of their depth, no gravity acts across it.
 * In the rows of schemes with mirrors, images of the fluid, of the particle itself and of other walls stand for the particles behind
 * such sides:
 *   x_j' = x_j + 2 (x_side - x_j),   v_j' = -v_j   across the side; all else as of j
 * where both the pair and its image are in reach, so that i has an image of j if and only if j has one of i. In edges and corners there are images of
 * images. Images are fluid to a term, or walls. Particles behind a mirror are hidden: no row has them, but they have rows of fluid as other walls
 * do. */
#ifndef SIM_MIRRORS_H
#define SIM_MIRRORS_H

#include "sim/formula.h"
#include "sim/row.h"
#include <meniscus/sim.h>

/* Sides of the domain of a simulation whose walls have their shapes, under a gravity, a bit each: bit 2 d of the lower one in direction d, 2 d + 1 of
 * the upper one. Walls that move, have a surface velocity, are not flat, or cover a part of a side are none; nor are two sides that are nearer to each
 * other than the kernel's support, as there would be images of images without end. None are where a kernel is so wide that rows have no room for images
 * in a corner: more than some 500 neighbours. */
unsigned mirrors_find(const MnsSim *sim, Formula *const gravity[3]);

/* Is a flat face of a wall a side that mirrors all? */
bool mirrors_have(const Model *model, const Face *face);

/* Is i a wall particle behind a mirror? */
bool mirrors_hide(const Model *model, const Particles *s, size_t i);

/* Of which positions: those that lists were made for, or those of now. */
typedef enum MirroredWhen { MIRRORED_AS_LISTED, MIRRORED_NOW } MirroredWhen;

/* How many images of n neighbours of i, and of i if it is fluid, are within a distance of it; counted no further than `most`. What is hidden has none. */
size_t mirrors_count(const Model *model, const Particles *s, size_t i, const uint32_t *list, size_t n, double distance,
                     size_t most, MirroredWhen when);

/* Take walls out of a list that stay behind a mirror while it is in use; returns how many are left. */
size_t mirrors_thin(const Model *model, const Particles *s, uint32_t *list, size_t n);

/* May images of the n listed neighbours of i, the first `fluid` of which are fluid, or of i come into reach while the list is in use, or walls that
 * a mirror hides? By where all were when lists were made. Too often: a row has no room for so many. */
typedef enum Mirrored { MIRRORED_NOT, MIRRORED, MIRRORED_TOO_OFTEN } Mirrored;
Mirrored mirrors_of_list(const Model *model, const Particles *s, size_t i, const uint32_t *list, size_t fluid, size_t n,
                         double distance);

/* Take hidden walls out of a row, and put images in. */
void mirrors_add(Row *row, const RowPlan *plan);

#endif
