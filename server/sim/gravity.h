/* SPDX-License-Identifier: BSD-3-Clause */
/* Gravity that changes with time. A step takes its mean, so that whatever the steps are, together they give a fluid the impulse that it is given;
 * and steps get shorter where it changes fast. */
#ifndef SIM_GRAVITY_H
#define SIM_GRAVITY_H

#include "sim/sim.h"

/* Mean gravity from one time to another [m/s^2]; NaN if it is not finite at a time between them. A constant gravity is returned bit for bit. */
void gravity_mean(MnsSim *sim, double from, double to, double ret[3]);

/* Why gravity_mean() is NaN: the direction, and a time at which that component is not finite; false if all are finite. */
bool gravity_failure(MnsSim *sim, double from, double to, int *ret_direction, double *ret_time);

/* The largest rate of change of gravity between t and t + ahead [m/s^3]; 0 if it is constant. Times at which it is not finite are left out. */
double gravity_change(const MnsSim *sim, double t, double ahead);

/* Forget the means of a formula that is no more. */
void gravity_forget(MnsSim *sim);

#endif
