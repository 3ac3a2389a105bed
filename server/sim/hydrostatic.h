/* SPDX-License-Identifier: BSD-3-Clause */
/* What the two halves of a hydrostatic start share: columns as they are laid, and what hangs under walls. */
#ifndef SIM_HYDROSTATIC_H
#define SIM_HYDROSTATIC_H

#include "sim/lattice.h"

/* How columns are laid. */
typedef struct Laying {
    MnsSim *sim;
    const Lattice *lattice;
    int axis;
    bool down;  /* gravity points to lower coordinates */
    double gdz; /* pressure over density of one point [m^2/s^2] */
} Laying;

static inline bool is_fluid(const Laying *l, const LatticeRun *run)
{
    return run && (size_t)run->owner < l->sim->model.n_phases;
}

/* Columns are laid, each from zero where it begins, which they do in n_tops places. Columns that are open above keep that; those
 * under a wall follow the fluid beside them; where all hang, those that begin highest keep it. Columns count as beside each other
 * where they are of the same fluid. MNS_E_MEMORY, MNS_E_INTERRUPTED. */
MnsStatus hydrostatic_hang(const Laying *laying, size_t n_tops, MnsError *error);

#endif
