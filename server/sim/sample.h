/* SPDX-License-Identifier: BSD-3-Clause */
/* Particles near a point that is no particle. */
#ifndef SIM_SAMPLE_H
#define SIM_SAMPLE_H

#include "sim/sim.h"

/* Kernel-weighted sums at a point, over the particles around it. */
typedef struct PointSums {
    double fluid; /* sum of W V over all fluids */
    double one;   /* ... over the fluid asked for */
    double all;   /* ... over walls too */
    double value; /* sum of f W V over all fluids */
} PointSums;

/* f: [n] a field, or NULL; components: 1, or dim to take the magnitude of f[0..dim); fluid: -1 for all.
 * radius: support of the kernel [m], 0 for the scheme's. */
PointSums sample_point(const MnsSim *sim, const double x[3], double radius, int fluid, const double *const *f,
                       int components);

#endif
