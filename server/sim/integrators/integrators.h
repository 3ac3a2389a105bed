/* SPDX-License-Identifier: BSD-3-Clause */
/* The integrators there are. A new one is a file and a line here. */
#ifndef SIM_INTEGRATORS_H
#define SIM_INTEGRATORS_H

#include "sim/scheme.h"

extern const Integrator kick_drift_kick;
extern const Integrator predictor_corrector;
extern const Integrator double_projection;
extern const Integrator single_projection;

/* Passes of a scheme with two projections, in this order; from the last of these on, they are the rates. */
enum {
    PASS_NUMBER,
    PASS_DENSITY_SYSTEM,
    PASS_DENSITY_CORRECTION,
    PASS_WALLS,
    PASS_VELOCITY_SYSTEM,
    PASS_VELOCITY_CORRECTION,
    PASS_RATES
};

/* Passes of a scheme with one projection, in this order; from the last of these on, they are the rates. */
enum { PASS_CONTINUED, PASS_SYSTEM, PASS_CORRECTION, PASS_SPACING, PASS_SHAPE };

#endif
