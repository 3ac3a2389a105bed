/* SPDX-License-Identifier: BSD-3-Clause */
/* Simulations of cases made in C. All fail the test where the solver refuses. */
#ifndef SUPPORT_SIMS_H
#define SUPPORT_SIMS_H

#include "sim/sim.h"
#include "tests/support/cases.h"

/* A new simulation of a case, which it borrows; both go with sim_done(). */
MnsSim *sim_of(const MnsCase *c);
void sim_done(MnsSim *sim, MnsCase *c);

/* The same, with all fields in arrays and none in bundles, for tests that look at them and change them one by one. */
MnsSim *sim_in_arrays(const MnsCase *c);

/* Does any of its warnings have these words? */
bool sim_warns(const MnsSim *sim, const char *words);

/* So many steps, each as long as it may be. */
void sim_steps(MnsSim *sim, int n);

#endif
