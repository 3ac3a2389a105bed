/* SPDX-License-Identifier: BSD-3-Clause */
/* What a step is made of, for the integrators in integrators/. */
#ifndef SIM_INTEGRATOR_H
#define SIM_INTEGRATOR_H

#include "sim/sim.h"

/* Gravity and walls as they are at t, dt after they were last set; fluid particles kept out of the walls. Walls' velocities are means from
 * then until `ahead` after t. Returns how many it kept out, which the step counts once. */
uint64_t integrator_walls(MnsSim *sim, double t, double dt, double ahead);

/* Accelerations begin with the mean of gravity over the step before. From here on, of a step of length dt that ends at t, with its own: so that
 * all kicks of a step together give its impulse, wherever it begins and ends. Nothing is done where gravity does not change. */
void integrator_gravity(MnsSim *sim, double t, double dt);

/* Neighbour lists for the positions of now, made again if a particle has left its skin. */
MnsStatus integrator_lists(MnsSim *sim, MnsError *error);

/* One of the scheme's passes; the passes from this one on; of them those whose results are not known from the middle of the step. */
void integrator_pass(MnsSim *sim, int pass);
void integrator_rates(MnsSim *sim, int first);
void integrator_end_rates(MnsSim *sim, int first);

/* The two questions about new velocities and densities: how fast, which is noted, and is all well? */
bool integrator_look(MnsSim *sim);

/* Something is done: book the time since start, by omp_get_wtime(), to one of the simulation's timers, and tell who watches. */
void integrator_clock(MnsSim *sim, size_t timer, double start);

/* A step of length dt that ends at t. */
MnsStatus integrator_step(MnsSim *sim, double t, double dt, MnsError *error);

/* What follows from the state without a step: pressures, volumes, walls. */
void integrator_derive(MnsSim *sim);

/* The rates of a state that goes on under another gravity or other options: those that the next step begins with. Nothing moves. */
void integrator_renew(MnsSim *sim);

/* The rates of a new state; what follows from a restored one. */
MnsStatus integrator_start(MnsSim *sim, MnsError *error);
MnsStatus integrator_restart(MnsSim *sim, MnsError *error);

#endif
