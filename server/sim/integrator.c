/* SPDX-License-Identifier: BSD-3-Clause */
/* What all integrators share: walls and lists at a new time, the rates there, a start and a restart. */
#include "sim/integrator.h"
#include "sim/belts.h"
#include "sim/gravity.h"
#include "sim/making.h"
#include "sim/terms/differences.h"
#include <math.h>
#include <omp.h>

/* While it is made, who may give it up takes the question for a sign of life, and gives it up where that ends. */
static void tell(const MnsSim *sim)
{
    if (sim->making.given_up) sim->making.given_up(sim->making.arg);
    watcher_tell(&sim->watcher);
}

void integrator_clock(MnsSim *sim, size_t timer, double start)
{
    tell(sim);
    sim->timers[timer].seconds += omp_get_wtime() - start;
    sim->timers[timer].calls++;
}

/* Walls go where their motion has them at the end of the step. Most never move. */
static void move_walls(MnsSim *sim, const WallState *before)
{
    Particles *s = &sim->s;
    const Model *model = &sim->model;
    bool move = false;
    for (size_t k = 0; k < model->n_walls; k++)
        for (int d = 0; d < s->dim; d++)
            move = move || model->wall[k].x[d] != before[k].x[d] || model->wall[k].v[d] != before[k].v[d] ||
                   model->wall[k].belt[d] != before[k].belt[d];
    if (!move) return;
    particles_changed(s, ON_WALL, FIELD(X) | FIELD(V));
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = s->begin[GROUP_WALL]; i < s->n; i++) {
        const size_t k = s->phase[i] - model->n_phases;
        for (int d = 0; d < s->dim; d++) {
            s->x[d][i * s->x_step] += model->wall[k].x[d] - before[k].x[d];
            s->v[d][i * s->v_step] = model->wall[k].v[d];
        }
    }
    belts_run(sim);
}

/* Has some particle moved half a skin since the lists were built? */
static bool lists_are_stale(const MnsSim *sim)
{
    const Particles *s = &sim->s;
    const size_t step = s->x_step;
    const double *x = s->x[0], *y = s->x[1], *z = s->dim == 3 ? s->x[2] : s->x[0];
    const double *rx = s->ref[0], *ry = s->ref[1], *rz = s->dim == 3 ? s->ref[2] : s->ref[0];
    const double flat = s->dim == 3 ? 1 : 0, allowed = 0.25 * sim->model.skin * sim->model.skin;
    size_t strays = 0;
#pragma omp parallel for simd schedule(static) reduction(+ : strays) num_threads(sim->threads)
    for (size_t i = 0; i < s->n; i++) {
        const double dx = x[i * step] - rx[i], dy = y[i * step] - ry[i], dz = (z[i * step] - rz[i]) * flat;
        strays += dx * dx + dy * dy + dz * dz > allowed;
    }
    return strays > 0;
}

/* Where the step began moves by the same periods as where it is, or the end of the step would put particles beyond the side again. */
static void wrap_beginning(MnsSim *sim, int d)
{
    const Particles *s = &sim->s;
    const double period = sim->model.period[d], low = sim->model.min[d], frequency = sim->model.frequency[d];
    const size_t n = particles_fluid(s), step = s->x_step;
    const double *restrict x = s->x[d];
    double *restrict x0 = s->x0[d];
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++) x0[i] -= period * floor((x[i * step] - low) * frequency);
}

/* Positions of periodic directions go back into the domain, and become those the lists are built from. */
static void remember_positions(MnsSim *sim)
{
    Particles *s = &sim->s;
    const size_t step = s->x_step;
    for (int d = 0; d < s->dim; d++) {
        const double period = sim->model.period[d], low = sim->model.min[d], frequency = sim->model.frequency[d];
        double *restrict x = s->x[d], *restrict ref = s->ref[d];
        if (s->x0[d]) wrap_beginning(sim, d);
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
        for (size_t i = 0; i < s->n; i++) {
            x[i * step] -= period * floor((x[i * step] - low) * frequency);
            ref[i] = x[i * step];
        }
    }
    particles_changed(s, ON_ALL, FIELD(X) | FIELD(REF) | FIELD(X0));
}

static MnsStatus build_lists(MnsSim *sim, MnsError *error)
{
    const double start = omp_get_wtime();
    system_forget(&sim->system); /* rows change places */
    const MnsStatus status = neighbours_build(&sim->nb, &sim->s, &sim->model, error);
    integrator_clock(sim, TIMER_NEIGHBOURS, start);
    return status;
}

void integrator_gravity(MnsSim *sim, double t, double dt)
{
    Particles *s = &sim->s;
    Model *model = &sim->model;
    double coming[3], change[3] = {0, 0, 0};
    gravity_mean(sim, t - dt, t, coming);
    for (int d = 0; d < s->dim; d++) change[d] = coming[d] - model->gravity[d];
    if (change[0] == 0 && change[1] == 0 && change[2] == 0) return;
    const double buoyancy = model->differences.buoyancy;
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < particles_fluid(s); i++) {
        const double share = buoyancy > 0 ? 1 - buoyancy / density_around(s, model, i) : 1;
        for (int d = 0; d < s->dim; d++) s->a[d][i] += share * change[d];
    }
    for (int d = 0; d < s->dim; d++) model->gravity[d] = coming[d];
    particles_changed(s, ON_FLUID, FIELD(A));
}

