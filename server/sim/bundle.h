/* SPDX-License-Identifier: BSD-3-Clause */
/* What a particle is asked for by its neighbours, in bundles of four doubles: one load brings four quantities, where a structure
 * of arrays takes a gather for each, three times as long. Copies of the fields, made again when these have changed. */
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

/* A quantity in a bundle. z = rho c; q = m dt/2 b, 0 where there is no stress. */
typedef enum Carried {
    CARRIED_X,
    CARRIED_V = CARRIED_X + 3,
    CARRIED_P = CARRIED_V + 3,
    CARRIED_VOLUME,
    CARRIED_Z,
    CARRIED_Q,
    CARRIED_NOTHING = CARRIED_Q + 3
} Carried;

/* THE layout, by dimensions: [dim - 2][bundle][quantity]. */
static const uint8_t BUNDLE_LAYOUT[2][BUNDLES][4] = {
    {{CARRIED_X, CARRIED_X + 1, CARRIED_V, CARRIED_V + 1},
     {CARRIED_P, CARRIED_VOLUME, CARRIED_Z, CARRIED_NOTHING},
     {CARRIED_Q, CARRIED_Q + 1, CARRIED_NOTHING, CARRIED_NOTHING}},
    {{CARRIED_X, CARRIED_X + 1, CARRIED_X + 2, CARRIED_V},
     {CARRIED_V + 1, CARRIED_V + 2, CARRIED_Q, CARRIED_Q + 1},
     {CARRIED_P, CARRIED_VOLUME, CARRIED_Z, CARRIED_Q + 2}},
};

/* The needs that bundle k has something for; positions are needed by all. */
static inline __attribute__((always_inline)) unsigned bundle_meets(int dim, int k)
{
    static const uint8_t NEED_FOR[] = {
        [CARRIED_X] = NEED_ALL,   NEED_ALL,   NEED_ALL,   [CARRIED_V] = NEED_V,    NEED_V,    NEED_V,
        [CARRIED_P] = NEED_STATE, NEED_STATE, NEED_STATE, [CARRIED_Q] = NEED_FLUX, NEED_FLUX, NEED_FLUX,
        [CARRIED_NOTHING] = 0};
    const uint8_t *of = BUNDLE_LAYOUT[dim - 2][k];
    return (unsigned)(NEED_FOR[of[0]] | NEED_FOR[of[1]] | NEED_FOR[of[2]] | NEED_FOR[of[3]]);
}

/* In Particles.stale, besides a bit for each bundle: marks of the lists of a group, STALE_MARKS << group. */
enum { STALE_MARKS = 1 << BUNDLES };

/* Positions, velocities or advection velocities have changed; pressures, densities or impedances have. The pressures of walls
 * are not kept up to date, as a wall shows each fluid another (Particles.p_wall). */
void bundles_moved(Particles *s);
void bundles_compressed(Particles *s);

/* Make the bundles that these needs are met from, if fields they are made of have changed. */
void bundles_refresh(Particles *s, const Model *model, unsigned needs, int threads);

#endif
