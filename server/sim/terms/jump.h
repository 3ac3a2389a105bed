/* SPDX-License-Identifier: BSD-3-Clause */
/* Surface tension as a jump of the pressure: what the pressure of a neighbour of another fluid lacks as seen across the interface.
 *   J_ij = s_ij kappa_i - s_ji kappa_j,   s_ij + s_ji = sigma_ij;   at rest J_ij = p_i - p_j, and J_ji = -J_ij
 * It stands in every difference of pressures of two fluids, so that a drop at rest is balanced as well as its curvature (curvature.c) is known,
 * where a force smoothed over the kernel (P1 eq. 13, P2 eq. 26, P4 eq. 9) never is. Of two fluids each has half of sigma; beside a
 * third one k each has its own part, s_ij = (sigma_ij + sigma_ik - sigma_jk)/2, as where they meet the curvatures of the two of a pair are of unlike
 * surfaces. Of more fluids s_ij is the mean over all k, which is right at every line if all give the same, and is warned of if they do not (unlike.c). */
#ifndef SIM_TERMS_JUMP_H
#define SIM_TERMS_JUMP_H

#include "sim/row.h"

/* What is fixed in the pairs of one particle. */
typedef struct Jump {
    double mine[MNS_MAX_FLUIDS],
        its[MNS_MAX_FLUIDS]; /* s_ij kappa_i [Pa], s_ji [N/m] by the fluid of j; 0 of its own */
} Jump;

static const Jump NO_JUMP;

/* scale: 1, or dt where pressures are impulses. */
INLINE Jump jump_of(const Particles *s, const Model *model, size_t i, double scale)
{
    Jump jump = {{0}, {0}};
    const unsigned mine = s->phase[i];
    for (unsigned k = 0; k < model->n_phases; k++) {
        jump.mine[k] = scale * model->tension_share[mine][k] * s->curvature[i];
        jump.its[k] = scale * model->tension_share[k][mine];
    }
    return jump;
}

/* Of a block of fluid. */
INLINE void jumps_of(const Jump *jump, const Particles *s, const uint32_t *j, double ret[LANES])
{
    for (int l = 0; l < LANES; l++) {
        const unsigned its = s->phase[j[l]];
        ret[l] = jump->mine[its] - jump->its[its] * s->curvature[j[l]];
    }
}

#endif
