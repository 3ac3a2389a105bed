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

/* Lay out the rows of the pressure system, one for each particle, by how many neighbours there are. false: no memory. */
bool matrix_rows_lay(Particles *s, const Neighbours *nb);

#endif
