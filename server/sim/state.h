/* SPDX-License-Identifier: BSD-3-Clause */
/* The equation of state of a fluid, both ways: everybody who turns density into pressure or back asks here.
 *   p = c^2 (rho - rho0)                                       P1 eq. 5, P3 eq. 3
 *   p = c^2 rho0 / gamma ((rho / rho0)^gamma - 1)              P2 eq. 6: gamma > 1
 * and, in closed spaces, a background pressure. */
#ifndef SIM_STATE_H
#define SIM_STATE_H

#include "sim/model.h"
#include <math.h>

/* x^exponent to 1e-14 of itself; 0 of 0, NAN below. */
double state_power(double x, double exponent);

INLINE double state_pressure(const Phase *phase, double rho)
{
    if (phase->exponent > 1) {
        const double stiffness = phase->c * phase->c * phase->rho0 / phase->exponent;
        return stiffness * (state_power(rho / phase->rho0, phase->exponent) - 1) + phase->background;
    }
    return phase->c * phase->c * (rho - phase->rho0) + phase->background;
}

/* p: without the background. */
INLINE double state_density(const Phase *phase, double p)
{
    if (phase->exponent > 1) {
        const double stiffness = phase->c * phase->c * phase->rho0 / phase->exponent;
        return phase->rho0 * state_power(1 + p / stiffness, 1 / phase->exponent);
    }
    return phase->rho0 + p / (phase->c * phase->c);
}

#endif
