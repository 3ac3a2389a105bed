/* SPDX-License-Identifier: BSD-3-Clause */
/* How fast a pair comes nearer half a step ago, when it had the velocities that are known.
 *   v_ij . grad_i W at x_ij - l v_ij  =  F (v . x - l v . v) - l bend (v . x)^2 + O(l^2),   bend = (1/r) dF/dr,  l = dt/2
 * Velocities of the middle of a step at the positions of its end make the divergence wrong by -dt/2 tr (grad v)^2: liquid that turns as one
 * body would expand by omega^2 dt, and at a stagnation point it would be compressed. Both parts are needed: the second is what F has
 * changed by, and without it a shear would compress by dt/2 of its square. */
#ifndef SIM_TERMS_MIDWAY_H
#define SIM_TERMS_MIDWAY_H

#include "sim/row.h"

/* v: of the particle; lag: l. The same to the last bit seen from the other of the pair. */
INLINE double compression_midway(const double v[3], const Pair *pair, double lag, How how)
{
    const double nearer = DOT_DIFFERENCE(v, pair->v, pair->x, how), v2 = DIFFERENCE_SQUARED(v, pair->v, how);
    return mul_add(pair->F, mul_add(-lag, v2, nearer, how.fma), -(lag * pair->bend * (nearer * nearer)), how.fma);
}

#endif
