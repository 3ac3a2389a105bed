/* SPDX-License-Identifier: BSD-3-Clause */
/* Are pairs of unlike fluids averaged and kept apart in ways that suit their densities and their surface tension? */
#ifndef SIM_UNLIKE_H
#define SIM_UNLIKE_H

#include "sim/sim.h"

/* Warn of arithmetic averages beside a gas or beside surface tension. */
void unlike_look_at_averages(MnsSim *sim);

/* Warn of a repulsion beside surface tension. */
void unlike_look_at_repulsion(MnsSim *sim);

/* Warn of surface tension between densities that differ by more than the scheme holds. */
void unlike_look_at_tension(MnsSim *sim);

/* Of more than three fluids, whose lines may ask for unlike shares of the tension (terms/jump.h). */
void unlike_look_at_lines(MnsSim *sim);

#endif
