/* SPDX-License-Identifier: BSD-3-Clause */
/* Prescribed rigid translation of a wall. */
#ifndef SIM_MOTION_H
#define SIM_MOTION_H

#include <meniscus/case.h>

/* Displacement from where the case puts the wall [m], its velocity [m/s] and acceleration [m/s^2] at time t. */
void motion_at(const MnsMotion *motion, double t, double x[3], double v[3], double a[3]);

/* Are they the same at all times? */
bool motion_same(const MnsMotion *a, const MnsMotion *b);

/* Do all walls move as one, or not at all? */
bool motion_of_all(const MnsCase *c);

#endif
