/* SPDX-License-Identifier: BSD-3-Clause */
/* Memory for lists whose lengths nobody knows before: slabs that never move and are used again, so that no list is copied when
 * there are more, and none of it is empty but the last slab of each thread. */
#ifndef SIM_SLABS_H
#define SIM_SLABS_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct Slab {
    uint32_t *data;
    size_t capacity; /* entries */
} Slab;

typedef struct Slabs {
    Slab *slab;
    size_t n, room; /* slabs there are, places for them */
    size_t taken;   /* the first ones are in use */
    size_t size;    /* entries of a usual slab */
} Slabs;

/* What is left of the slab that one thread writes to; zeros at first. */
typedef struct Cut {
    uint32_t *at;
    size_t left;
} Cut;

/* Slabs of a size that suits this many entries in all, of this many threads. */
void slabs_init(Slabs *slabs, size_t entries, int threads);
void slabs_done(Slabs *slabs);

/* All slabs are free again. */
void slabs_clear(Slabs *slabs);

/* Room for this many entries at cut->at; false if there is no memory. Threads may call it at once, each with its own cut. */
bool slabs_reserve(Slabs *slabs, Cut *cut, size_t entries);

/* The first of what is reserved are written. */
static inline void cut_advance(Cut *cut, size_t entries)
{
    cut->at += entries;
    cut->left -= entries;
}

size_t slabs_bytes(const Slabs *slabs);

#endif
