/* SPDX-License-Identifier: BSD-3-Clause */
/* The sums over neighbours that schemes are made of. */
#ifndef SIM_TERMS_TERMS_H
#define SIM_TERMS_TERMS_H

#include "sim/scheme.h"

extern const Term number_density;   /* number_density.c    sum of W                                     */
extern const Term riemann_density;  /* riemann.c           continuity with the Riemann velocity         */
extern const Term riemann_momentum; /* riemann.c           pressure force with the Riemann pressure     */
extern const Term background;       /* transport.c         advection acceleration and its stress        */
extern const Term transport_stress; /* transport.c         stress of the neighbours' advection velocity */
extern const Term viscosity;        /* viscosity.c         between fluids                               */
extern const Term wall_friction;    /* viscosity.c         on walls without slip                        */
extern const Term wall_pressure;    /* wall.c              pressure a wall shows to each fluid          */
extern const Term wall_velocity;    /* wall.c              fluid velocity extrapolated into a wall      */

extern const Fusion number_density_alone;  /* number_density.c                                    */
extern const Fusion riemann_density_alone; /* riemann.c                                           */
extern const Fusion riemann_forces;        /* riemann_forces.c    momentum, background and stress */

static inline bool is_viscous(const Model *model)
{
    return model->viscous;
}

/* 1 / K, K = sum_j V_j (-F) y^2 r^2/(r^2 + 0.01 h^2) over the lattice with these spacings, mean over directions: 1 for a
 * perfect kernel. */
double viscosity_scale(const Kernel *kernel, int dim, const double spacing[3]);

#endif
