/* SPDX-License-Identifier: BSD-3-Clause */
/* Are the fluids stiff enough for what they have to carry, and not too stiff for where they thin out? */
#ifndef SIM_SOUNDS_H
#define SIM_SOUNDS_H

#include "sim/sim.h"

/* Warn of speeds of sound that are too low for weight, tension or the pressures of the start, and of background pressures that are too high, or too
 * low beside tension. What is advised holds together, and in this scheme. Again after a change: of what has become worse. */
void sounds_look(MnsSim *sim);

#endif
