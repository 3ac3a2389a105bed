/* SPDX-License-Identifier: BSD-3-Clause */
/* The power of walls, pair by pair (wall_power.c). */
#ifndef SIM_TERMS_WALL_POWER_H
#define SIM_TERMS_WALL_POWER_H

#include "sim/terms/terms.h"

/* force . v of eight pairs. */
INLINE void add_power(const Lanes force[3], const double v[3][LANES], How how, Lanes *power)
{
    for (int d = 0; d < how.dim; d++)
        for (int l = 0; l < LANES; l++) add_product(power, l, force[d].of[l], v[d][l], how);
}

/* By the velocities of the walls that the wall particles of a block are of, without those of their surfaces. */
INLINE void add_wall_power(const Lanes force[3], const Row *row, const Block *b, const Particles *s, const Model *model,
                           How how, Lanes *power)
{
    const uint32_t *j = row_j(row, b);
    double v[3][LANES];
    for (int l = 0; l < LANES; l++)
        for (int d = 0; d < how.dim; d++) v[d][l] = model->wall[s->phase[j[l]] - model->n_phases].v[d];
    for (int d = 0; d < how.dim && are_images(row, b); d++) turn_component(row, b, d, v[d]);
    add_power(force, v, how, power);
}

/* By those of the surfaces of a block of walls, which friction acts on. */
INLINE void add_surface_power(const Lanes force[3], const Particles *s, const Row *row, const Block *b, How how,
                              Lanes *power)
{
    const uint32_t *j = row_j(row, b);
    double v[3][LANES];
    for (int d = 0; d < how.dim; d++) {
        for (int l = 0; l < LANES; l++) v[d][l] = particles_surface_velocity(s, d, j[l]);
        if (are_images(row, b)) turn_component(row, b, d, v[d]);
    }
    add_power(force, v, how, power);
}

/* A term of it: by the velocity of the walls themselves, which is 0 where only their surfaces move, or by that of their surfaces. */
#define NORMAL_POWER(term, what, of, eq, when, pairs)  POWER(term, what, of, eq, when, pairs, true)
#define SURFACE_POWER(term, what, of, eq, when, pairs) POWER(term, what, of, eq, when, pairs, false)
#define POWER(term, what, of, eq, when, pairs, normal)                                                                 \
    const Term term = {.name = what,                                                                                   \
                       .source = of,                                                                                   \
                       .equation = eq,                                                                                 \
                       .on = ON_FLUID,                                                                                 \
                       .needed = when,                                                                                 \
                       .needs = pairs,                                                                                 \
                       .beside = LIST_WALLS,                                                                           \
                       .takes_motion = normal,                                                                         \
                       .row = ROW_TABLE(term##_row)}

#endif