MnsStatus integrator_lists(MnsSim *sim, MnsError *error)
{
    if (!lists_are_stale(sim)) return MNS_OK;
    sim->progress.rebuilds++;
    remember_positions(sim);
    return build_lists(sim, error);
}

void integrator_pass(MnsSim *sim, int pass)
{
    const double start = omp_get_wtime();
    pass_run(&sim->scheme->rates[pass], &sim->s, &sim->nb, &sim->model, sim->threads);
    integrator_clock(sim, TIMER_PASSES + (size_t)pass, start);
}

void integrator_rates(MnsSim *sim, int first)
{
    for (int k = first; k < SCHEME_PASSES_MAX && sim->scheme->rates[k].name; k++) integrator_pass(sim, k);
}

void integrator_end_rates(MnsSim *sim, int first)
{
    for (int k = first; k < SCHEME_PASSES_MAX && sim->scheme->rates[k].name; k++)
        if (!sim->scheme->rates[k].halfway) integrator_pass(sim, k);
}

bool integrator_look(MnsSim *sim)
{
    const Particles *s = &sim->s;
    const Model *model = &sim->model;
    const size_t n = particles_fluid(s);
    double fastest = 0;
    size_t bad = 0;
#pragma omp parallel for schedule(static) reduction(max : fastest) reduction(+ : bad) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++) {
        double v2 = 0;
        for (int d = 0; d < s->dim; d++) v2 += s->v[d][i * s->v_step] * s->v[d][i * s->v_step];
        bad += !sim_is_well(s, model, i, v2);
        fastest = v2 > fastest ? v2 : fastest;
    }
    sim->v_max = sqrt(fastest);
    return bad == 0;
}

uint64_t integrator_walls(MnsSim *sim, double t, double dt, double ahead)
{
    WallState before[MNS_MAX_WALLS];
    for (size_t k = 0; k < sim->model.n_walls; k++) before[k] = sim->model.wall[k];
    setup_at(sim, t, dt, ahead);
    move_walls(sim, before);
    const uint64_t guarded = guard_walls(sim);
    /* Advection velocities are dt/2 of what is in B. */
    particles_changed(&sim->s, ON_FLUID, FIELD(X) | FIELD(V) | FIELD(B));
    return guarded;
}

MnsStatus integrator_step(MnsSim *sim, double t, double dt, MnsError *error)
{
    return sim->scheme->integrator->step(sim, t, dt, error);
}

/* What stands for passes the results of which are given. */
static void given_pass(MnsSim *sim)
{
    const Pass *pass = &sim->scheme->instead;
    if (pass->name) pass_run(pass, &sim->s, &sim->nb, &sim->model, sim->threads);
}

void integrator_derive(MnsSim *sim)
{
    particles_changed(&sim->s, ON_ALL, ALL_FIELDS);
    if (sim->scheme->derive) local_run(sim->scheme->derive, &sim->s, &sim->model, sim->threads);
    given_pass(sim); /* and which pairs are in reach, for those passes to have the rounding that they had */
    for (int k = sim->scheme->derived_passes[0]; k < sim->scheme->derived_passes[1]; k++) {
        if (sim->scheme->rates[k].halfway) continue;
        pass_run(&sim->scheme->rates[k], &sim->s, &sim->nb, &sim->model, sim->threads);
        tell(sim);
    }
}

/* Of a state, the results of the first passes of which are given. */
static void rates_of_given(MnsSim *sim)
{
    const Scheme *scheme = sim->scheme;
    given_pass(sim);
    integrator_rates(sim, scheme->given);
}

/* Of the velocities of now at the positions of now, as at a start: densities and shifts go on by no time, so that to do it twice is to do it once.
 * Accelerations that are no part of the state are derived from it. */
void integrator_renew(MnsSim *sim)
{
    Model *model = &sim->model;
    const double dt = model->dt, lag = model->lag;
    if (!(sim->scheme->state & FIELD(A))) return;
    model->dt = model->lag = 0;
    particles_changed(&sim->s, ON_ALL, ALL_FIELDS); /* with the rounding that is the same after a restart */
    rates_of_given(sim);
    model->dt = dt;
    model->lag = lag;
    if (sim->scheme->integrator->renew) sim->scheme->integrator->renew(sim);
}

MnsStatus integrator_restart(MnsSim *sim, MnsError *error)
{
    setup_at(sim, sim->progress.t, sim->progress.dt, 0);
    belts_run(sim); /* particles may lie in another order than before */
    MnsStatus status = build_lists(sim, error);
    if (!status) status = making_goes_on(&sim->making, error);
    if (status) return status;
    integrator_derive(sim);
    integrator_look(sim); /* how fast; whether all is well the first step tells */
    return MNS_OK;
}

MnsStatus integrator_start(MnsSim *sim, MnsError *error)
{
    remember_positions(sim);
    const MnsStatus status = integrator_restart(sim, error);
    /* What is done again shall have the rounding that a restart will have. */
    particles_changed(&sim->s, ON_ALL, ALL_FIELDS);
    if (!status) rates_of_given(sim);
    return status;
}
