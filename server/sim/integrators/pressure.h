/* SPDX-License-Identifier: BSD-3-Clause */
/* What both ways of projecting share: a pressure that is solved for, and fails with its residuals. */
#ifndef SIM_INTEGRATORS_PRESSURE_H
#define SIM_INTEGRATORS_PRESSURE_H

#include "sim/integrator.h"

/* Lay out the rows of the system. */
MnsStatus pressure_lay(MnsSim *sim, MnsError *error);

/* A pressure that is asked for. */
typedef struct PressureGoal {
    const char *corrects, *entry; /* what it is for, and the scheme's entry that has its tolerance */
    double tolerance;
} PressureGoal;

/* Solve the system; the set-up and the rest of it are timed. */
MnsStatus pressure_solve(MnsSim *sim, const PressureGoal *goal, SolveReport *ret_report, MnsError *error);

/* Make what the method keeps of a matrix, if anything, unless it is there: it fits all solves until the lists are made again, as particles
 * hardly move in between. It is made from where they were then, which a restart knows. Of rows that are laid out.
 *  passes  [n] that lead from positions to the matrix; the first is run again for where particles are */
void pressure_prepare(MnsSim *sim, const int passes[], size_t n);

/* Begin with the pressures of the step before; in walls, with what solves their rows. */
void pressure_guess(MnsSim *sim, double dt);

/* Length of this step over that of a step that is not cut short: at most 1. */
double pressure_share(const MnsSim *sim, double dt);

/* After a step: it replaces a share of the pressure of the step before. Walls that no fluid reaches have none. */
void pressure_keep(MnsSim *sim, double dt, double share);

#endif
