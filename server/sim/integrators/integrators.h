/* SPDX-License-Identifier: BSD-3-Clause */
/* The integrators there are. A new one is a file and a line here. */
#ifndef SIM_INTEGRATORS_H
#define SIM_INTEGRATORS_H

#include "sim/scheme.h"

extern const Integrator kick_drift_kick;
extern const Integrator predictor_corrector;

#endif
