/* SPDX-License-Identifier: BSD-3-Clause */
/* The rules for single particles that schemes are made of. */
#ifndef SIM_LOCALS_LOCALS_H
#define SIM_LOCALS_LOCALS_H

#include "sim/scheme.h"

extern const Local advance_density;     /* density.c  continuity: one step of d rho/dt    */
extern const Local advance_shepard_sum; /* density.c  continuity: Gamma of the density that comes */
extern const Local summed_density;      /* density.c  summation: mass times number density */
extern const Local closed_volume;       /* closure.c  liquids that fill a space keep its volume */
extern const Local linear_pressure;     /* state.c    p = c^2 (rho - rho0), V, z           */
extern const Local tait_pressure;       /* state.c    p = c^2 rho0/gamma ((rho/rho0)^gamma - 1) */
extern const Local volume_of_number;    /* number.c   V = 1 / sum of W, rho = m / V          */
extern const Local body_force;          /* force.c    a = g                                */
extern const Local buoyancy;            /* force.c    a = (1 - rho_0/rho~) g               */

#endif
