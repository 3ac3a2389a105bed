/* SPDX-License-Identifier: BSD-3-Clause */
/* The sums over neighbours that schemes are made of. */
#ifndef SIM_TERMS_TERMS_H
#define SIM_TERMS_TERMS_H

#include "sim/scheme.h"

/* Of several schemes. */
extern const Term viscosity;            /* viscosity.c: between fluids, by the velocity of a pair */
extern const Term wall_friction;        /* viscosity.c: of walls without slip */
extern const Term wall_jump;            /* wall.c: what one pressure lacks for each */
extern const Term wall_pressure;        /* wall.c: what a wall shows to each fluid */
extern const Term wall_velocity;        /* wall.c: mirrored at a wall without slip */
extern const Term mirrored_velocity;    /* wall.c: of the fluid's image in a wall */
extern const Term shepard_sum;          /* shepard.c: of W V */
extern const Term continuity;           /* continuity.c: of densities */
extern const Term pressure_gradient;    /* dissipation.c: exact for linear fields */
extern const Term density_dissipation;  /* dissipation.c: of density increments */
extern const Term corrected_continuity; /* corrected.c: of densities, with corrected gradients */
extern const Term corrected_pressure_force;

/* P3 */
extern const Term number_density;         /* number_density.c: sum of W */
extern const Term riemann_density;        /* riemann.c: continuity with the Riemann velocity */
extern const Term strain_rate;            /* strain.c: what of velocities is linear around a particle */
extern const Term pressure_slope;         /* slope.c: the same of pressures */
extern const Term reconstructed_momentum; /* riemann.c: the same, of what is left beside that */
extern const Term riemann_momentum;       /* riemann.c: pressure force with the Riemann pressure */
extern const Term background;             /* transport.c: advection acceleration and its stress */
extern const Term transport_stress;       /* transport.c: of the neighbours' advection velocity */

/* P1 */
extern const Term gas_dissipation;  /* gas.c */
extern const Term pressure_force;   /* pressure_force.c: weighted by the product of volumes */
extern const Term interface_normal; /* interface_normal.c */
extern const Term raw_curvature, mean_curvature, next_mean, sharp_curvature; /* curvature.c */

/* P2 */
extern const Term volume_continuity;     /* continuity.c: of volumes */
extern const Term volume_pressure_force; /* pressure_force.c: weighted by the squares of volumes */
extern const Term corrected_normal;      /* interface_normal.c: with corrected gradients */
extern const Term radial_viscosity;      /* radial_viscosity.c: along the line of a pair */
extern const Term radial_friction;       /* radial_viscosity.c: of walls without slip */
extern const Term concentration;         /* shifting.c: gradient of the sum of W V */
extern const Term shifting;              /* shifting.c: what shifted particles carry */
extern const Local shifted_position;     /* shifting.c */
extern const Term shifted_wall_pressure; /* wall.c: where the fluid was shifted */

/* P4 */
extern const Term mirrored_start; /* wall.c: mirrored velocity, about that of the wall before the step */
extern const Term wall_density;   /* wall.c: of the fluids that are there */
extern const Term density_matrix; /* projection.c: systems for the pressure */
extern const Term density_wall_matrix;
extern const Term velocity_matrix;
extern const Term velocity_wall_matrix;
extern const Term velocity_divergence;             /* projection.c: from differences */
extern const Term density_correction;              /* projection.c: of positions */
extern const Term velocity_correction;             /* projection.c */
extern const Term raw_curvature_first, sharp_mean; /* curvature.c: for one mean less */
extern const Term transposed_viscosity;            /* transposed_viscosity.c: grad mu . grad v^T */

/* P5 */
extern const Term truncation;        /* difference_shape.c: truncation tensor and offset vector */
extern const Term mixture;           /* difference_shape.c: filtered density and viscosity */
extern const Term difference_matrix; /* difference_pressure.c: system for the pressure, and divergence */
extern const Term difference_wall_matrix;
extern const Term difference_correction; /* difference_pressure.c: of velocities */
extern const Local corrected_velocity;   /* difference_pressure.c */
extern const Term continued_velocity;    /* wall_differences.c: of the fluid, into walls */
extern const Term continued_start;       /* wall_differences.c: before the pressure is known */
extern const Term harmonic_diffusion;    /* momentum_diffusion.c */
extern const Term divtau_diffusion;
extern const Term conservative_diffusion;
extern const Term sph_diffusion;
extern const Term colour_gradient;                         /* colour_gradient.c */
extern const Term colour_curvature, mean_colour_curvature; /* colour_gradient.c */
extern const Term even_spacing;                            /* spacing.c: shift, and what the shifted carry */
extern const Local even_position;                          /* spacing.c */

