/* SPDX-License-Identifier: BSD-3-Clause */
/* A step of an incompressible flow: two projections, one that keeps the number density of the particles, one that keeps the velocity
 * free of divergence.                                                                P4 2.1, schemes/incompressible.md
 *   x += dt (v + dt/2 a)
 *   while a number density is off by more than its tolerance: solve for a pressure, and move particles by it
 *   v += dt a;  solve for the pressure;  v -= dt grad p / rho
 *   a = forces but pressure, at the new positions and velocities
 * Gravity is its mean over the step, and walls know of it, so that a layer at rest is exact. */
#include "sim/integrator.h"
#include "sim/integrators/integrators.h"
#include "sim/integrators/pressure.h"
#include "sim/limits.h"
#include "sim/terms/terms.h"
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

/* Of which something is kept from one solve to the next. */
enum { MATRIX_VELOCITY, MATRIX_DENSITY };

static void drift(MnsSim *sim, double dt)
{
    Particles *s = &sim->s;
    const size_t n = particles_fluid(s), step = s->x_step, v_step = s->v_step;
    for (int d = 0; d < s->dim; d++) {
        double *restrict x = s->x[d];
        const double *restrict v = s->v[d], *restrict a = s->a[d];
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
        for (size_t i = 0; i < n; i++) x[i * step] += dt * (v[i * v_step] + 0.5 * dt * a[i]);
    }
    particles_changed(s, ON_FLUID, FIELD(X));
}

/* All forces but the pressure and gravity, which pushes walls and fluid alike and so needs no projection here. */
static void push(MnsSim *sim, double dt, const double gravity[3])
{
    Particles *s = &sim->s;
    const size_t n = particles_fluid(s), step = s->v_step;
    for (int d = 0; d < s->dim; d++) {
        double *restrict v = s->v[d];
        const double *restrict a = s->a[d], g = gravity[d];
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
        for (size_t i = 0; i < n; i++) v[i * step] += dt * (a[i] - g);
    }
    particles_changed(s, ON_FLUID, FIELD(V));
}

/* The largest error of a number density, over that of the lattice. */
static double density_error(const MnsSim *sim)
{
    const Particles *s = &sim->s;
    const double nominal = sim->model.cell_volume;
    double most = 0;
#pragma omp parallel for schedule(static) reduction(max : most) num_threads(sim->threads)
    for (size_t i = 0; i < particles_fluid(s); i++) {
        const double error = fabs(nominal / particles_volume(s, &sim->model, i) - 1);
        most = error > most ? error : most;
    }
    return most;
}

static void prepare(MnsSim *sim, int matrix, int pass)
{
    const int passes[] = {PASS_NUMBER, pass};
    system_keep(&sim->system, matrix);
    pressure_prepare(sim, passes, 2);
}

static MnsStatus correct_density_once(MnsSim *sim, MnsError *error)
{
    System *y = &sim->system;
    const PressureGoal goal = {"density", "density_solver_tolerance", sim->model.projection.correction_tolerance};
    SolveReport report;
    MnsStatus status = pressure_lay(sim, error);
    if (status) return status;
    prepare(sim, sim->model.projection.unit_mobility ? MATRIX_DENSITY : MATRIX_VELOCITY, PASS_DENSITY_SYSTEM);
    integrator_pass(sim, PASS_DENSITY_SYSTEM);
    system_clear(y);
    status = pressure_solve(sim, &goal, &report, error);
    if (status) return status;
    sim->solved.density_iterations += report.iterations;
    sim->solved.corrections++;
    system_centre(y);
    integrator_pass(sim, PASS_DENSITY_CORRECTION);
    status = integrator_lists(sim, error);
    if (!status) integrator_pass(sim, PASS_NUMBER);
    return status;
}

/* A correction that lowers the density's error by less than a part of it is in vain: where walls do not fit the particles, all may be. */
static const double ENOUGH = 0.98;

