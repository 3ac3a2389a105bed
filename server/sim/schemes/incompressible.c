/* SPDX-License-Identifier: BSD-3-Clause */
/* P4: incompressible SPH of many fluids, whose densities and velocities are both projected. X. Y. Hu, N. A. Adams,
 * Journal of Computational Physics 227 (2007). */
#include "sim/case_bounds.h"
#include "sim/check.h"
#include "sim/integrators/integrators.h"
#include "sim/limits.h"
#include "sim/locals/locals.h"
#include "sim/terms/terms.h"
#include <math.h>

/* With true densities a correction of the heavy throws the light about: runs with a ratio of 100 blow up by it, so that it ends well below. */
static bool moves_alike(const Model *model, MnsMobility mobility)
{
    if (mobility != MNS_MOBILITY_BY_RATIO) return mobility == MNS_MOBILITY_UNIT;
    return model->rho_max > 10 * model->rho_min;
}

static MnsStatus incompressible_check(const MnsCase *c, MnsError *error)
{
    const MnsIncompressible *i = &c->scheme.incompressible;
    const Bounded list[] = {
        {"density_tolerance", i->density_tolerance, BOUNDS_Incompressible_density_tolerance},
        {"density_corrections", i->density_corrections, BOUNDS_Incompressible_density_corrections},
        {"density_patience", i->density_patience, BOUNDS_Incompressible_density_patience},
        {"density_offset", i->density_offset, BOUNDS_Incompressible_density_offset},
        {"reference_speed", fmax(i->reference_speed, 0), BOUNDS_Incompressible_reference_speed},
        {"tolerance", i->tolerance, BOUNDS_Incompressible_tolerance},
        {"density_solver_tolerance", i->density_solver_tolerance, BOUNDS_Incompressible_density_solver_tolerance},
        {"iterations", i->iterations, BOUNDS_Incompressible_iterations},
        {"guard", i->guard, BOUNDS_Incompressible_guard},
    };
    const MnsStatus status = check_solver(i->solver, "scheme.incompressible.solver", error);
    return status ? status : CHECK_BOUNDS("scheme.incompressible", list, error);
}

/* A wall particle that nothing but the rim of a kernel reaches would have a row of 1e-19 where others have 1: rounding is all there is in it,
 * and multigrid's cycles make that large. A ten-thousandth of a neighbour's pair is less than the Laplacian itself is off. */
static double faint_pair(const Model *model)
{
    double W, F;
    kernel_eval(&model->kernel, 1, &model->dx, &W, &F);
    return 1e-4 * F;
}

static void incompressible_options(Model *model, const MnsCase *c)
{
    const MnsIncompressible *options = &c->scheme.incompressible;
    model->guard = options->guard * model->dx;
    model->c_max = INFINITY;
    for (size_t k = 0; k < model->n_phases; k++) {
        model->phase[k].c = INFINITY;
        model->phase[k].summation = true;
    }
    model->projection = (Projection){.density_tolerance = options->density_tolerance,
                                     .offset = options->density_offset,
                                     .tolerance = options->tolerance,
                                     .correction_tolerance = options->density_solver_tolerance,
                                     .speed = options->reference_speed,
                                     .corrections = options->density_corrections,
                                     .patience = options->density_patience,
                                     .iterations = options->iterations,
                                     .unit_mobility = moves_alike(model, options->mobility),
                                     .mean_gauge = options->gauge == MNS_GAUGE_MEAN,
                                     .faint = faint_pair(model),
                                     .solver = options->solver};
}

const Scheme scheme_incompressible = {
    .name = "incompressible",
    .title = "incompressible SPH, projected twice",
    .source = "P4: Hu and Adams 2007",
    .suited = {{MNS_QUINTIC_SPLINE, 1, 1, 1}},
    .integrator = &double_projection,
    .limits = {&flow_limit, &body_force_limit, &incompressible_viscous_limit, &tension_limit, &change_limit},
    .rates =
        {
            [PASS_NUMBER] = {"number density", .terms = {&number_density, &wall_density}, .after = {&volume_of_number},
                             .fusions = {&number_density_alone}},
            [PASS_DENSITY_SYSTEM] = {"density system", .terms = {&density_matrix, &density_wall_matrix},
                                     .assembles = true},
            [PASS_DENSITY_CORRECTION] = {"density correction", .terms = {&density_correction}},
            [PASS_WALLS] = {"walls", .terms = {&mirrored_start}},
            [PASS_VELOCITY_SYSTEM] = {"velocity system",
                                      .terms = {&velocity_matrix, &velocity_divergence, &velocity_wall_matrix},
                                      .assembles = true},
            [PASS_VELOCITY_CORRECTION] = {"velocity correction", .terms = {&velocity_correction, &hidden_pressure}},
            [PASS_RATES] = {"surroundings", .terms = {&wall_velocity, &corrected_normal}},
            {"curvature", .terms = {&raw_curvature_first},
             .fusions = {&no_raw_curvature_first, &raw_curvature_first_alone}},
            {"mean curvature", .terms = {&next_mean}, .fusions = {&no_next_mean, &next_mean_alone}},
            {"sharp curvature", .terms = {&sharp_mean}, .fusions = {&no_sharp_mean, &sharp_mean_alone}},
            {"interfaces at walls", .terms = {&wall_jump}},
            {"forces", .before = {&body_force}, .terms = {&viscosity, &transposed_viscosity, &wall_friction}},
        },
    .power = {&projected_power, &friction_power},
    .state = FIELD(ID) | FIELD(PHASE) | FIELD(X) | FIELD(V) | FIELD(RHO) | FIELD(P) | FIELD(M) | FIELD(A) | FIELD(REF),
    .given = PASS_RATES,
    .derived_passes = {PASS_RATES, PASS_RATES + 5},
    .projects = true,
    .symmetric = true,
    .corrects_density = true,
    .floors_mirror = true,
    .check = incompressible_check,
    .options = incompressible_options,
};
