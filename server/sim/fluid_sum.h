/* SPDX-License-Identifier: BSD-3-Clause */
/* Sums over the fluid's particles that have the same bits for any number of threads. */
#ifndef SIM_FLUID_SUM_H
#define SIM_FLUID_SUM_H

#include "sim/model.h"
#include "sim/particles.h"

typedef double (*Addend)(const Particles *, const Model *, size_t i);

/* The rates of density are room for the sums of blocks: none may be read by an addend, or later on. */
double fluid_sum(Particles *s, const Model *model, Addend addend, int threads);

#endif
