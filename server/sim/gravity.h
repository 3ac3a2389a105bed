/* SPDX-License-Identifier: BSD-3-Clause */
/* Gravity that changes with time. A step takes its mean, so that whatever the steps are, together they give a fluid the impulse that it is given;
 * and steps get shorter where it changes fast. */
#ifndef SIM_GRAVITY_H
#define SIM_GRAVITY_H

#include "sim/sim.h"

/* Its mean from one time to another: NaN where it is no number at some time between. Of one that does not change, what it is, to the bit. */
void gravity_mean(MnsSim *sim, double from, double to, double ret[3]);

/* What gravity_mean() failed by: the direction, and when it is no number; false if all is well. */
bool gravity_failure(MnsSim *sim, double from, double to, int *ret_direction, double *ret_time);

/* How fast it changes from t on for so long, at most [m/s^3]; 0 if it does not. Times at which it is no number do not count. */
double gravity_change(const MnsSim *sim, double t, double ahead);

/* Forget the means of a formula that is no more. */
void gravity_forget(MnsSim *sim);

#endif
