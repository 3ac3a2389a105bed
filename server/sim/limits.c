/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/limits.h"
#include "sim/gravity.h"
#include "sim/terms/average.h"
#include <math.h>

/* Largest speed of fluid or wall. */
static double speed(const MnsSim *sim)
{
    const Model *model = &sim->model;
    double v2 = sim->v_max * sim->v_max;
    for (size_t k = 0; k < model->n_walls; k++) {
        double wall_v2 = 0;
        for (int d = 0; d < model->dim; d++) {
            const double v = model->wall[k].v[d] + model->wall[k].belt[d];
            wall_v2 += v * v;
        }
        v2 = fmax(v2, wall_v2);
    }
    return sqrt(v2);
}

static double acoustic(const MnsSim *sim)
{
    return sim->model.cfl * sim->model.kernel.h / (sim->model.c_max + speed(sim));
}

double limits_expected_speed(const Model *model)
{
    double gh = 0;
    if (model->projection.speed >= 0) return model->projection.speed;
    for (int d = 0; d < model->dim; d++) gh += fabs(model->gravity[d]) * (model->max[d] - model->min[d]);
    return sqrt(gh);
}

/* Faster than what the flow is doing now, as the correction of densities has a speed of its own. */
static double flow(const MnsSim *sim)
{
    const Model *model = &sim->model;
    const double fastest = limits_expected_speed(model) + speed(sim);
    return fastest > 0 ? model->cfl * model->kernel.h / fastest : INFINITY;
}

/* Gravity, or what the acceleration of a wall adds to it for those who lie on that wall. */
static double body_force(const MnsSim *sim)
{
    const Model *model = &sim->model;
    double g2 = 0;
    for (int d = 0; d < model->dim; d++) g2 += model->gravity[d] * model->gravity[d];
    for (size_t k = 0; k < model->n_walls; k++) {
        double felt2 = 0;
        for (int d = 0; d < model->dim; d++) {
            const double felt = model->gravity[d] - model->wall[k].a[d];
            felt2 += felt * felt;
        }
        g2 = fmax(g2, felt2);
    }
    return g2 > 0 ? 0.25 * sqrt(model->kernel.h / sqrt(g2)) : INFINITY;
}

/* What gravity would change by in the step that all else allows, if it went on as fast as it ever changes in it, bounds it as gravity itself does:
 * so a pulse gets several steps, and none steps over one that it could see. */
static double change(const MnsSim *sim, double dt)
{
    const double by = isfinite(dt) ? gravity_change(sim, sim->progress.t, dt) * dt : 0;
    return by > 0 ? 0.25 * sqrt(sim->model.kernel.h / by) : INFINITY;
}

/* The harmonic mean of two viscosities moves the lighter fluid. */
static double viscous_by(const MnsSim *sim, double factor)
{
    const Model *model = &sim->model;
    double least = INFINITY;
    for (size_t a = 0; a < model->n_phases; a++)
        for (size_t b = 0; b <= a; b++) {
            const Phase *p = &model->phase[a], *q = &model->phase[b];
            if (p->mu + q->mu <= 0) continue;
            const double h = model->kernel.h, mu = harmonic_mean(p->mu, q->mu);
            least = fmin(least, factor * h * h * fmin(p->rho0, q->rho0) / mu);
        }
    return least;
}

static double viscous(const MnsSim *sim)
{
    return viscous_by(sim, sim->model.radial ? 0.065 : 0.125);
}

static double radial_viscous(const MnsSim *sim)
{
    return viscous_by(sim, 0.085);
}

/* Waves of the interface move both fluids. */
static double tension(const MnsSim *sim)
{
    const Model *model = &sim->model;
    double least = INFINITY;
    for (size_t a = 0; a < model->n_phases; a++)
        for (size_t b = 0; b < a; b++) {
            const double rho = 0.5 * (model->phase[a].rho0 + model->phase[b].rho0), h = model->kernel.h;
            if (model->tension[a][b] > 0)
                least = fmin(least, 0.25 * sqrt(rho * h * h * h / (2 * M_PI * model->tension[a][b])));
        }
    return least;
}

static double incompressible_viscous(const MnsSim *sim)
{
    return viscous_by(sim, 0.25);
}

/* Of mixtures of two fluids, whose viscosity over density is between theirs. */
static double mixture_viscous(const MnsSim *sim)
{
    const Model *model = &sim->model;
    double most = 0;
    for (size_t a = 0; a < model->n_phases; a++) most = fmax(most, model->phase[a].mu / model->phase[a].rho0);
    return most > 0 ? 0.25 * model->kernel.h * model->kernel.h / most : INFINITY;
}

/* Diffusion of densities from particle to particle, by steps that go forward. Beside a light fluid a heavy one's coefficient is up to twice
 * that within it. */
