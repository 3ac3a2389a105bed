/* SPDX-License-Identifier: BSD-3-Clause */
/* Sums over the fluid's particles that have the same bits for any number of threads. */
#ifndef SIM_FLUID_SUM_H
#define SIM_FLUID_SUM_H

#include "sim/model.h"
#include "sim/particles.h"

typedef double (*Summand)(const Particles *, const Model *, size_t i);

/* Takes the rates of density as room for the sums of blocks. */
double fluid_sum(Particles *s, const Model *model, Summand summand, int threads);

#endif
