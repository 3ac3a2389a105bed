/* SPDX-License-Identifier: BSD-3-Clause */
/* What the two of a pair count for. With t = (z_j - z_i)/(z_i + z_j), z = rho c, the one of lesser inertia yields: pressures count 1 + t and
 * 1 - t, and velocities relative to their mean 1 + t, as in a Riemann problem. With t = 0 the averages are arithmetic, and the light
 * one feels the stiffness of the heavy one, which bounds the step (stiff_interface in limits.c; P1 eq. 23 in schemes/dissipation.md). */
#ifndef SIM_TERMS_AVERAGE_H
#define SIM_TERMS_AVERAGE_H

#include "sim/row.h"

/* t of a pair, of which one has z_i; inverse: 1 / (z_i + z_j). */
INLINE double average_tilt(const Model *model, double z_i, const Pair *pair, double inverse)
{
    return model->density_average * ((pair->z - z_i) * inverse);
}

/* Of two viscosities, which moves the fluid of the lesser: 2 a b/(a + b), 0 of two that are 0. */
INLINE double harmonic_mean(double a, double b)
{
    return a + b > 0 ? 2 * a * b / (a + b) : 0;
}

#endif