/* What is left of an error is not left to chance: it is counted, and the first is told. */
static void look_at_density(MnsSim *sim)
{
    const Solved *solved = &sim->solved;
    const double allowed = sim->model.projection.density_tolerance;
    if (!(solved->density_error > allowed) || sim->uncorrected++) return;
    plan_tell(
        sim,
        "scheme.%s.density_tolerance: step %llu leaves densities off by %.3g, not %.3g, after %u corrections; status "
        "counts such steps. Raise density_corrections or density_patience, or, where walls do not fit, the resolution",
        sim->scheme->name, (unsigned long long)sim->progress.step + 1, solved->density_error, allowed,
        solved->corrections);
}

static MnsStatus correct_density(MnsSim *sim, MnsError *error)
{
    const Projection *options = &sim->model.projection;
    MnsStatus status = integrator_lists(sim, error);
    if (status) return status;
    integrator_pass(sim, PASS_NUMBER);
    sim->solved.density_error = density_error(sim);
    double least = INFINITY;
    unsigned vain = 0;
    while (!status && sim->solved.density_error > options->density_tolerance &&
           sim->solved.corrections < options->corrections && vain < options->patience) {
        vain = sim->solved.density_error < ENOUGH * least ? 0 : vain + 1;
        least = fmin(least, sim->solved.density_error);
        status = correct_density_once(sim, error);
        sim->solved.density_error = density_error(sim);
    }
    if (!status) look_at_density(sim);
    return status;
}

/* The pressure has no mean, or is 0 where it is least in the light fluids: on a gas, a pressure that a liquid has no less of would act
 * through every fault of the arrangement, with the liquid's strength. A closed space without a light fluid keeps its mean of 0. */
static void gauge(MnsSim *sim)
{
    enum { LIGHT = 10 }; /* times as dense as the lightest at most: gases, or liquids alike */
    System *y = &sim->system;
    const Model *model = &sim->model;
    const Particles *s = &sim->s;
    system_centre(y);
    if (model->projection.mean_gauge) return;
    bool light[UINT8_MAX + 1] = {0};
    for (size_t a = 0; a < model->n_phases; a++) light[a] = model->phase[a].rho0 <= LIGHT * model->rho_min;
    const bool several = y->parts > 1; /* of one part `part` tells nothing */
    const uint32_t *restrict part = y->part;
    double least[PARTS_MAX], *restrict x = y->x;
    for (size_t k = 0; k < PARTS_MAX; k++) least[k] = INFINITY;
#pragma omp parallel for schedule(static) reduction(min : least) num_threads(sim->threads)
    for (size_t i = 0; i < particles_fluid(s); i++) {
        const uint32_t k = several ? part[i] : 0;
        if (light[s->phase[i]] && x[i] < least[k]) least[k] = x[i];
    }
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < y->matrix.n; i++) {
        const uint32_t k = several ? part[i] : 0;
        if (isfinite(least[k])) x[i] -= least[k];
    }
}

static void finish(MnsSim *sim, double dt)
{
    Particles *s = &sim->s;
    const size_t n = particles_fluid(s), v_step = s->v_step;
    for (int d = 0; d < s->dim; d++) {
        double *restrict v = s->v[d];
        const double change = dt * sim->model.gravity[d];
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
        for (size_t i = 0; i < n; i++) v[i * v_step] += change;
    }
    particles_changed(s, ON_FLUID, FIELD(V));
    /* The step before and density corrections leave some divergence. A short step removes it in less time, so its pressure is too high by 1/share. Weighted
     * by share^2 that error vanishes with the step, and the pressure before, if there is one, is of nearly the same time. */
    const double share = sim->progress.step > 0 ? pressure_share(sim, dt) : 1;
    pressure_keep(sim, dt, share * share);
}

