/* SPDX-License-Identifier: BSD-3-Clause */
/* P2: interfacial SPH, with particles shifted along interfaces. G. X. Zhu, L. Zou,
 * International Journal for Numerical Methods in Fluids (2020), doi 10.1002/fld.4813. */
#include "sim/case_bounds.h"
#include "sim/check.h"
#include "sim/integrators/integrators.h"
#include "sim/limits.h"
#include "sim/locals/locals.h"
#include "sim/terms/terms.h"
#include <math.h>

static double exponent_of(const Model *model, const MnsFluid *fluid)
{
    if (fluid->exponent > 0) return fluid->exponent;
    return model_is_gas(model, fluid->density) ? 1.4 : 7;
}

static MnsStatus interfacial_check(const MnsCase *c, MnsError *error)
{
    const MnsInterfacial *f = &c->scheme.interfacial;
    const Bounded list[] = {
        {"delta", f->delta, BOUNDS_Interfacial_delta},
        {"shifting_strength", f->shifting_strength, BOUNDS_Interfacial_shifting_strength},
        {"repulsion", f->repulsion, BOUNDS_Interfacial_repulsion},
        {"background_pressure", f->background_pressure, BOUNDS_Interfacial_background_pressure},
        {"guard", f->guard, BOUNDS_Interfacial_guard},
    };
    return CHECK_BOUNDS("scheme.interfacial", list, error);
}

static bool interfacial_keeps_options(const MnsSchemeOptions *a, const MnsSchemeOptions *b)
{
    return a->interfacial.background_pressure == b->interfacial.background_pressure;
}

static void interfacial_options(Model *model, const MnsCase *c)
{
    const MnsInterfacial *options = &c->scheme.interfacial;
    model->radial = true;
    model->delta = options->delta;
    model->dissipates_rest = model->keeps_pair_volume = true;
    model->own_gradients = model->tense ? 1 : 0; /* a jump of the pressure is no slope */
    model->repulsion = options->repulsion;
    model->shifting = options->shifting == MNS_SHIFTING_OFF ? 0 : options->shifting_strength;
    model->shifts_along_interfaces = options->shifting == MNS_SHIFTING_INTERFACE;
    model->corrects_gradients = options->gradient_correction;
    model->density_average = options->pair_average == MNS_AVERAGE_DENSITY ? 1 : 0;
    model->guard = options->guard * model->dx;
    for (size_t k = 0; k < model->n_phases; k++) {
        model->phase[k].background = options->background_pressure;
        model->phase[k].exponent = exponent_of(model, &c->fluids[k]);
    }
}

const Scheme scheme_interfacial = {
    .name = "interfacial",
    .title = "interfacial SPH with shifting along interfaces",
    .source = "P2: Zhu and Zou 2020",
    .arithmetic_ratio = INFINITY,
    .reads_exponent = true,
    .takes_background = true,
    .needs_background = true,
    .suited = {{MNS_WENDLAND_C2, 1.6, 1.6, 2}},
    .integrator = &kick_drift_kick,
    .limits = {&acoustic_limit, &interface_limit, &tension_limit, &body_force_limit, &radial_viscous_limit,
               &dissipation_limit, &change_limit},
    .rates =
        {
            {"density",
             .terms = {&shepard_sum, &concentration, &volume_continuity, &corrected_continuity, &density_dissipation},
             .after = {&advance_shepard_sum, &advance_density, &tait_pressure},
             .fusions = {&interfacial_density, &interfacial_density_within, &interfacial_density_across,
                         &interfacial_density_beside}},
            {"interfaces", .terms = {&corrected_normal}, .fusions = {&no_interface, &interfacial_normal}},
            {"curvature", .terms = {&raw_curvature}, .fusions = {&no_raw_curvature, &raw_curvature_alone}},
            {"mean curvature", .terms = {&mean_curvature}, .fusions = {&no_mean_curvature, &mean_curvature_alone}},
            {"mean of it", .terms = {&next_mean}, .fusions = {&no_next_mean, &next_mean_alone}},
            {"sharp curvature", .terms = {&sharp_curvature}, .fusions = {&no_sharp_curvature, &sharp_curvature_alone}},
            {"walls", .terms = {&wall_pressure, &mirrored_velocity}},
            {"forces", .before = {&body_force},
             .terms = {&volume_pressure_force, &corrected_pressure_force, &radial_viscosity, &radial_friction,
                       &pressure_gradient, &shifting},
             .after = {&shifted_position},
             .fusions = {&interfacial_viscous_forces, &interfacial_forces, &interfacial_forces_beside}},
            {"walls, shifted",
             .terms = {&shifted_wall_pressure}}, /* what they show, of the state that a run goes on from */
        },
    .power = {&squares_power, &corrected_power, &radial_friction_power},
    .state = FIELD(ID) | FIELD(PHASE) | FIELD(X) | FIELD(V) | FIELD(RHO) | FIELD(P) | FIELD(M) | FIELD(A) | FIELD(REF) |
             FIELD(SHEPARD) | FIELD(CURVATURE) | FIELD(GRADIENT) | FIELD(NORMAL) | FIELD(CONCENTRATION),
    .derived_passes = {6, 7},
    .check = interfacial_check,
    .keeps_options = interfacial_keeps_options,
    .options = interfacial_options,
};
