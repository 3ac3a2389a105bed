/* SPDX-License-Identifier: BSD-3-Clause */
/* What a particle is asked for by its neighbours, in bundles of four doubles: one load brings four quantities, where a structure
 * of arrays takes a gather for each, three times as long. Copies of the fields, made again when these have changed.
 *
 *      two dimensions         three dimensions
 *   0  x, y, v_x, v_y         x, y, z, v_x
 *   1  p, V, z, -             v_y, v_z, q_x, q_y         q = m dt/2 b, 0 where there is no stress
 *   2  q_x, q_y, -, -         p, V, z, q_z               z = rho c */
#ifndef SIM_BUNDLE_H
#define SIM_BUNDLE_H

#include "sim/model.h"
#include "sim/particles.h"

/* What terms need of a pair besides x_i - x_j and r. */
enum {
    NEED_W = 1,     /* kernel                            */
    NEED_F = 2,     /* its slope                         */
    NEED_V = 4,     /* the neighbour's velocity          */
    NEED_STATE = 8, /* its pressure, volume, impedance   */
    NEED_FLUX = 16, /* its mass times advection velocity */
    NEED_ALL = 31
};

/* In Particles.stale, besides a bit for each bundle: marks of the lists of a group, STALE_MARKS << group. */
enum { STALE_MARKS = 8 };

/* Pressures of walls are not kept up to date: a wall shows each fluid another (Particles.p_wall). Positions, velocities or advection velocities have changed; pressures, densities or impedances have. */
void bundles_moved(Particles *s);
void bundles_compressed(Particles *s);

/* Make the bundles that these needs are met from, if fields they are made of have changed. */
void bundles_refresh(Particles *s, const Model *model, unsigned needs, int threads);

#endif
