/* SPDX-License-Identifier: BSD-3-Clause */
/* The equation of state of a fluid, both ways: everybody who turns density into pressure or back asks here.          P3 eq. 3
 *   p = c^2 (rho - rho0) */
#ifndef SIM_STATE_H
#define SIM_STATE_H

#include "sim/model.h"

INLINE double state_pressure(const Phase *phase, double rho)
{
    return phase->c * phase->c * (rho - phase->rho0);
}

INLINE double state_density(const Phase *phase, double p)
{
    return phase->rho0 + p / (phase->c * phase->c);
}

#endif
