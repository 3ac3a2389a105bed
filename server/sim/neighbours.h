/* SPDX-License-Identifier: BSD-3-Clause */
/* Who is near whom: for each particle the indices of its neighbours within the kernel's support plus a skin, group by group.
 * Lists stay valid until some particle has moved half a skin. A wall particle lists fluid only, and walls that stay behind a mirror are in no list. */
#ifndef SIM_NEIGHBOURS_H
#define SIM_NEIGHBOURS_H

#include "sim/bundle.h"
#include "sim/grid.h"
#include "sim/slabs.h"

enum { ROW_MAX = 1024 }; /* neighbours of one particle, skin included */

/* Kinds of neighbours that a list can be without. */
enum {
    LIST_WALLS = 1,
    LIST_OTHERS = 2, /* another fluid than the particle's own; not told of walls, and where no term asks */
    LIST_IMAGES = 4, /* the nearest is an image, across a periodic side */
    LIST_MIRRORS =
        8,         /* images in a mirror (mirrors.h): most of what is fused does not know of them, and a row is built */
    LIST_KINDS = 3 /* what terms may differ for */
};

/* A list is of fluid and then of walls. */
enum { END_FLUID, END_WALLS, LIST_ENDS };

typedef struct Neighbours {
    size_t n; /* particles */
    int threads;
    Grid grid;                  /* the lists were built with */
    uint32_t **list;            /* [n] neighbours of i, and behind them their marks, in slabs */
    uint16_t (*end)[LIST_ENDS]; /* [n] where fluid and walls end in the list of i */
    uint8_t *has;               /* [n] LIST_...: what kinds of neighbours the list of i has */
    bool tells_others;
    uint32_t *start; /* [sort_groups() * cells + 1] first particle of each cell, by group */
    size_t start_capacity;
    uint32_t *counts; /* work space to sort */
    Slabs slabs;
    Bundles bundles; /* what is asked of neighbours */
    unsigned marked; /* groups whose marks are those of the present positions, as bits */
} Neighbours;

/* For terms that need this of their neighbours: NEED_F | NEED_V ... */
MnsStatus neighbours_init(Neighbours *nb, size_t n, int dim, unsigned needs, int threads, MnsError *error);
void neighbours_done(Neighbours *nb);

/* Take notice of what has changed in the particles, and make what these needs are met from. */
void neighbours_refresh(Neighbours *nb, Particles *s, const Model *model, unsigned needs);

/* Sort the particles by group and cell of their `ref` positions and build all lists from these. Sorting is stable, so that
 * building again from the same `ref` changes nothing: what a bitwise restart rests on.
 * MNS_OK; MNS_E_MEMORY; MNS_E_LIMIT if a particle has more than ROW_MAX neighbours, with its id and place. */
MnsStatus neighbours_build(Neighbours *nb, Particles *s, const Model *model, MnsError *error);

/* Where the particles of a group begin, [cells + 1]; NULL if it has none. */
const uint32_t *neighbours_start(const Neighbours *nb, const Particles *s, int group);

/* [end[i][END_WALLS]] indices of the neighbours of i, without i. */
INLINE const uint32_t *neighbours_of(const Neighbours *nb, size_t i)
{
    return nb->list[i];
}

/* A bit for each entry of the list of i, fluid and walls each in whole bytes: was it in the kernel's reach when its row was last
 * built in full? They stand behind the list. */
INLINE size_t neighbours_mark_bytes(size_t entries)
{
    return (entries + 7) / 8;
}
INLINE uint8_t *neighbours_marks(Neighbours *nb, size_t i)
{
    return (uint8_t *)(nb->list[i] + nb->end[i][END_WALLS]);
}

/* Number of listed pairs (i, j), each direction counted. */
size_t neighbours_pairs(const Neighbours *nb);
size_t neighbours_bytes(const Neighbours *nb);

#endif
