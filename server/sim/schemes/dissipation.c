/* SPDX-License-Identifier: BSD-3-Clause */
/* P1: weakly compressible SPH with generalized density dissipation, for free surfaces and interfaces of any number of fluids.
 * B. X. Zheng, Z. W. Cai, P. D. Zhao, X. Y. Xu, T. S. Chan, P. Yu, A generalized density dissipation for weakly-compressible SPH. */
#include "sim/case_bounds.h"
#include "sim/check.h"
#include "sim/integrators/integrators.h"
#include "sim/limits.h"
#include "sim/locals/locals.h"
#include "sim/terms/terms.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Of densities, beyond which a gas at rest is stirred by what the pressure of the liquid is off. */
static const double MOST_RATIO = 1000;

static MnsStatus check_ratio(const MnsCase *c, MnsError *error)
{
    for (size_t a = 0; a < c->n_fluids; a++)
        for (size_t b = 0; b < c->n_fluids; b++)
            if (c->fluids[a].density > MOST_RATIO * (1 + 1e-9) * c->fluids[b].density)
                return mns_fail_at(
                    error, MNS_E_INVALID, "fluids",
                    "%.60s is %.4g times as dense as %.60s, and the scheme dissipation holds a gas up to "
                    "%g; take a denser one, which moves a liquid as little, or incompressible",
                    c->fluids[a].name, c->fluids[a].density / c->fluids[b].density, c->fluids[b].name, MOST_RATIO);
    return MNS_OK;
}

/* Of sounds, as the lighter fluid's over the heavier's, by what holds in dissipation.md: beyond, what volumes are off becomes a pressure, as the lighter
 * is stiff too, and drops that fall make energy; and what the pressure of a liquid at rest is off by moves a gas as much as it yields. */
static const double FASTEST = 1.2, FASTEST_ALIKE = 1.5, ALIKE = 1.5; /* sound; of densities that are alike */
static const double FASTEST_TENSE = 2, STIFFEST_TENSE = 0.04;        /* sound, rho c^2 of a gas with tension */
static const double MOST_YIELDING = 1200; /* rho c of a liquid under gravity over the gas's */

static bool is_heavy(const MnsCase *c)
{
    for (int d = 0; d < c->dim; d++) {
        char *end;
        if (c->gravity[d] && (strtod(c->gravity[d], &end) != 0 || *end)) return true;
    }
    return false;
}

static void bound_sound(const MnsCase *c, size_t light, size_t heavy, double *ret_low, double *ret_high)
{
    const double ratio = c->fluids[heavy].density / c->fluids[light].density;
    const bool gas = ratio > 1 / GAS_DENSITY;
    *ret_low = gas && is_heavy(c) ? ratio / MOST_YIELDING : 0;
    *ret_high = ratio < ALIKE ? FASTEST_ALIKE : FASTEST;
    if (gas && c->tension[light][heavy] > 0) *ret_high = fmin(sqrt(STIFFEST_TENSE * ratio), FASTEST_TENSE);
}

/* Sounds of a fluid beside a denser one. */
static MnsStatus check_sound(const MnsCase *c, size_t light, size_t heavy, MnsError *error)
{
    const MnsFluid *a = &c->fluids[light], *b = &c->fluids[heavy];
    char at[64], range[64];
    double low, high;
    bound_sound(c, light, heavy, &low, &high);
    const double quotient = a->sound_speed / b->sound_speed;
    if (quotient >= low * (1 - 1e-9) && quotient <= high * (1 + 1e-9)) return MNS_OK;
    if (low > 0) snprintf(range, sizeof range, "from %.4g to %.4g m/s", low * b->sound_speed, high * b->sound_speed);
    else snprintf(range, sizeof range, "up to %.4g m/s", high * b->sound_speed);
    snprintf(at, sizeof at, "fluids[%zu].sound_speed", light);
    return mns_fail_at(
        error, MNS_E_INVALID, at,
        "%.60s has a sound of %.4g m/s beside %.60s of %.4g m/s, which is %.4g times as dense, and the scheme "
        "dissipation holds %s there; give both fluids one sound_speed, or take the scheme %s",
        a->name, a->sound_speed, b->name, b->sound_speed, b->density / a->density, range,
        c->tension[light][heavy] > 0 ? "incompressible" : "riemann");
}

static MnsStatus check_sounds(const MnsCase *c, MnsError *error)
{
    MnsStatus status = MNS_OK;
    for (size_t a = 0; a < c->n_fluids && !status; a++)
        for (size_t b = 0; b < c->n_fluids && !status; b++)
            if (a != b && c->fluids[a].density <= c->fluids[b].density) status = check_sound(c, a, b, error);
    return status;
}

static MnsStatus dissipation_check(const MnsCase *c, MnsError *error)
{
    MnsStatus status = check_ratio(c, error);
    if (!status) status = check_sounds(c, error);
    if (status) return status;
    const MnsDissipation *q = &c->scheme.dissipation;
    const Bounded list[] = {
        {"delta", q->delta, BOUNDS_Dissipation_delta},
        {"repulsion", q->repulsion, BOUNDS_Dissipation_repulsion},
        {"background_pressure", q->background_pressure, BOUNDS_Dissipation_background_pressure},
        {"guard", q->guard, BOUNDS_Dissipation_guard},
    };
    return CHECK_BOUNDS("scheme.dissipation", list, error);
}

static bool dissipation_keeps_options(const MnsSchemeOptions *a, const MnsSchemeOptions *b)
{
    return a->dissipation.background_pressure == b->dissipation.background_pressure;
}

