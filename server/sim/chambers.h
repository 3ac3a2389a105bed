/* SPDX-License-Identifier: BSD-3-Clause */
/* Closed spaces of fluid, which a pressure that is solved for must know apart. */
#ifndef SIM_CHAMBERS_H
#define SIM_CHAMBERS_H

#include "sim/sim.h"

/* At the start: refuse a wall between two spaces that is so thin that both are in reach of each other, or of the unknown of a particle of it.
 * MNS_OK; MNS_E_INVALID with the place; MNS_E_MEMORY; or what the making says. */
MnsStatus chambers_check(const MnsSim *sim, MnsError *error);

#endif
