/* SPDX-License-Identifier: BSD-3-Clause */
/* Necks of solid between two rooms, as where two walls touch at a corner. */
#ifndef SIM_NECKS_H
#define SIM_NECKS_H

#include "sim/sim.h"

/* At a point of the lattice where there is room, `away` from the nearest wall [m]: is there room behind less than a kernel's support of solid that no way
 * around it leads to nearby? If so, how much solid is between [m], and about where. MNS_E_MEMORY. */
MnsStatus necks_find(const MnsSim *sim, const double x[3], double away, bool *ret_found, double *ret_thickness,
                     double ret_place[3], MnsError *error);

#endif
