/* SPDX-License-Identifier: BSD-3-Clause */
/* What fluids start with: velocity, pressure, and the density and mass that this pressure asks for. */
#ifndef SIM_START_H
#define SIM_START_H

#include "sim/bodies.h"

/* Of one fluid, as formulas. */
typedef struct Start {
    FormulaTeam velocity[3], pressure;
    bool at_rest, laplace; /* what stands for the formula of the pressure, which is there already */
} Start;

/* Compile the formulas of all fluids, and find pressures that are no formulas; the particles of runs are known by now, their volumes in
 * place of masses and their heights along gravity, over that of a cell, in place of densities. With start_done() also where it fails.
 * MNS_E_INVALID; MNS_E_MEMORY. */
MnsStatus start_init(Start starts[], MnsSim *sim, Lattice *lattice, const Constants *constants, MnsError *error);
void start_done(Start starts[], size_t n);

/* Particle i of a fluid, where it is; its mass is a volume before. MNS_E_INVALID if a formula fails there, or no density gives the
 * pressure. Any thread. */
MnsStatus start_particle(const Start starts[], MnsSim *sim, size_t i, MnsError *error);

/* laplace.c: the pressure of drops and bubbles, where that of the fluids around them is known: in place, or a formula. */
MnsStatus start_laplace(MnsSim *sim, const Lattice *lattice, const Start starts[], const Bodies *bodies,
                        MnsError *error);

/* hydrostatic.c: the axis gravity points along at the start; -1 if it is zero or oblique. */
int hydrostatic_axis(const Model *model);

/* hydrostatic.c: the pressure of fluids at rest; `fluid` asked for it. */
MnsStatus start_hydrostatic(MnsSim *sim, const Lattice *lattice, size_t fluid, MnsError *error);

#endif
