/* SPDX-License-Identifier: BSD-3-Clause */
/* Kick, drift, kick, one evaluation of the rates a step.                                     P3 eq. 15-18, schemes/README.md
 *   v += dt/2 a;  w = dt/2 b;  x += dt (v + w);  densities, pressures, walls, forces at the new positions;  v += dt/2 a */
#include "sim/sim.h"
#include <math.h>
#include <omp.h>

static void clock_stop(MnsSim *sim, size_t timer, double start)
{
    sim->timers[timer].seconds += omp_get_wtime() - start;
    sim->timers[timer].calls++;
}

/* Half a kick and the drift of the fluid. */
static void kick_and_drift(MnsSim *sim, double dt)
{
    Particles *s = &sim->s;
    const size_t n = particles_fluid(s);
    const double half = 0.5 * dt;
    for (int d = 0; d < s->dim; d++) {
        double *restrict x = s->x[d], *restrict v = s->v[d], *restrict w = s->w[d];
        const double *restrict a = s->a[d], *restrict b = s->b[d];
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
        for (size_t i = 0; i < n; i++) {
            v[i] += half * a[i];
            w[i] = half * b[i];
            x[i] += dt * (v[i] + w[i]);
        }
    }
}

/* Walls go where their motion has them at the end of the step. */
static void move_walls(MnsSim *sim, const WallState *before)
{
    Particles *s = &sim->s;
    const Model *model = &sim->model;
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = s->begin[GROUP_WALL]; i < s->n; i++) {
        const size_t k = s->phase[i] - model->n_phases;
        for (int d = 0; d < s->dim; d++) {
            s->x[d][i] += model->wall[k].x[d] - before[k].x[d];
            s->v[d][i] = model->wall[k].v[d];
        }
    }
}

/* Has some particle moved half a skin since the lists were built? */
static bool lists_are_stale(const MnsSim *sim)
{
    const Particles *s = &sim->s;
    const double *x = s->x[0], *y = s->x[1], *z = s->dim == 3 ? s->x[2] : s->x[0];
    const double *rx = s->ref[0], *ry = s->ref[1], *rz = s->dim == 3 ? s->ref[2] : s->ref[0];
    const double flat = s->dim == 3 ? 1 : 0, allowed = 0.25 * sim->model.skin * sim->model.skin;
    double most = 0;
#pragma omp parallel for simd schedule(static) reduction(max : most) num_threads(sim->threads)
    for (size_t i = 0; i < s->n; i++) {
        const double dx = x[i] - rx[i], dy = y[i] - ry[i], dz = (z[i] - rz[i]) * flat;
        const double moved = dx * dx + dy * dy + dz * dz;
        most = moved > most ? moved : most;
    }
    return most > allowed;
}

/* Positions of periodic directions go back into the domain, and become those the lists are built from. */
static void remember_positions(MnsSim *sim)
{
    Particles *s = &sim->s;
    for (int d = 0; d < s->dim; d++) {
        const double period = sim->model.period[d], low = sim->model.min[d], frequency = sim->model.frequency[d];
        double *restrict x = s->x[d], *restrict ref = s->ref[d];
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
        for (size_t i = 0; i < s->n; i++) {
            x[i] -= period * floor((x[i] - low) * frequency);
            ref[i] = x[i];
        }
    }
}

static MnsStatus build_lists(MnsSim *sim, MnsError *error)
{
    const double start = omp_get_wtime();
    const MnsStatus status = neighbours_build(&sim->nb, &sim->s, &sim->model, error);
    clock_stop(sim, TIMER_NEIGHBOURS, start);
    return status;
}

static MnsStatus refresh_lists(MnsSim *sim, MnsError *error)
{
    if (!lists_are_stale(sim)) return MNS_OK;
    sim->progress.rebuilds++;
    remember_positions(sim);
    return build_lists(sim, error);
}

static void run_passes(MnsSim *sim, int first)
{
    const Pass *passes = sim->scheme->rates;
    for (int k = first; k < SCHEME_PASSES_MAX && passes[k].name; k++) {
        const double start = omp_get_wtime();
        pass_run(&passes[k], &sim->s, &sim->nb, &sim->model, sim->threads);
        clock_stop(sim, TIMER_PASSES + (size_t)k, start);
    }
}

