/* SPDX-License-Identifier: BSD-3-Clause */
/* P3: weakly compressible SPH with a low-dissipation two-phase Riemann solver and transport velocity, here in heavy fluids too.
 * M. Rezavand, C. Zhang, X. Y. Hu, Journal of Computational Physics 402 (2020). */
#include "sim/case_bounds.h"
#include "sim/check.h"
#include "sim/integrators/integrators.h"
#include "sim/limits.h"
#include "sim/locals/locals.h"
#include "sim/sim.h"
#include "sim/terms/terms.h"
#include <math.h>

/* A gas gets the summed density that keeps it from opening voids. Between liquids, even oil and mercury, continuity is ten times
 * as accurate at rest. */
static bool is_summed(const Model *model, const MnsFluid *fluid)
{
    if (fluid->density_method != MNS_DENSITY_AUTOMATIC) return fluid->density_method == MNS_DENSITY_SUMMATION;
    return model_is_gas(model, fluid->density);
}

static bool any_summed(const Model *model)
{
    for (size_t k = 0; k < model->n_phases; k++)
        if (model->phase[k].summation) return true;
    return false;
}

/* At a free surface nothing would hold heavy particles back, so they are spread only where fluids and walls fill the domain,
 * and gently beside a gas, where the water's front and jets are almost such surfaces. A light fluid fills whatever is open to
 * it anyway. */
static double background_factor(const Model *model, const MnsRiemann *options, bool summation)
{
    if (!summation && !model->filled) return 0;
    return !summation && any_summed(model) ? options->heavy_background_pressure : options->background_pressure;
}

/* A step moves particles by dt^2 p_b: more than at this factor of the acoustic step, and those of a filled space are thrown about by it. */
static const double SPREAD_UP_TO = 0.25;

/* A Laplacian is wrong at a free surface, and where viscosities differ; what acts along the line of a pair needs three rows of neighbours for a flow along
 * them, and lets 2 % less through a channel with two. */
static bool acts_along_pairs(const Model *model)
{
    const bool wide = model->kernel.h > 1.6 * model->dx * (1 - 1e-9);
    for (size_t k = 1; k < model->n_phases; k++)
        if (wide && model->phase[k].mu != model->phase[0].mu) return true;
    return !model->filled;
}

/* Of pressures. */
static Spared spared_by(const Model *model, MnsReconstruction reconstruction)
{
    if (reconstruction == MNS_RECONSTRUCTION_BOTH) return SPARED_SLOPES;
    return reconstruction == MNS_RECONSTRUCTION_VELOCITY && !model->filled ? SPARED_WEIGHT : SPARED_NOTHING;
}

static MnsStatus riemann_check(const MnsCase *c, MnsError *error)
{
    const MnsRiemann *r = &c->scheme.riemann;
    const Bounded list[] = {
        {"limiter", r->limiter, BOUNDS_Riemann_limiter},
        {"background_pressure", r->background_pressure, BOUNDS_Riemann_background_pressure},
        {"heavy_background_pressure", r->heavy_background_pressure, BOUNDS_Riemann_heavy_background_pressure},
        {"guard", r->guard, BOUNDS_Riemann_guard},
    };
    for (size_t k = 0; k < c->n_fluids * c->n_fluids; k++)
        if (c->tension[k / c->n_fluids][k % c->n_fluids] > 0)
            return mns_fail_at(error, MNS_E_INVALID, "interfaces",
                               "the scheme riemann has no surface tension; take another scheme, or no tension");
    return CHECK_BOUNDS("scheme.riemann", list, error);
}

/* Of the defaults, below which particles are hardly spread. */
static const double HARDLY = 0.1, SPREAD = 4, SPREAD_HEAVY = 0.5;

static void look_at_spread(MnsSim *sim, const char *entry, double value, double advised)
{
    if (value >= HARDLY * advised) return;
    plan_warn(sim,
              "scheme.riemann.%s: with %g particles are hardly spread, and voids open where flows stretch; take %g",
              entry, value, advised);
}

static void riemann_look(MnsSim *sim)
{
    const Model *model = &sim->model;
    const MnsRiemann *r = &sim->c->scheme.riemann;
    const bool mixed = any_summed(model);
    bool heavy = false;
    for (size_t k = 0; k < model->n_phases; k++) heavy = heavy || !model->phase[k].summation;
    if (mixed || model->filled) look_at_spread(sim, "background_pressure", r->background_pressure, SPREAD);
    if (mixed && heavy && model->filled)
        look_at_spread(sim, "heavy_background_pressure", r->heavy_background_pressure, SPREAD_HEAVY);
}

static void riemann_options(Model *model, const MnsCase *c)
{
    model->limiter = c->scheme.riemann.limiter;
    model->radial = acts_along_pairs(model);
    model->transport_stress = c->scheme.riemann.transport_stress;
    model->reconstructs = c->scheme.riemann.reconstruction != MNS_RECONSTRUCTION_NONE;
    model->spared = spared_by(model, c->scheme.riemann.reconstruction);
    model->guard = c->scheme.riemann.guard * model->dx;
    const double longer = fmax(1, model->cfl / SPREAD_UP_TO);
    for (size_t k = 0; k < model->n_phases; k++) model->phase[k].summation = is_summed(model, &c->fluids[k]);
    for (size_t k = 0; k < model->n_phases; k++) {
        Phase *phase = &model->phase[k];
        const double factor = background_factor(model, &c->scheme.riemann, phase->summation);
        /* over dt ~ h/c_max: as fast as its own sound */
        phase->p_b = factor * phase->rho0 * phase->c * model->c_max / (longer * longer);
    }
}

const Scheme scheme_riemann = {
    .name = "riemann",
    .title = "low-dissipation Riemann SPH with transport velocity",
    .source = "P3: Rezavand, Zhang and Hu 2020",
    .reads_density_method = true,
    .suited = {{MNS_WENDLAND_C2, 1.3, 1.3, 2}},
    .free_smoothing = 1.6,
    .integrator = &kick_drift_kick,
    .limits = {&acoustic_limit, &body_force_limit, &viscous_limit, &change_limit},
    .rates =
        {
            {"density", .terms = {&number_density, &riemann_density, &strain_rate},
             .after = {&advance_density, &summed_density, &closed_volume, &linear_pressure},
             .fusions = {&number_density_alone, &riemann_density_alone, &strained_density, &weighed_density,
                         &sloped_density}},
            {"walls", .terms = {&wall_pressure, &wall_velocity, &pressure_slope}, .fusions = {&pressure_slope_alone}},
            {"forces", .before = {&body_force},
             .terms = {&riemann_momentum, &reconstructed_momentum, &transport_stress, &background, &viscosity,
                       &wall_friction, &radial_viscosity, &radial_friction},
             .fusions = {&riemann_forces, &reconstructed_forces, &transported_forces,
                         &transported_reconstructed_forces}},
        },
    .power = {&riemann_power, &friction_power, &radial_friction_power},
    .state = FIELD(ID) | FIELD(PHASE) | FIELD(X) | FIELD(V) | FIELD(RHO) | FIELD(M) | FIELD(A) | FIELD(B) | FIELD(REF),
    .given = 1,
    .instead = {"strain", .terms = {&strain_rate}},
    .derive = &linear_pressure,
    .derived_passes = {1, 2},
    .check = riemann_check,
    .look = riemann_look,
    .options = riemann_options,
};
