/* SPDX-License-Identifier: BSD-3-Clause */
/* Which particles of a capture a stream has. Pure functions of the capture: any thread. */
#ifndef NET_SELECTION_H
#define NET_SELECTION_H

#include <meniscus/sim.h>
#include <stdbool.h>

/* All conditions hold of what is selected. */
typedef struct Selection {
    bool walls;              /* wall particles too         */
    bool boxed, ball, mixed; /* whether there are such conditions; mixed: of the phase */
    double min[3], max[3];
    double centre[3], radius;
    uint64_t phases[4]; /* bits */
    uint64_t every;     /* 1: each */
} Selection;

/* Spreads numbers that follow each other over all numbers, so that a choice by it shows no stripes of the lattice on which particles were
 * numbered. */
uint32_t selection_scatter(uint32_t id);

/* Fields that it looks at, as bits; what it selects is all particles, or all of the fluid, if there are none. */
uint64_t selection_fields(const Selection *selection);

/* Indices of those selected, which come in the order of the capture; chosen: [capture->n]. Returns how many. */
size_t selection_choose(const Selection *selection, const MnsCapture *capture, uint32_t *chosen);

/* What numpy calls the numbers of a field. */
const char *selection_numpy(MnsType type);

/* Bytes of one particle's value: all components. */
size_t selection_width(const MnsCapture *capture, int field);

/* Values of a field, of each particle all components; chosen NULL: of the first n. to: [n * selection_width()] */
void selection_gather(const MnsCapture *capture, int field, const uint32_t *chosen, size_t n, void *to);

#endif
