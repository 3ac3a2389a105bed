/* SPDX-License-Identifier: BSD-3-Clause */
/* What the rows of both schemes that solve for a pressure are made with. */
#ifndef SIM_TERMS_MATRIX_ROW_H
#define SIM_TERMS_MATRIX_ROW_H

#include "sim/row.h"
#include "sim/solve/solve.h"

_Static_assert((int)LANES == (int)ENTRIES, "the pairs of a block are the entries of one");

/* Entries are floats, and their sum is the diagonal of what is stored, not of what it stands for: so constants are nothing to a row. */
INLINE double float_sum(const float *c, size_t n)
{
    double sum = 0;
    for (size_t k = 0; k < n; k++) sum += (double)c[k];
    return sum;
}

/* Images (mirrors.h) have no unknowns of their own: their entries are added to those of the particles that they are of, and come to nothing
 * for a particle's own. What the pressure of an image is more than that of the particle goes to the right-hand side. */
INLINE size_t entry_of(const Row *row, size_t pair)
{
    return pair < row->n_own * LANES ? pair : pair - (row->n_fluid - row->n_own) * LANES;
}

/* Blocks of entries of a row. */
INLINE size_t entry_blocks(const Row *row)
{
    return row->n_walls - (row->n_fluid - row->n_own);
}

/* Add entries of a block of images to those of the row that is being made. */
INLINE void add_to_sources(const Row *row, const Block *b, const float of[LANES], float *c)
{
    const size_t first = (size_t)(b - row->block) * LANES;
    for (size_t l = 0; l < LANES; l++) {
        const size_t source = row->source[first + l];
        if (source != OWN_IMAGE) c[entry_of(row, source)] += of[l];
    }
}

/* Lay out the rows of the pressure system, one for each particle, by how many neighbours there are. false: no memory. */
bool matrix_rows_lay(Particles *s, const Neighbours *nb);

#endif
