/* SPDX-License-Identifier: BSD-3-Clause */
/* How each fluid lies at the start: how far it reaches, and which drops and bubbles it has. */
#ifndef SIM_DROPS_H
#define SIM_DROPS_H

#include "sim/lattice.h"

/* Find sim->start, once particles are in their places. MNS_E_MEMORY, MNS_E_INTERRUPTED. */
MnsStatus drops_find(MnsSim *sim, Lattice *lattice, MnsError *error);

#endif
