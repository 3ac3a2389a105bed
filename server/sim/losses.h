/* SPDX-License-Identifier: BSD-3-Clause */
/* Particles that leave the domain, and places in it that particles leave, are told when there are too many: they are counted after 64, 128 and 256 steps, every 300 and at the end. */
#ifndef SIM_LOSSES_H
#define SIM_LOSSES_H

#include "sim/sim.h"

/* After a step, now and then. Warns once of each. */
void losses_step(MnsSim *sim);

#endif
