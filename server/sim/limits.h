/* SPDX-License-Identifier: BSD-3-Clause */
/* Bounds of the time step. A scheme lists those it needs; a new one is a function and a row in limits.c. */
#ifndef SIM_LIMITS_H
#define SIM_LIMITS_H

#include "sim/scheme.h"

extern const Limit acoustic_limit, body_force_limit, change_limit, viscous_limit, radial_viscous_limit, tension_limit,
    interface_limit, flow_limit, incompressible_viscous_limit, mixture_viscous_limit, dissipation_limit;

/* That an incompressible flow is expected to have at least [m/s]. */
double limits_expected_speed(const Model *model);

/* Length of the next step: the least that the scheme's limits allow, and which of them that is; NULL if you do not ask. */
double limits_dt(const MnsSim *sim, const Limit **ret_limit);

#endif
