/* SPDX-License-Identifier: BSD-3-Clause */
/* Particles near a point that is no particle. */
#ifndef SIM_SAMPLE_H
#define SIM_SAMPLE_H

#include "sim/shown.h"

/* Kernel-weighted sums at a point, over the particles around it. */
typedef struct PointSums {
    double fluid;  /* sum of W V over all fluids */
    double one;    /* ... over the fluids asked for */
    double all;    /* ... over walls too, but those behind mirrors */
    double hidden; /* of those */
    double value;  /* sum of f W V over all fluids */
} PointSums;

/* How a point is filled. Emptiness counts as a fluid of its own, and what part of the kernel is in walls as if it were filled as
 * the rest goes on towards it: so both shares are a half where there is a surface, beside walls too, be it level or not. */
typedef struct Share {
    double fluid;  /* of the fluids asked for in all that is no wall */
    double among;  /* of them in all fluids; 0 where there is none */
    double filled; /* of all fluids in what is no wall, as it comes: about 1 within them */
    double open;   /* of all that is no wall */
    double
        beside; /* 0 half a spacing deep in a wall, as its shape says, a half on its surface, 1 half a spacing off it */
    bool solid; /* the point is inside a wall's shape, and not on its surface */
} Share;

enum { EVERY_FLUID = 0xffff }; /* or a bit for each fluid; sample.c asserts that there is room for all */

Share sample_share(const MnsSim *sim, const double x[3], unsigned fluids);

/* Of a line along direction `up`: on a wall's surface what is there is that of two fifths of a spacing before it, as particles that run along the wall may have left it. */
Share sample_share_along(const MnsSim *sim, int up, const double x[3], unsigned fluids);

/* f: components of a field, or NULL; components: 1, or dim to take the magnitude of f[0..dim); fluids: those of `one`.
 * radius: support of the kernel [m], 0 for the scheme's. */
PointSums sample_point(const MnsSim *sim, const double x[3], double radius, unsigned fluids, const ShownView *f,
                       int components);

/* Sum of W V over all particles, fluid and walls. Walls stay walls where they are mirrors too: a gap beside one is not seen twice. */
double sample_cover(const MnsSim *sim, const double x[3]);

#endif