/* How strongly liquids beside a fluid that fills are shifted, A of P2 eq. 50; without it the front of a dam break leaves voids. */
static const double BESIDE_FILLING = 2;

/* And those that fill all there is. Particles that keep no order act as a viscosity: vortices of 20 particles decay as with 1.39 times their own, and as with
 * 1.05 times with the shift (dissipation.md, "Full tanks"). With gradients that are not corrected it is their error instead, and no shift helps. */
static const double IN_FULL_TANKS = 4;

/* A gas that P1 alone would have burst: at a ratio of 1000 arithmetic averages bring it to thirty times the speed of the water, and averages by
 * density leave voids of a third. Beside a heavier liquid a light one leaves voids too. It is done for gases alone with tension, where it would shake
 * interfaces, and where there is a free surface, whose spray would be torn; and of several liquids for the lightest, as two that go through each
 * other's interface tear it. */
static bool fills(const Model *model, double density)
{
    const bool lightest = density <= model->rho_min && density < model->rho_max,
               light = lightest && model->filled && !model->tense;
    return model->density_average > 0 && (light || model_is_gas(model, density));
}

/* All of a gas; of a liquid the less, the nearer it is to the heaviest: less stirs it, and its waves and vortices would be braked. By the square a layer
 * of a tenth sloshes as without. */
static double resistance(const Model *model, double density)
{
    const double light = (model->rho_max / density - 1) / (1 / GAS_DENSITY - 1);
    return fmin(1, light * light);
}

static void tend_light_fluids(Model *model)
{
    model->any_fills = false;
    for (size_t k = 0; k < model->n_phases; k++) {
        Phase *fluid = &model->phase[k];
        fluid->fills = fills(model, fluid->rho0);
        fluid->resists = fluid->fills ? resistance(model, fluid->rho0) : 0;
        model->any_fills = model->any_fills || fluid->fills;
    }
    model->shifting = model->any_fills                             ? BESIDE_FILLING
                      : model->filled && model->corrects_gradients ? IN_FULL_TANKS
                                                                   : 0;
    model->shifts_along_interfaces = model->shifting > 0;
    model->own_gradients = model->any_fills || model->tense ? 1 : 0; /* a jump of the pressure is no slope */
}

static void dissipation_options(Model *model, const MnsCase *c)
{
    const MnsDissipation *options = &c->scheme.dissipation;
    model->radial = true;
    model->delta = options->delta;
    model->dissipates_rest = options->form != MNS_DISSIPATION_PLAIN;
    model->keeps_pair_volume = options->form == MNS_DISSIPATION_GENERALIZED;
    model->corrects_gradients = options->gradient_correction;
    model->repulsion = options->repulsion;
    model->density_average = options->pair_average == MNS_AVERAGE_DENSITY ? 1 : 0;
    tend_light_fluids(model);
    model->guard = options->guard * model->dx;
    for (size_t k = 0; k < model->n_phases; k++) model->phase[k].background = options->background_pressure;
}

const Scheme scheme_dissipation = {
    .name = "dissipation",
    .title = "SPH with generalized density dissipation",
    .source = "P1: Zheng and others",
    .arithmetic_ratio = 200,
    .takes_background = true,
    .suited = {{MNS_TRUNCATED_GAUSSIAN, 1.1, 1.1, 1.5}, {MNS_WENDLAND_C2, 1.6, 1.6, 2}},
    .bound_sound = bound_sound,
    .integrator = &predictor_corrector,
    .limits = {&acoustic_limit, &interface_limit, &tension_limit, &body_force_limit, &viscous_limit, &dissipation_limit,
               &change_limit},
    .rates =
        {
            {"shifting", .terms = {&concentration, &shifting}, .after = {&shifted_position}},
            {"shape", .before = {&linear_pressure},
             .terms = {&shepard_sum, &pressure_gradient, &interface_normal, &corrected_continuity},
             .fusions = {&dissipation_shape, &dissipation_shape_beside}},
            {"curvature", .terms = {&raw_curvature}, .fusions = {&no_raw_curvature, &raw_curvature_alone},
             .halfway = true},
            {"mean curvature", .terms = {&mean_curvature}, .fusions = {&no_mean_curvature, &mean_curvature_alone},
             .halfway = true},
            {"mean of it", .terms = {&next_mean}, .fusions = {&no_next_mean, &next_mean_alone}, .halfway = true},
            {"sharp curvature", .terms = {&sharp_curvature}, .fusions = {&no_sharp_curvature, &sharp_curvature_alone},
             .halfway = true},
            {"walls", .terms = {&wall_pressure, &wall_velocity}},
            {"rates", .before = {&body_force},
             .terms = {&continuity, &density_dissipation, &pressure_force, &corrected_pressure_force, &radial_viscosity,
                       &gas_dissipation, &radial_friction},
             .fusions = {&dissipation_gas_rates, &dissipation_gas_rates_beside, &dissipation_viscous_rates,
                         &dissipation_rates, &dissipation_rates_beside}},
        },
    .power = {&product_power, &corrected_power, &radial_friction_power},
    .state = FIELD(ID) | FIELD(PHASE) | FIELD(X) | FIELD(V) | FIELD(RHO) | FIELD(M) | FIELD(REF) | FIELD(CURVATURE),
    .derive = &linear_pressure,
    .given = 1,
    .derived_passes = {1, 8},
    .check = dissipation_check,
    .keeps_options = dissipation_keeps_options,
    .options = dissipation_options,
};
