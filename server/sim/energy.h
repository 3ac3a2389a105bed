/* SPDX-License-Identifier: BSD-3-Clause */
/* The energy account of a run: what the fluid has, what was put into it, and so what its scheme has made of nothing.
 *   E = kinetic + potential + elastic + surface,   E - E_0 = W - dissipated
 *   W: of gravity that changes, of gravity along periodic directions, of walls that move and of surfaces that do
 * What is dissipated is the difference, and never less than nothing: E - E_0 - W above 0 is an error of the scheme. Of walls that all move alike W is
 * what the momentum of the fluid changes by, times their velocity; of others it is found by the scheme's forces between particles and walls. */
#ifndef SIM_ENERGY_H
#define SIM_ENERGY_H

#include "sim/sim.h"

/* Must the power of walls be found and stored for each fluid particle? */
bool energy_needs_power(const MnsSim *sim);

/* Begin the account of a new run, or find what the next step needs of one that goes on. */
void energy_begin(MnsSim *sim);

/* After a step: the work of it; now and then the energy too. Warns once of a run that has made more than is allowed. */
void energy_step(MnsSim *sim);

/* The energy of now [J], before options and gravity change, and what they have changed, after. */
double energy_of(MnsSim *sim);
void energy_steered(MnsSim *sim, double before);

#endif