/* gravity: that is in the accelerations. */
static MnsStatus project(MnsSim *sim, double dt, const double gravity[3], MnsError *error)
{
    const PressureGoal goal = {"velocity", "tolerance", sim->model.projection.tolerance};
    SolveReport report;
    push(sim, dt, gravity);
    integrator_pass(sim, PASS_WALLS);
    MnsStatus status = pressure_lay(sim, error);
    if (status) return status;
    prepare(sim, MATRIX_VELOCITY, PASS_VELOCITY_SYSTEM);
    integrator_pass(sim, PASS_VELOCITY_SYSTEM);
    pressure_guess(sim, dt);
    status = pressure_solve(sim, &goal, &report, error);
    sim->solved.iterations = report.iterations;
    sim->solved.residual = report.residual;
    if (status) return status; /* what was not found corrects nothing */
    gauge(sim);
    integrator_pass(sim, PASS_VELOCITY_CORRECTION);
    return MNS_OK;
}

static MnsStatus step(MnsSim *sim, double t, double dt, MnsError *error)
{
    const double start = omp_get_wtime();
    double gravity[3]; /* that is in the accelerations */
    integrator_gravity(sim, t, dt);
    memcpy(gravity, sim->model.gravity, sizeof gravity);
    sim->solved = (Solved){0};
    drift(sim, dt);
    sim->progress.guarded += integrator_walls(sim, t, dt, 0);
    integrator_clock(sim, TIMER_DRIFT, start);
    MnsStatus status = correct_density(sim, error);
    if (!status) status = project(sim, dt, gravity, error);
    if (status) return status;
    finish(sim, dt);
    const bool well = integrator_look(sim);
    /* The first of the rates is done again by a restart, and shall have the rounding that it has then. */
    particles_changed(&sim->s, ON_ALL, FIELD(X));
    integrator_rates(sim, PASS_RATES);
    return well ? MNS_OK : fault_particle(sim, error);
}

/* The velocities of the fluid, to be given back. */
static double *copy_velocities(const Particles *s, int threads)
{
    const size_t n = particles_fluid(s);
    double *copy = malloc((n + 1) * (size_t)s->dim * sizeof *copy);
    for (int d = 0; copy && d < s->dim; d++)
#pragma omp parallel for simd schedule(static) num_threads(threads)
        for (size_t i = 0; i < n; i++) copy[(size_t)d * n + i] = s->v[d][i * s->v_step];
    return copy;
}

static void give_back_velocities(Particles *s, double *copy, int threads)
{
    const size_t n = particles_fluid(s);
    for (int d = 0; d < s->dim; d++)
#pragma omp parallel for simd schedule(static) num_threads(threads)
        for (size_t i = 0; i < n; i++) s->v[d][i * s->v_step] = copy[(size_t)d * n + i];
    particles_changed(s, ON_FLUID, FIELD(V));
    free(copy);
}

/* Find the pressure at once, by a whole step in which nothing moves: a step that is cut short shows only a part of the change. If memory or the solver fails,
 * the pressure of before stays, and the steps that follow bring the new one. The first step of a run shows its own. */
static void renew(MnsSim *sim)
{
    const Solved solved = sim->solved;
    const double before = sim->model.dt, dt = limits_dt(sim, NULL);
    double *copy = sim->progress.step > 0 && isfinite(dt) && dt > 0 ? copy_velocities(&sim->s, sim->threads) : NULL;
    MnsError why;
    if (!copy) return;
    sim->model.dt = dt;
    integrator_pass(sim, PASS_NUMBER);
    if (!project(sim, dt, sim->model.gravity, &why)) pressure_keep(sim, dt, 1);
    give_back_velocities(&sim->s, copy, sim->threads);
    sim->model.dt = before;
    sim->solved = solved;
    integrator_derive(sim);
}

const Integrator double_projection = {
    .name = "two projections",
    .source = "P4 2.1",
    .equation = "x += dt (v + dt/2 a);  density corrections;  v += dt a - dt grad p/rho;  rates",
    .step = step,
    .renew = renew,
};