static double dissipation(const MnsSim *sim)
{
    const Model *model = &sim->model;
    return model->delta > 0 ? 0.55 * model->kernel.h / (model->delta * model->c_max) : INFINITY;
}

/* With arithmetic averages a light particle is as stiff as the heavy one beside it. Twice as long steps need what damps them, all of it from a
 * delta of 0.25 on. */
static double stiff_interface(const MnsSim *sim)
{
    const Model *model = &sim->model;
    double least = INFINITY;
    if (model->density_average > 0) return INFINITY;
    for (size_t a = 0; a < model->n_phases; a++)
        for (size_t b = 0; b < model->n_phases; b++) {
            const Phase *heavy = &model->phase[a], *light = &model->phase[b];
            if (light->rho0 < heavy->rho0)
                least = fmin(least, model->kernel.h / (heavy->c * sqrt(heavy->rho0 / light->rho0)));
        }
    return least * (1 + fmin(4 * model->delta, 1));
}

const Limit acoustic_limit = {
    .name = "sound and flow",
    .source = "P3 eq. 19",
    .equation = "dt <= cfl h / (c + |v|max)",
    .entries = "scheme.cfl, sound_speed, resolution",
    .of = acoustic,
};

const Limit body_force_limit = {
    .name = "body force",
    .source = "P3 eq. 20",
    .equation = "dt <= 0.25 sqrt(h / |g - a_w|)",
    .entries = "gravity, motion of walls, resolution",
    .of = body_force,
};

const Limit change_limit = {
    .name = "change of the body force",
    .source = "schemes/README.md",
    .equation = "dt <= 0.25 sqrt(h / (dt_0 |dg/dt|max)),  dt_0 what the others allow, |dg/dt|max within it",
    .entries = "gravity, resolution",
    .within = change,
};

const Limit viscous_limit = {
    .name = "viscosity",
    .source = "schemes/riemann.md",
    .equation = "dt <= 0.125 h^2 rho / mu,  0.065 along the line of a pair",
    .entries = "viscosity, density, resolution",
    .of = viscous,
};

const Limit radial_viscous_limit = {
    .name = "viscosity",
    .source = "schemes/interfacial.md",
    .equation = "dt <= 0.085 h^2 rho / mu",
    .entries = "viscosity, density, resolution",
    .of = radial_viscous,
};

const Limit flow_limit = {
    .name = "flow",
    .source = "P4 eq. 37, 41",
    .equation = "dt <= cfl h / (c + |v|max),  c = reference_speed, or sqrt(|g| H)",
    .entries = "scheme.cfl, reference_speed of the scheme, resolution",
    .of = flow,
};

const Limit incompressible_viscous_limit = {
    .name = "viscosity",
    .source = "P4 eq. 38",
    .equation = "dt <= 0.25 h^2 rho / mu",
    .entries = "viscosity, density, resolution",
    .of = incompressible_viscous,
};

const Limit mixture_viscous_limit = {
    .name = "viscosity",
    .source = "schemes/differences.md",
    .equation = "dt <= 0.25 h^2 rho / mu,  of each fluid",
    .entries = "viscosity, density, resolution",
    .of = mixture_viscous,
};

const Limit tension_limit = {
    .name = "surface tension",
    .source = "P1 eq. 23",
    .equation = "dt <= 0.25 sqrt(rho h^3 / (2 pi sigma)),  rho the mean of the two",
    .entries = "interfaces, density, resolution",
    .of = tension,
};

const Limit interface_limit = {
    .name = "stiffness across interfaces",
    .source = "schemes/dissipation.md",
    .equation = "dt <= h / (c_h sqrt(rho_h / rho_l)) (1 + min(4 delta, 1)); none with averages by density",
    .entries = "pair_average of the scheme, density, sound_speed, resolution",
    .of = stiff_interface,
};

const Limit dissipation_limit = {
    .name = "dissipation",
    .source = "schemes/dissipation.md",
    .equation = "dt <= 0.55 h / (delta c)",
    .entries = "delta of the scheme, sound_speed, resolution",
    .of = dissipation,
};

double limits_dt(const MnsSim *sim, const Limit **ret_limit)
{
    double least = INFINITY;
    const Limit *const *limits = sim->scheme->limits;
    if (ret_limit) *ret_limit = limits[0];
    for (int k = 0; k < SCHEME_LIMITS_MAX && limits[k]; k++) {
        const double dt = limits[k]->within ? limits[k]->within(sim, least) : limits[k]->of(sim);
        if (dt >= least) continue;
        least = dt;
        if (ret_limit) *ret_limit = limits[k];
        if (isnan(dt)) break;
    }
    return least;
}
