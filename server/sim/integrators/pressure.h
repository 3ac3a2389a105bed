/* SPDX-License-Identifier: BSD-3-Clause */
/* What both ways of projecting share: a pressure that is solved for, and fails with its residuals. */
#ifndef SIM_INTEGRATORS_PRESSURE_H
#define SIM_INTEGRATORS_PRESSURE_H

#include "sim/integrator.h"

/* Solve the system for the pressure that corrects `what`; the set-up and the rest of it are timed. */
MnsStatus pressure_solve(MnsSim *sim, const SolveMethod *method, double tolerance, const char *what,
                         SolveReport *ret_report, MnsError *error);

/* Set up for the matrix of now what the method makes of it, if anything, unless that is there. */
void pressure_prepare(MnsSim *sim, const SolveMethod *method);

#endif
