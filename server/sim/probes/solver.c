/* SPDX-License-Identifier: BSD-3-Clause */
/* What is told of the pressure's solves in the last step. */
#include "sim/probes/probes.h"
#include <math.h>

double probe_solver(Measure *m)
{
    const Solved *solved = &m->sim->solved;
    if (!m->sim->scheme->projects) return NAN;
    switch (m->probe->quantity) { /* no default: the compiler tells of one that is missing */
    case MNS_SOLVER_ITERATIONS: return solved->iterations;
    case MNS_SOLVER_RESIDUAL: return solved->residual;
    case MNS_SOLVER_CORRECTIONS: return solved->corrections;
    case MNS_SOLVER_CORRECTION_ITERATIONS: return solved->density_iterations;
    case MNS_SOLVER_DENSITY_ERROR: return solved->density_error;
    }
    return NAN;
}
