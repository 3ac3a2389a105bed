/* SPDX-License-Identifier: BSD-3-Clause */
/* P5: generalized finite differences for two incompressible fluids, with the whole divergence of the stress. J. C. Joubert, D. N. Wilke,
 * P. Pizette, On the momentum diffusion over multiphase surfaces with meshless methods. */
#include "base/vector.h"
#include "sim/case_bounds.h"
#include "sim/check.h"
#include "sim/integrators/integrators.h"
#include "sim/limits.h"
#include "sim/locals/locals.h"
#include "sim/terms/terms.h"
#include <math.h>

static MnsStatus differences_check(const MnsCase *c, MnsError *error)
{
    const MnsDifferences *g = &c->scheme.differences;
    const Bounded list[] = {
        {"interface_threshold", g->interface_threshold, BOUNDS_Differences_interface_threshold},
        {"shifting_strength", g->shifting_strength, BOUNDS_Differences_shifting_strength},
        {"reference_speed", fmax(g->reference_speed, 0), BOUNDS_Differences_reference_speed},
        {"tolerance", g->tolerance, BOUNDS_Differences_tolerance},
        {"iterations", g->iterations, BOUNDS_Differences_iterations},
        {"guard", g->guard, BOUNDS_Differences_guard},
    };
    if (c->n_fluids > 2)
        return mns_fail_at(error, MNS_E_INVALID, "fluids", "found %zu fluids; the scheme differences is for one or two",
                           c->n_fluids);
    if (g->solver == MNS_SOLVER_CG)
        return mns_fail_at(error, MNS_E_INVALID, "scheme.differences.solver",
                           "found cg, which solves symmetric systems, and that of differences is none; write by-size, "
                           "bicgstab or amg");
    if (g->buoyant_in >= (int)c->n_fluids)
        return mns_fail_at(error, MNS_E_INVALID, "scheme.differences.buoyant_in",
                           "found fluid %d, counted from 0, of %zu; write one of them, or -1 for none", g->buoyant_in,
                           c->n_fluids);
    for (int d = 0; d < c->dim && g->holds_pressure; d++) {
        const char axis = "xyz"[d];
        const double zero = g->zero_pressure[d], min = c->min[d], max = c->max[d];
        if (!c->periodic[d] && !(zero >= min && zero <= max))
            return mns_fail_at(error, MNS_E_INVALID, "scheme.differences.zero_pressure",
                               "the pressure is to be 0 outside of the domain: %c = %g m, allowed %g to %g m", axis,
                               zero, min, max);
    }
    const MnsStatus status = check_solver(g->solver, "scheme.differences.solver", error);
    return status ? status : CHECK_BOUNDS("scheme.differences", list, error);
}

static bool differences_keeps_options(const MnsSchemeOptions *a, const MnsSchemeOptions *b)
{
    const MnsDifferences *g = &a->differences, *h = &b->differences;
    return g->buoyant_in == h->buoyant_in && g->holds_pressure == h->holds_pressure &&
           same_vector(g->zero_pressure, h->zero_pressure);
}

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
    model->differences = (Differences){.share = 1,
                                       .diffusion = options->diffusion,
                                       .threshold = options->interface_threshold,
                                       .shifting = options->shifting_strength,
                                       .along = options->shift_across_interfaces ? 0 : 1,
                                       .buoyancy = options->buoyant_in < 0 ? 0 : model->phase[options->buoyant_in].rho0,
                                       .scale = model->dx * model->dx / model->cell_volume,
                                       .holds = options->holds_pressure};
    for (int d = 0; d < 3; d++) model->differences.zero[d] = options->zero_pressure[d];
}

const Scheme scheme_differences = {
    .name = "differences",
    .title = "generalized finite differences for two incompressible fluids",
    .source = "P5: Joubert, Wilke and Pizette",
    .integrator = &single_projection,
    .limits = {&flow_limit, &body_force_limit, &mixture_viscous_limit, &tension_limit, &change_limit},
    .rates =
        {
            [PASS_CONTINUED] = {"walls", .terms = {&continued_start}},
            [PASS_SYSTEM] = {"pressure system", .terms = {&difference_matrix, &difference_wall_matrix},
                             .assembles = true},
            [PASS_CORRECTION] = {"velocity correction", .terms = {&difference_correction, &hidden_mixed_pressure},
                                 .after = {&corrected_velocity}},
            [PASS_SPACING] = {"shifting", .terms = {&even_spacing}, .after = {&even_position}},
            [PASS_SHAPE] = {"neighbourhood", .terms = {&number_density, &truncation, &mixture},
                            .after = {&volume_of_number}},
            {"surroundings", .terms = {&continued_velocity, &colour_gradient}},
            {"curvature", .terms = {&colour_curvature}},
            {"mean curvature", .terms = {&mean_colour_curvature}},
            {"forces", .before = {&buoyancy},
             .terms = {&harmonic_diffusion, &divtau_diffusion, &conservative_diffusion, &sph_diffusion}},
        },
    .power = {&surface_power, &diffusion_power},
    .state = FIELD(ID) | FIELD(PHASE) | FIELD(X) | FIELD(V) | FIELD(RHO) | FIELD(P) | FIELD(M) | FIELD(A) | FIELD(REF) |
             FIELD(TO_SURFACE),
    .given = PASS_SHAPE,
    .suited = {{MNS_QUINTIC_SPLINE, 0.9, 0.83, 0.9}},
    .tense_ratio = 10, /* at 1000 jumps of drops at rest are 5 to 12 % off, and their volume grows (differences.md) */
    .energy_excess = 0.05, /* its differences are no forces of pairs, and keep no energy */
    .projects = true,
    .floors_mirror = true,
    .derived_passes = {PASS_SHAPE, PASS_SHAPE + 4},
    .check = differences_check,
    .keeps_options = differences_keeps_options,
    .options = differences_options,
};