/* The second half of the kick, and the two questions about its result: how fast, and is all well? */
static bool kick_and_look(MnsSim *sim, double dt)
{
    Particles *s = &sim->s;
    const Model *model = &sim->model;
    const size_t n = particles_fluid(s);
    const double half = 0.5 * dt;
    double fastest = 0;
    size_t bad = 0;
#pragma omp parallel for schedule(static) reduction(max : fastest) reduction(+ : bad) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++) {
        double v2 = 0;
        for (int d = 0; d < s->dim; d++) {
            s->v[d][i] += half * s->a[d][i];
            v2 += s->v[d][i] * s->v[d][i];
        }
        const double ratio = s->rho[i] / model->phase[s->phase[i]].rho0;
        bad += !(v2 < INFINITY && ratio > model->density_min && ratio < model->density_max);
        fastest = v2 > fastest ? v2 : fastest;
    }
    sim->v_max = sqrt(fastest);
    return bad == 0;
}

/* Largest speed of fluid or wall, and largest acceleration that gravity and a wall's motion give to what lies on it. */
static void fastest_and_heaviest(const MnsSim *sim, double *ret_speed, double *ret_acceleration)
{
    const Model *model = &sim->model;
    double v2 = sim->v_max * sim->v_max, g2 = 0;
    for (int d = 0; d < model->dim; d++) g2 += model->gravity[d] * model->gravity[d];
    for (size_t k = 0; k < model->n_walls; k++) {
        double wall_v2 = 0, felt2 = 0;
        for (int d = 0; d < model->dim; d++) {
            const double felt = model->gravity[d] - model->wall[k].a[d];
            wall_v2 += model->wall[k].v[d] * model->wall[k].v[d];
            felt2 += felt * felt;
        }
        v2 = fmax(v2, wall_v2);
        g2 = fmax(g2, felt2);
    }
    *ret_speed = sqrt(v2);
    *ret_acceleration = sqrt(g2);
}

double integrator_dt(const MnsSim *sim, const char **ret_limit)
{
    const Model *model = &sim->model;
    const double h = model->kernel.h;
    double speed, g;
    fastest_and_heaviest(sim, &speed, &g);
    double dt = model->cfl * h / (model->c_max + speed);
    *ret_limit = "sound and flow, P3 eq. 19 (scheme.cfl, sound_speed, resolution)";
    if (g > 0 && 0.25 * sqrt(h / g) < dt) {
        dt = 0.25 * sqrt(h / g);
        *ret_limit = "body force, P3 eq. 20 (gravity, motion of walls, resolution)";
    }
    for (size_t a = 0; a < model->n_phases; a++)
        for (size_t b = 0; b <= a; b++) {
            const Phase *p = &model->phase[a], *q = &model->phase[b];
            if (p->mu + q->mu <= 0) continue;
            const double mu = 2 * p->mu * q->mu / (p->mu + q->mu), limit = 0.125 * h * h * fmin(p->rho0, q->rho0) / mu;
            if (limit < dt) {
                dt = limit;
                *ret_limit = "viscosity, schemes/README.md (viscosity, density, resolution)";
            }
        }
    return dt;
}

MnsStatus integrator_step(MnsSim *sim, double t, double dt, MnsError *error)
{
    const double start = omp_get_wtime();
    WallState before[MNS_MAX_WALLS];
    for (size_t k = 0; k < sim->model.n_walls; k++) before[k] = sim->model.wall[k];
    kick_and_drift(sim, dt);
    setup_at(sim, t, dt);
    move_walls(sim, before);
    sim->progress.guarded += guard_walls(sim);
    clock_stop(sim, TIMER_DRIFT, start);

    const MnsStatus status = refresh_lists(sim, error);
    if (status) return status;
    run_passes(sim, 0);

    const double last = omp_get_wtime();
    const bool well = kick_and_look(sim, dt);
    clock_stop(sim, TIMER_KICK, last);
    return well ? MNS_OK : fault_particle(sim, error);
}

static double fastest(const MnsSim *sim)
{
    double most = 0;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        double v2 = 0;
        for (int d = 0; d < sim->s.dim; d++) v2 += sim->s.v[d][i] * sim->s.v[d][i];
        most = v2 > most ? v2 : most;
    }
    return sqrt(most);
}

/* All that a restored state does not hold follows from it: pressures, volumes, walls. */
MnsStatus integrator_restart(MnsSim *sim, MnsError *error)
{
    setup_at(sim, sim->progress.t, sim->progress.dt);
    const MnsStatus status = build_lists(sim, error);
    if (status) return status;
    local_run(sim->scheme->derive, &sim->s, &sim->model, sim->threads);
    if (sim->scheme->restore) pass_run(sim->scheme->restore, &sim->s, &sim->nb, &sim->model, sim->threads);
    sim->v_max = fastest(sim);
    return MNS_OK;
}

MnsStatus integrator_start(MnsSim *sim, MnsError *error)
{
    remember_positions(sim);
    const MnsStatus status = integrator_restart(sim, error);
    if (!status) run_passes(sim, sim->scheme->given);
    return status;
}
