/* SPDX-License-Identifier: BSD-3-Clause */
/* What particles are asked for by their neighbours, in bundles of four doubles: one load brings four quantities, where a
 * structure of arrays takes a gather for each, three times as long. Copies, made again when fields have changed; a scheme has
 * the bundles that its terms need. */
#ifndef SIM_BUNDLE_H
#define SIM_BUNDLE_H

#include "sim/model.h"
#include "sim/particles.h"

/* What terms need of a pair besides x_i - x_j and r. The table of what is carried for it is in bundle.c. */
enum {
    NEED_W = 1,         /* kernel                            */
    NEED_F = 2,         /* its slope                         */
    NEED_V = 4,         /* the neighbour's velocity          */
    NEED_STATE = 8,     /* its pressure, volume, impedance   */
    NEED_SHEPARD = 16,  /* the inverse of its sum of W V */
    NEED_GRADIENT = 32, /* its pressure gradient     */
    NEED_NORMAL = 64,   /* its interface normal      */
    NEED_OTHERS = 128,  /* whether it is of another fluid */
    NEED_BEND = 256,    /* how the kernel's slope changes */
    NEED_STRAIN = 512,  /* its rate of strain, where others have gradients and normals */
    NEED_ALL = 1023
};

/* Quantities, each of a member of Block (row.h) and of a row of the table in bundle.c. */
enum {
    CARRIED_X,                             /* x_j, until x_i - x_j takes its place                */
    CARRIED_V = CARRIED_X + 3,             /* v_j                                                 */
    CARRIED_P = CARRIED_V + 3,             /* pressure                                            */
    CARRIED_VOLUME,                        /* volume                                              */
    CARRIED_Z,                             /* impedance rho c                                     */
    CARRIED_SHEPARD,                       /* 1 / sum of W V                                      */
    CARRIED_GRADIENT,                      /* pressure gradient; or rate of strain, diagonal      */
    CARRIED_NORMAL = CARRIED_GRADIENT + 3, /* interface normal; or rate of strain, xy, xz, yz     */
    CARRIED_NOTHING = CARRIED_NORMAL + 3,
    CARRIED_END
};

/* THE layout, [dim - 2][bundle][quantity]: what changes together is together, where that takes no bundle more. Known when rows are
 * compiled, as looking up where to put each quantity would cost a tenth of a step. Normals and gradients are, as far as may be, where nothing is that is asked for while they are found, as
 * then they need no other place (home.h). */
enum { BUNDLES = 4 };
static const uint8_t BUNDLE_LAYOUT[2][BUNDLES][4] = {
    {{CARRIED_X, CARRIED_X + 1, CARRIED_V, CARRIED_V + 1},
     {CARRIED_P, CARRIED_VOLUME, CARRIED_Z, CARRIED_SHEPARD},
     {CARRIED_GRADIENT, CARRIED_GRADIENT + 1, CARRIED_NORMAL, CARRIED_NORMAL + 1},
     {CARRIED_NOTHING, CARRIED_NOTHING, CARRIED_NOTHING, CARRIED_NOTHING}},
    {{CARRIED_X, CARRIED_X + 1, CARRIED_X + 2, CARRIED_V},
     {CARRIED_V + 1, CARRIED_V + 2, CARRIED_GRADIENT + 1, CARRIED_GRADIENT + 2},
     {CARRIED_P, CARRIED_VOLUME, CARRIED_Z, CARRIED_SHEPARD},
     {CARRIED_GRADIENT, CARRIED_NORMAL, CARRIED_NORMAL + 1, CARRIED_NORMAL + 2}},
};

/* The needs that bundle k has something for; all need positions. */
static inline __attribute__((always_inline)) unsigned bundle_meets(int dim, int k)
{
    static const uint16_t NEED_FOR[] = {[CARRIED_X] = NEED_ALL,
                                        NEED_ALL,
                                        NEED_ALL,
                                        [CARRIED_V] = NEED_V,
                                        NEED_V,
                                        NEED_V,
                                        [CARRIED_P] = NEED_STATE,
                                        NEED_STATE,
                                        NEED_STATE,
                                        [CARRIED_SHEPARD] = NEED_SHEPARD,
                                        [CARRIED_GRADIENT] = NEED_GRADIENT | NEED_STRAIN,
                                        NEED_GRADIENT | NEED_STRAIN,
                                        NEED_GRADIENT | NEED_STRAIN,
                                        [CARRIED_NORMAL] = NEED_NORMAL | NEED_STRAIN,
                                        NEED_NORMAL | NEED_STRAIN,
                                        NEED_NORMAL | NEED_STRAIN,
                                        [CARRIED_NOTHING] = 0};
    unsigned needs = 0;
    for (int q = 0; q < 4; q++) needs |= NEED_FOR[BUNDLE_LAYOUT[dim - 2][k][q]];
    return needs;
}

typedef struct Bundles {
    int dim;
    double (*data[BUNDLES])[4];  /* [n]; NULL: the scheme does not need it */
    unsigned stale[CARRIED_END]; /* groups in which what a quantity is made of has changed since, as bits */
} Bundles;

/* Room for n particles, for terms with these needs. false: no memory, nothing is left behind. */
bool bundles_init(Bundles *b, size_t n, int dim, unsigned needs, int threads);
void bundles_done(Bundles *b);

/* Room for these needs too, as far as there is none; false: no memory, what there was is there. Give up what these needs have no use for. */
bool bundles_add(Bundles *b, size_t n, unsigned needs, int threads);
void bundles_keep(Bundles *b, unsigned needs);

/* Fields of a group have changed. */
void bundles_stale(Bundles *b, Group group, Fields fields);

/* Fields that these needs are met from. */
Fields bundles_fields(const Bundles *b, unsigned needs);

/* Make the bundles that these needs are met from, where they are stale. */
void bundles_refresh(Bundles *b, const Particles *s, const Model *model, unsigned needs, int threads);

/* Where component d of a field is, of the first particle; the next one's is four further. NULL if nowhere, or not as it is. */
double *bundles_place(const Bundles *b, int field, int d);
enum { BUNDLE_STEP = 4 };

/* The bundles in which a field is, of a scheme that has these, as bits. */
unsigned bundles_with(int dim, int field, Fields of);

size_t bundles_bytes(const Bundles *b, size_t n);

#endif
