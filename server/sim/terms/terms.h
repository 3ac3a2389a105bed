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

extern const Term shifted_wall_pressure; /* wall.c           the same again, where the fluid was shifted */
extern const Term mirrored_velocity;     /* wall.c           what a wall's particles move like to the fluid */
extern const Term shepard_sum;           /* shepard.c        sum of W V                                  */
extern const Term continuity;            /* continuity.c     density by what flows together              */
extern const Term volume_continuity;     /* continuity.c     the same, of volumes                        */
extern const Term pressure_gradient;     /* dissipation.c    exact for linear fields                     */
extern const Term density_dissipation;   /* dissipation.c    of density increments                       */
extern const Term pressure_force;        /* pressure_force.c weighted by the product of volumes          */
extern const Term volume_pressure_force; /* pressure_force.c weighted by their squares                   */
extern const Term corrected_continuity;  /* corrected.c      density, with corrected gradients           */
extern const Term corrected_pressure_force;
extern const Term interface_normal; /* tension.c        and with corrected gradients                */
extern const Term corrected_normal;
extern const Term surface_tension; /* tension.c        and with corrected gradients                */
extern const Term corrected_tension;
extern const Term radial_viscosity;  /* radial_viscosity.c  along the line of a pair                 */
extern const Term radial_friction;   /* radial_viscosity.c  on walls without slip                    */
extern const Term concentration;     /* shifting.c       where there are fewer particles             */
extern const Term shifting;          /* shifting.c       particles to where there are fewer          */
extern const Local shifted_position; /* shifting.c      and there they go                           */

extern const Term mirrored_start; /* wall.c           the same, about the wall's velocity a step ago */
extern const Term density_matrix; /* projection.c     systems for the pressure                    */
extern const Term density_wall_matrix;
extern const Term velocity_matrix;
extern const Term velocity_wall_matrix;
extern const Term velocity_divergence; /* projection.c     of the velocity, as differences             */
extern const Term density_correction;  /* projection.c     of positions, by the pressure               */
extern const Term velocity_correction; /* projection.c     of velocities                               */
extern const Term surface_vector;      /* surface_stress.c beside interfaces                           */
extern const Term surface_stress;      /* surface_stress.c its divergence                              */

extern const Term transposed_viscosity; /* transposed_viscosity.c where unlike viscosities meet */

extern const Term truncation;        /* difference_shape.c    what differences are made with                */
extern const Term mixture;           /* difference_shape.c    densities and viscosities of what is around     */
extern const Term difference_matrix; /* difference_pressure.c system for the pressure, and divergence        */
extern const Term difference_wall_matrix;
extern const Term difference_correction; /* difference_pressure.c of velocities                              */
extern const Local corrected_velocity;   /*                          and what is left of them                  */
extern const Term continued_velocity;    /* wall_differences.c    of fluid into walls                            */
extern const Term continued_start;       /* wall_differences.c    the same before the pressure is known              */
extern const Term harmonic_diffusion;    /* momentum_diffusion.c                                              */
extern const Term divtau_diffusion;
extern const Term conservative_diffusion;
extern const Term sph_diffusion;
extern const Term colour_gradient; /* colour_gradient.c     interfaces                                     */
extern const Term colour_tension;  /* colour_gradient.c     their tension                                  */
extern const Term even_spacing;    /* spacing.c             particles to where there are fewer             */
extern const Local even_position;  /*                       and there they go                              */

extern const Fusion dissipation_shape;         /* dissipation_shape.c     sums and gradients              */
extern const Fusion dissipation_rates;         /* dissipation_rates.c     all rates                       */
extern const Fusion dissipation_viscous_rates; /*                         and viscosity                   */
extern const Fusion dissipation_shape_beside;  /* dissipation_beside.c    both beside walls or others     */
extern const Fusion dissipation_rates_beside;
extern const Fusion interfacial_density;        /* interfacial_density.c   continuity and dissipation      */
extern const Fusion no_interface;               /* tension.c               no normal inside a fluid        */
extern const Fusion interfacial_forces;         /* interfacial_forces.c    pressure and shifting           */
extern const Fusion interfacial_viscous_forces; /*                         and viscosity                   */
extern const Fusion interfacial_density_beside; /* interfacial_shape_beside.c beside walls                 */
extern const Fusion interfacial_normal;         /*                         normals beside another fluid    */
extern const Fusion interfacial_forces_beside;  /* interfacial_beside.c    beside walls or others          */
extern const Fusion number_density_alone;       /* number_density.c                                    */
extern const Fusion riemann_density_alone;      /* riemann.c                                           */
extern const Fusion riemann_forces;             /* riemann_forces.c    momentum, background and stress */

static inline bool plain_gradients(const Model *model)
{
    return !model->corrects_gradients;
}

static inline bool finds_normals(const Model *model)
{
    return model->tense || model->shifts_along_interfaces;
}

static inline bool is_tense(const Model *model)
{
    return model->tense;
}

static inline bool is_shifted(const Model *model)
{
    return model->shifting > 0;
}

static inline bool is_viscous(const Model *model)
{
    return model->viscous;
}

/* Unknowns of a pressure system: the fluid's particles, and the walls' towards each fluid. */
size_t projection_unknowns(const Particles *s);

/* Lay out the rows of the system by how many neighbours there are. false: no memory. */
bool projection_lay(Particles *s, const Neighbours *nb);

/* The same for the scheme of differences, in which walls are unknowns once; of a system that may have room for more. */
size_t differences_unknowns(const Particles *s);
bool differences_lay(Particles *s, const Neighbours *nb);

/* 1 / K, K = sum_j V_j (-F) y^2 r^2/(r^2 + 0.01 h^2) over the lattice with these spacings, mean over directions: 1 for a
 * perfect kernel. */
double viscosity_scale(const Kernel *kernel, int dim, const double spacing[3]);

#endif
