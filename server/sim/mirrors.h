/* SPDX-License-Identifier: BSD-3-Clause */
/* Images of the fluid in planes that mirror it (mirror_planes.h).
 * In the rows of schemes with mirrors, images of the fluid, of the particle itself and of other walls stand for the particles behind
 * such planes:
 *   x_j' = x_j + 2 (x_plane - x_j),   v_j' = -v_j   across the plane; all else as of j
 * where both the pair and its image are in reach, so that i has an image of j if and only if j has one of i. In edges and corners there are images of
 * images. Images are fluid to a term, or walls. Particles behind a mirror are hidden: no row has them, but they have rows of fluid as other walls
 * do. */
#ifndef SIM_MIRRORS_H
#define SIM_MIRRORS_H

#include "sim/row.h"
#include <meniscus/sim.h>

/* Is i a wall particle behind a mirror? */
bool mirrors_hide(const Model *model, const Particles *s, size_t i);

/* Mirrors nearer than this to a place, a bit each. */
unsigned mirrors_near(const Model *model, const double x[3], double distance);

/* Are these sides some by which there is an image? One of each direction: behind both there are only images that are out of reach. */
bool mirrors_make_image(unsigned these);

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
