/* SPDX-License-Identifier: BSD-3-Clause */
/* What is told of the pressure's solves in the last step; NAN of what a scheme does not do. */
#include "sim/probes/probes.h"
#include <math.h>

double probe_solver(Measure *m)
{
    const Solved *solved = &m->sim->solved;
    const Scheme *scheme = m->sim->scheme;
    if (!scheme->projects) return NAN;
    const double corrects = scheme->corrects_density ? 1 : NAN;
    switch (m->probe->quantity) { /* no default: the compiler tells of one that is missing */
    case MNS_SOLVER_ITERATIONS: return solved->iterations;
    case MNS_SOLVER_RESIDUAL: return solved->residual;
    case MNS_SOLVER_CORRECTIONS: return corrects * solved->corrections;
    case MNS_SOLVER_CORRECTION_ITERATIONS: return corrects * solved->density_iterations;
    case MNS_SOLVER_DENSITY_ERROR: return corrects * solved->density_error;
    }
    return NAN;
}
