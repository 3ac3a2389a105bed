/* SPDX-License-Identifier: BSD-3-Clause */
/* What particles are asked for by their neighbours, in bundles of four doubles: one load brings four quantities, where a
 * structure of arrays takes a gather for each, three times as long. Copies, made again when fields have changed. Which
 * quantity is in which bundle follows from what the terms of a scheme need: quantities that change together are
 * together, where that takes no bundle more. */
#ifndef SIM_BUNDLE_H
#define SIM_BUNDLE_H

#include "sim/model.h"
#include "sim/particles.h"

/* What terms need of a pair besides x_i - x_j and r. The table of what is carried for it is in bundle.c. */
enum {
    NEED_W = 1,     /* kernel                            */
    NEED_F = 2,     /* its slope                         */
    NEED_V = 4,     /* the neighbour's velocity          */
    NEED_STATE = 8, /* its pressure, volume, impedance   */
    NEED_FLUX = 16, /* its mass times advection velocity */
    NEED_ALL = 31
};

enum { BUNDLES_MAX = 6 };

typedef struct Bundle {
    double (*data)[4];   /* [n] */
    uint8_t quantity[4]; /* rows of the table in bundle.c */
    uint16_t to[4];      /* where they go in a Block (row.h), in doubles */
    unsigned needs;      /* that it has something for */
    Fields of;           /* what it is made of */
    bool summed;         /* it has only what particles of summed density alone have */
    unsigned stale;      /* groups that have changed since, as bits */
} Bundle;

typedef struct Bundles {
    size_t n_bundles;
    Bundle bundle[BUNDLES_MAX];
} Bundles;

/* Room for n particles, for terms with these needs. false: no memory, nothing is left behind. */
bool bundles_init(Bundles *b, size_t n, int dim, unsigned needs);
void bundles_done(Bundles *b);

/* Fields of a group have changed. */
void bundles_stale(Bundles *b, Group group, Fields fields);

/* Fields that these needs are met from. */
Fields bundles_fields(const Bundles *b, unsigned needs);

/* Make the bundles that these needs are met from, where they are stale. */
void bundles_refresh(Bundles *b, const Particles *s, const Model *model, unsigned needs, int threads);

size_t bundles_bytes(const Bundles *b, size_t n);

#endif
