/* SPDX-License-Identifier: BSD-3-Clause */
/* P5: generalized finite differences for two incompressible fluids, with the whole divergence of the stress. J. C. Joubert, D. N. Wilke,
 * P. Pizette, On the momentum diffusion over multiphase surfaces with meshless methods. */
#include "sim/integrators/integrators.h"
#include "sim/limits.h"
#include "sim/locals/locals.h"
#include "sim/terms/terms.h"
#include <math.h>

static void differences_options(Model *model, const MnsCase *c)
{
    const MnsDifferences *options = &c->scheme.differences;
    model->guard = options->guard * model->dx;
    model->c_max = INFINITY;
    for (size_t k = 0; k < model->n_phases; k++) {
        model->phase[k].c = INFINITY;
        model->phase[k].summation = true;
    }
    model->projection = (Projection){.tolerance = options->tolerance,
                                     .speed = options->reference_speed,
                                     .iterations = options->iterations,
                                     .solver = options->solver};
    model->differences = (Differences){.diffusion = options->diffusion,
                                       .threshold = options->interface_threshold,
                                       .shifting = options->shifting_strength,
                                       .along = options->shift_across_interfaces ? 0 : 1,
                                       .buoyancy = options->buoyant_in < 0 ? 0 : model->phase[options->buoyant_in].rho0,
                                       .scale = model->dx * model->dx / model->wall_volume,
                                       .holds = options->holds_pressure};
    for (int d = 0; d < 3; d++) model->differences.zero[d] = options->zero_pressure[d];
}

const Scheme scheme_differences = {
    .name = "differences",
    .title = "generalized finite differences for two incompressible fluids",
    .source = "P5: Joubert, Wilke and Pizette",
    .integrator = &single_projection,
    .limits = {&flow_limit, &body_force_limit, &mixture_viscous_limit, &incompressible_tension_limit},
    .rates =
        {
            [PASS_CONTINUED] = {"walls", .terms = {&continued_start}},
            [PASS_SYSTEM] = {"pressure system", .terms = {&difference_matrix, &difference_wall_matrix},
                             .assembles = true},
            [PASS_CORRECTION] = {"velocity correction", .terms = {&difference_correction},
                                 .after = {&corrected_velocity}},
            [PASS_SPACING] = {"shifting", .terms = {&even_spacing}, .after = {&even_position}},
            [PASS_SHAPE] = {"neighbourhood", .terms = {&number_density, &truncation, &mixture},
                            .after = {&volume_of_number}},
            {"surroundings", .terms = {&continued_velocity, &colour_gradient}},
            {"forces", .before = {&buoyancy},
             .terms = {&harmonic_diffusion, &divtau_diffusion, &conservative_diffusion, &sph_diffusion,
                       &colour_tension}},
        },
    .state = FIELD(ID) | FIELD(PHASE) | FIELD(X) | FIELD(V) | FIELD(RHO) | FIELD(P) | FIELD(M) | FIELD(A) | FIELD(REF) |
             FIELD(TO_SURFACE),
    .given = PASS_SHAPE,
    .derive = &volume_alone,
    .projects = true,
    .unknowns = differences_unknowns,
    .lay = differences_lay,
    .again = {PASS_SHAPE, PASS_SHAPE + 2},
    .options = differences_options,
};
