/* SPDX-License-Identifier: BSD-3-Clause */
/* While a simulation is made: does it fit into the memory it may take, and is it still wanted? */
#ifndef SIM_MAKING_H
#define SIM_MAKING_H

#include "sim/sim.h"

/* Bytes of a simulation with groups of these sizes, and of one copy of its state, as each checkpoint takes. A little too many: lists
 * grow as particles crowd. */
double making_bytes(const MnsSim *sim, const size_t sizes[GROUPS]);

/* So many particles fit, whatever group they are of; INFINITY if it does not matter. */
double making_most(const MnsSim *sim);

/* MNS_E_MEMORY: groups of these sizes do not fit; it says so before memory is taken, as the operating system gives more than there is
 * and ends the process later. more: there are more particles, which were not counted. */
MnsStatus making_fits(const MnsSim *sim, const size_t sizes[GROUPS], bool more, MnsError *error);

/* MNS_E_INTERRUPTED: nobody wants the simulation any more. Any thread. */
MnsStatus making_goes_on(const MnsMaking *making, MnsError *error);

#endif
