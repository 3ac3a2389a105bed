/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/slabs.h"
#include "base/array.h"
#include <stdlib.h>

enum { SMALLEST = 1 << 14, LARGEST = 1 << 19 }; /* 64 KiB, and 2 MiB: a huge page */

void slabs_init(Slabs *slabs, size_t entries, int threads)
{
    const size_t share = entries / ((size_t)threads * 16); /* so that a sixteenth is empty at most */
    *slabs = (Slabs){.size = SMALLEST};
    while (2 * slabs->size <= share && slabs->size < LARGEST) slabs->size *= 2;
}

void slabs_done(Slabs *slabs)
{
    for (size_t k = 0; k < slabs->n; k++) free(slabs->slab[k].data);
    free(slabs->slab);
    *slabs = (Slabs){0};
}

void slabs_clear(Slabs *slabs)
{
    slabs->taken = 0;
}

static bool make(Slabs *slabs, size_t capacity)
{
    if (slabs->n == slabs->room) {
        const size_t room = slabs->room ? 2 * slabs->room : 16;
        Slab *slab = realloc(slabs->slab, room * sizeof *slab);
        if (!slab) return false;
        slabs->slab = slab;
        slabs->room = room;
    }
    uint32_t *data = array_room(capacity, sizeof *data);
    if (!data) return false;
    slabs->slab[slabs->n++] = (Slab){data, capacity};
    return true;
}

/* The next slab that is free and large enough; its data is NULL if there is no memory for one. */
static Slab take(Slabs *slabs, size_t entries)
{
    size_t k = slabs->taken;
    while (k < slabs->n && slabs->slab[k].capacity < entries) k++;
    if (k == slabs->n && !make(slabs, entries > slabs->size ? entries : slabs->size)) return (Slab){NULL, 0};
    const Slab found = slabs->slab[k];
    slabs->slab[k] = slabs->slab[slabs->taken];
    slabs->slab[slabs->taken++] = found;
    return found;
}

bool slabs_reserve(Slabs *slabs, Cut *cut, size_t entries)
{
    if (entries <= cut->left) return true;
    Slab slab;
#pragma omp critical(slabs)
    slab = take(slabs, entries);
    if (!slab.data) return false;
    *cut = (Cut){slab.data, slab.capacity};
    return true;
}

size_t slabs_bytes(const Slabs *slabs)
{
    size_t bytes = 0;
    for (size_t k = 0; k < slabs->n; k++) bytes += slabs->slab[k].capacity * sizeof *slabs->slab[k].data;
    return bytes;
}
