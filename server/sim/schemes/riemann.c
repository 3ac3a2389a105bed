/* SPDX-License-Identifier: BSD-3-Clause */
/* P3: weakly compressible SPH with a low-dissipation two-phase Riemann solver and transport velocity, here in heavy fluids too.
 * M. Rezavand, C. Zhang, X. Y. Hu, Journal of Computational Physics 402 (2020). */
#include "sim/integrators/integrators.h"
#include "sim/limits.h"
#include "sim/locals/locals.h"
#include "sim/terms/terms.h"

/* A fluid lighter than a fiftieth of the heaviest is a gas to it: it gets the summed density that keeps it from opening
 * voids. Between liquids, even oil and mercury, continuity is ten times as accurate at rest. */
static bool is_light(const MnsFluid *fluid, double rho_max)
{
    if (fluid->density_method == MNS_DENSITY_AUTOMATIC) return fluid->density < 0.02 * rho_max;
    return fluid->density_method == MNS_DENSITY_SUMMATION;
}

/* At a free surface nothing would hold heavy particles back, so they are spread only where fluids and walls fill the domain.
 * A light fluid fills whatever is open to it anyway. */
static double background_factor(const Model *model, const MnsCase *c, bool summation)
{
    if (summation) return c->scheme.riemann.background_pressure;
    return model->filled ? c->scheme.riemann.heavy_background_pressure : 0;
}

static void riemann_options(Model *model, const MnsCase *c)
{
    model->limiter = c->scheme.riemann.limiter;
    model->transport_stress = c->scheme.riemann.transport_stress;
    model->guard = c->scheme.riemann.guard * model->dx;
    for (size_t k = 0; k < model->n_phases; k++) {
        Phase *phase = &model->phase[k];
        phase->summation = is_light(&c->fluids[k], model->rho_max);
        phase->p_b = background_factor(model, c, phase->summation) * phase->rho0 * phase->c * phase->c;
    }
}

const Scheme scheme_riemann = {
    .name = "riemann",
    .title = "low-dissipation Riemann SPH with transport velocity",
    .source = "P3: Rezavand, Zhang and Hu 2020",
    .integrator = &kick_drift_kick,
    .limits = {&acoustic_limit, &body_force_limit, &viscous_limit},
    .rates =
        {
            {"density", .terms = {&number_density, &riemann_density},
             .after = {&advance_density, &mass_over_volume, &linear_pressure}},
            {"walls", .terms = {&wall_pressure, &wall_velocity}},
            {"forces", .before = {&body_force},
             .terms = {&riemann_momentum, &background, &transport_stress, &viscosity, &wall_friction}},
        },
    .given = 1,
    .derive = &linear_pressure,
    .restore = &scheme_riemann.rates[1],
    .options = riemann_options,
};