/* What walls that move put into the fluid: no part of a step, but of the account of energy (energy.h). */
extern const Term product_power, squares_power,
    riemann_power;                                       /* wall_power.c: of P1, P2 and P3, by the pressure force */
extern const Term friction_power, radial_friction_power; /* wall_power.c: by the wall friction */
extern const Term corrected_power;                       /* corrected.c */
extern const Term surface_power;                         /* wall_power.c: of P5 */
extern const Term diffusion_power;                       /* momentum_diffusion.c: of P5 */
extern const Term projected_power;                       /* projection.c: of P4 */

/* P4 and P5: what walls behind mirrors are shown with (hidden_pressure.c) */
extern const Term hidden_pressure;
extern const Term hidden_mixed_pressure; /* of mixtures */

/* Several terms in one go: of particles among their own kind, and beside walls or other fluids. */
extern const Fusion dissipation_shape; /* dissipation_shape.c */
extern const Fusion dissipation_rates; /* dissipation_rates.c */
extern const Fusion dissipation_viscous_rates;
extern const Fusion dissipation_gas_rates;
extern const Fusion dissipation_shape_beside; /* dissipation_beside.c */
extern const Fusion dissipation_rates_beside;
extern const Fusion dissipation_gas_rates_beside;
extern const Fusion interfacial_density, interfacial_density_within,
    interfacial_density_across;   /* interfacial_density.c */
extern const Fusion no_interface; /* interface_normal.c: no normal inside a fluid */
extern const Fusion raw_curvature_alone, raw_curvature_first_alone, mean_curvature_alone, next_mean_alone,
    sharp_curvature_alone, sharp_mean_alone; /* curvature.c: where another fluid is in reach */
extern const Fusion no_raw_curvature, no_mean_curvature, no_next_mean,
    no_sharp_curvature; /* curvature.c: nor a curvature */
extern const Fusion no_raw_curvature_first, no_sharp_mean;
extern const Fusion interfacial_forces; /* interfacial_forces.c */
extern const Fusion interfacial_viscous_forces;
extern const Fusion interfacial_density_beside; /* interfacial_shape_beside.c */
extern const Fusion interfacial_normal;
extern const Fusion interfacial_forces_beside; /* interfacial_beside.c */
extern const Fusion number_density_alone;      /* number_density.c */
extern const Fusion riemann_density_alone;     /* riemann.c */
extern const Fusion strained_density, weighed_density, sloped_density;
extern const Fusion pressure_slope_alone;                 /* slope.c */
extern const Fusion riemann_forces, reconstructed_forces; /* riemann_forces.c */
extern const Fusion transported_forces, transported_reconstructed_forces;

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

/* Is a fluid spread, and feels where it comes to? */
static inline bool is_transported(const Model *model)
{
    if (!model->transport_stress) return false;
    for (size_t k = 0; k < model->n_phases; k++)
        if (model->phase[k].p_b > 0) return true;
    return false;
}

static inline bool has_mirrors(const Model *model)
{
    return model->mirrors != 0;
}

static inline bool is_viscous(const Model *model)
{
    return model->viscous;
}

/* By forces along the line of a pair, or by those that oppose its velocity. */
static inline bool is_viscous_along(const Model *model)
{
    return model->viscous && model->radial;
}

static inline bool is_viscous_between(const Model *model)
{
    return model->viscous && !model->radial;
}

/* 1 / K, K = sum_j V_j (-F) y^2 r^2/(r^2 + 0.01 h^2) over the lattice with these spacings, mean over directions: 1 for a
 * perfect kernel. */
double viscosity_scale(const Kernel *kernel, int dim, const double spacing[3]);

/* What each of two fluids has of their tension: half, or of three its own part of all (jump.h). */
void tension_share(Model *model);

/* What of the tension of fluids a and b is of a where they meet a third one [N/m] (jump.h). */
double tension_share_beside(const Model *model, size_t a, size_t b, size_t third);

/* S of radial_viscosity.c [m^-2]. */
double radial_viscosity_scale(const Kernel *kernel, int dim, const double spacing[3]);

#endif
