/* SPDX-License-Identifier: BSD-3-Clause */
/* Walls whose surface has a velocity of its own: lids and belts. Of it there acts what is along the surface. */
#ifndef SIM_BELTS_H
#define SIM_BELTS_H

#include "sim/sim.h"

/* Does the case give the wall's surface a velocity? */
bool belts_are_on(const MnsWall *wall, int dim);

/* When the particles are where the case puts them: find what faces are beside those of belts, give these their velocity, and warn of faces that lose
 * some of it. MNS_E_INVALID where a wall has no point along which any of it is, with the entry; MNS_E_MEMORY. */
MnsStatus belts_init(MnsSim *sim, MnsError *error);
void belts_done(Belts *belts);

/* Memory for the belts of n particles. */
size_t belts_bytes(size_t n);

/* Give the particles what their surfaces have at present besides the velocity of their walls. */
void belts_run(MnsSim *sim);

#endif
