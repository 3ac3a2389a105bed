/* SPDX-License-Identifier: BSD-3-Clause */
/* The energy of interfaces, from where particles are and nothing else: however a scheme makes its tension, this is what it is worth. */
#ifndef SIM_AREAS_H
#define SIM_AREAS_H

#include "sim/sim.h"

/* Of all of them, tension times area [J]. */
double areas_energy(MnsSim *sim);

#endif
