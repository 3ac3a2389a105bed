/* SPDX-License-Identifier: BSD-3-Clause */
/* Run a pass: the only parallel loops over pairs. */
#ifndef SIM_PASS_H
#define SIM_PASS_H

#include "sim/scheme.h"

void pass_run(const Pass *pass, Particles *s, Neighbours *nb, const Model *model, int threads);

/* The function that a pass takes for particles of a group that have neighbours of these kinds, LIST_...; NULL: they go over rows. */
const Fusion *pass_fusion(const Pass *pass, int group, unsigned kinds, const Model *model);

/* A local rule over all particles of its groups. */
void local_run(const Local *local, Particles *s, const Model *model, int threads);

#endif
