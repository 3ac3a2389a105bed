/* SPDX-License-Identifier: BSD-3-Clause */
/* Run a pass: the only parallel loops over pairs. */
#ifndef SIM_PASS_H
#define SIM_PASS_H

#include "sim/scheme.h"

void pass_run(const Pass *pass, Particles *s, Neighbours *nb, const Model *model, int threads);

/* A local rule over all particles of its groups. */
void local_run(const Local *local, Particles *s, const Model *model, int threads);

#endif
