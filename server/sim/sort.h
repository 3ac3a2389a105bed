/* SPDX-License-Identifier: BSD-3-Clause */
/* The order of particles by group and cell. */
#ifndef SIM_SORT_H
#define SIM_SORT_H

#include "sim/grid.h"

enum { SORT_BUCKETS_MAX = 1 << 11 };

/* Work space of a sort by up to `threads` threads. */
size_t sort_counts(int threads);      /* entries of uint32_t in `counts` */
enum { SORT_BYTES_PER_PARTICLE = 8 }; /* in each of two rooms, aligned as a double */

/* Groups that have particles are numbered one after the other, and others have no cells: which number, how many. */
size_t sort_group(const Particles *s, int group);
size_t sort_groups(const Particles *s);

/* By the cells of the `ref` positions, keeping the order of storage within a cell, whatever the number of threads:
 * start[sort_group() * cells + cell] is where its particles begin, [sort_groups() * cells + 1].
 * Returns which particle comes to each place, [n], in `room`; `other` is free again. */
uint32_t *sort_by_cell(const Particles *s, const Grid *grid, uint32_t *start, uint32_t *counts, void *room, void *other,
                       int threads);

#endif
