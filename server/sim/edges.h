/* SPDX-License-Identifier: BSD-3-Clause */
/* How much of each fluid its shape holds, where the lattice has whole cells of it or none. */
#ifndef SIM_EDGES_H
#define SIM_EDGES_H

#include "sim/survey.h"

/* Find lattice->held, by points within the cells that some surface goes through. With one surveyor for each thread. */
void edges_measure(Lattice *lattice, Surveyor *surveyors, int threads);

/* Warn of each fluid that has 1 % more or less than its shape. */
void edges_warn(MnsSim *sim, const Lattice *lattice);

#endif
