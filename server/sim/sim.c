/* SPDX-License-Identifier: BSD-3-Clause */
/* A simulation from the outside: make it, step it, steer it, free it. Read this file first. */
#include "base/array.h"
#include "sim/belts.h"
#include "sim/chambers.h"
#include "sim/energy.h"
#include "sim/home.h"
#include "sim/integrator.h"
#include "sim/limits.h"
#include "sim/losses.h"
#include "sim/making.h"
#include "sim/mirrors.h"
#include "sim/shown.h"
#include "sim/terms/terms.h"
#include <omp.h>
#include <stdlib.h>

int sim_threads_for(const MnsCase *c)
{
    enum { ENOUGH = 64 }; /* to try out many on few processors; each has lists of its own */
    const int processors = omp_get_num_procs(), most = processors > ENOUGH ? processors : ENOUGH;
    if (c->threads == 0) return omp_get_max_threads();
    return c->threads < (unsigned)most ? (int)c->threads : most;
}

static void name_timers(MnsSim *sim)
{
    sim->timers[TIMER_NEIGHBOURS].name = "neighbours";
    sim->timers[TIMER_DRIFT].name = "drift";
    sim->timers[TIMER_KICK].name = "kick";
    sim->timers[TIMER_REST].name = "rest";
    sim->n_timers = TIMER_PASSES;
    for (int k = 0; k < SCHEME_PASSES_MAX && sim->scheme->rates[k].name; k++)
        sim->timers[sim->n_timers++].name = sim->scheme->rates[k].name;
    if (!sim->scheme->projects) return;
    sim->timer_setup = sim->n_timers++;
    sim->timer_solve = sim->n_timers++;
    sim->timers[sim->timer_setup].name = "solver set-up";
    sim->timers[sim->timer_solve].name = "solve";
}

static MnsStatus projection_init(MnsSim *sim, MnsError *error)
{
    if (!sim->model.filled)
        return mns_fail_at(error, MNS_E_INVALID, "fluids",
                           "the scheme %s needs fluids that fill the domain up to walls or periodic sides: there is an "
                           "empty place, or an open side",
                           sim->scheme->name);
    if (!system_init(&sim->system, sim->s.n, particles_fluid(&sim->s), sim->threads))
        return mns_fail(error, MNS_E_MEMORY, "no memory for the pressure system of %zu particles", sim->s.n);
    sim->s.system = &sim->system;
    return MNS_OK;
}

static MnsStatus sim_init(MnsSim *sim, const MnsCapture *capture, MnsError *error)
{
    MnsStatus status = setup_model(sim, error);
    if (!status && !(sim->shown = calloc(1, sizeof *sim->shown)))
        status = mns_fail(error, MNS_E_MEMORY, "no memory for a simulation");
    if (!status && !(sim->partial = array_new(sim_blocks(particles_fluid(&sim->s)) * SIM_SUMS, sizeof *sim->partial)))
        status = mns_fail(error, MNS_E_MEMORY, "no memory for a simulation");
    if (!status && sim->scheme->projects) status = projection_init(sim, error);
    if (!status)
        status = neighbours_init(&sim->nb, sim->s.n, sim->s.dim, scheme_needs(sim->scheme, &sim->model), sim->threads,
                                 error);
    if (!status) status = making_goes_on(&sim->making, error);
    if (!status) status = capture ? mns_sim_restore(sim, capture, error) : integrator_start(sim, error);
    if (!status && !capture && sim->scheme->projects) status = chambers_check(sim, error);
    if (!status) home_enter(&sim->s, &sim->nb.bundles, sim->scheme, &sim->model, sim->threads);
    if (!status) status = making_goes_on(&sim->making, error);
    if (!status) status = plan_check(sim, sim->c, capture != NULL, error); /* now that speeds are known */
    if (!status) plan_look(sim);
    if (!status) energy_begin(sim);
    return status;
}

MnsStatus mns_sim_make(const MnsCase *c, const MnsCapture *capture, const MnsMaking *making, MnsSim **ret_sim,
                       MnsError *error)
{
    MnsStatus status = mns_case_check(c, error);
    if (status) return status;
    MnsSim *sim = calloc(1, sizeof *sim);
    if (!sim) return mns_fail(error, MNS_E_MEMORY, "no memory for a simulation");
    sim->c = c;
    sim->scheme = scheme_find(c->scheme.name);
    sim->threads = sim_threads_for(c);
    sim->losses.least_coverage = NAN;
    name_timers(sim);
    if (capture) sim->progress = capture->progress;
    sim->resumed = capture;
    if (making) sim->making = *making;
    status = sim_init(sim, capture, error);
    if (status) {
        mns_sim_free(sim);
        return status;
    }
    sim->making = (MnsMaking){0}; /* what it has to do with ends here */
    *ret_sim = sim;
    return MNS_OK;
}

MnsStatus mns_sim_new(const MnsCase *c, MnsSim **ret_sim, MnsError *error)
{
    return mns_sim_make(c, NULL, NULL, ret_sim, error);
}

MnsStatus mns_sim_resume(const MnsCase *c, const MnsCapture *capture, MnsSim **ret_sim, MnsError *error)
{
    return mns_sim_make(c, capture, NULL, ret_sim, error);
}

void mns_sim_free(MnsSim *sim)
{
    if (!sim) return;
    for (int d = 0; d < 3; d++) formula_free(sim->gravity[d]);
    for (size_t k = 0; k < MNS_MAX_WALLS; k++) {
        for (int d = 0; d < 3; d++) formula_free(sim->surface[k][d]);
        if (sim->solid[k].shape) shape_done(&sim->solid[k]);
    }
    for (size_t k = 0; k < MNS_MAX_PROBES; k++) formula_team_done(&sim->probe_formula[k]);
    free(sim->face);
    belts_done(&sim->belts);
    for (int f = 0; sim->shown && f < FIELDS_END; f++)
        for (int d = 0; d < 3; d++) free(sim->shown->of[f][d]);
    free(sim->shown);
    free(sim->partial);
    system_done(&sim->system);
    neighbours_done(&sim->nb);
    particles_done(&sim->s);
    free(sim);
}

void mns_sim_watch(MnsSim *sim, void (*going_on)(void *arg), void *arg)
{
    sim->watcher = sim->system.watcher = (Watcher){going_on, arg};
}

MnsStatus sim_remember(MnsSim *sim, MnsStatus status, const MnsError *why, MnsError *error)
{
    sim->fault = *why;
    sim->fault.status = status;
    if (error) *error = sim->fault;
    return status;
}

/* The time the step of length *dt ends; a rest too short to be told from rounding is taken with it. */
static double cut(double t, double *dt, double t_max)
{
    const double end = t + *dt;
    if (end < t_max - 1e-9 * *dt) return end;
    *dt = t_max - t;
    return t_max;
}

/* What all timers have together [s]. */
static double timed(const MnsSim *sim)
{
    double seconds = 0;
    for (size_t k = 0; k < sim->n_timers; k++) seconds += sim->timers[k].seconds;
    return seconds;
}

/* What of a step no other timer has: its length, guards, walls that move, and what lies between passes. */
static void clock_rest(MnsSim *sim, double start, double before)
{
    sim->timers[TIMER_REST].seconds += omp_get_wtime() - start - (timed(sim) - before);
    sim->timers[TIMER_REST].calls++;
}

MnsStatus mns_sim_step(MnsSim *sim, double t_max, MnsError *error)
{
    const double start = omp_get_wtime(), before = timed(sim);
    MnsError why = {0};
    MnsProgress *progress = &sim->progress;
    if (sim->fault.status) {
        if (error) *error = sim->fault;
        return sim->fault.status;
    }
    if (!(t_max > progress->t))
        return mns_fail(error, MNS_E_INVALID, "the step must end after t = %g s; found %g s", progress->t, t_max);
    const Limit *limit = NULL;
    double dt = limits_dt(sim, &limit);
    if (!(dt >= plan_floor(sim)) || !(dt > 0))
        return sim_remember(sim, fault_time_step(sim, dt, limit, &why), &why, error);
    const double whole = dt, t = cut(progress->t, &dt, t_max);
    /* Before anything of the step is done: the state stays whole, and the run can go on with another formula. */
    MnsStatus status = setup_check(sim, t, dt, error);
    if (status) return status;
    if (progress->dt_first == 0) progress->dt_first = whole;
    sim->whole = whole;
    status = integrator_step(sim, t, dt, &why);
    progress->t = t;
    progress->dt = dt;
    progress->step++;
    if (!status) {
        energy_step(sim);
        losses_step(sim);
    }
    clock_rest(sim, start, before);
    return status ? sim_remember(sim, status, &why, error) : MNS_OK;
}

const MnsCase *mns_sim_case(const MnsSim *sim)
{
    return sim->c;
}

uint64_t mns_sim_uncorrected(const MnsSim *sim)
{
    return sim->uncorrected;
}

MnsProgress mns_sim_progress(const MnsSim *sim)
{
    return sim->progress;
}

int mns_sim_threads(const MnsSim *sim)
{
    return sim->threads;
}

size_t mns_sim_particles(const MnsSim *sim)
{
    return sim->s.n;
}

size_t mns_sim_fluid_particles(const MnsSim *sim)
{
    return particles_fluid(&sim->s);
}

double mns_sim_spacing(const MnsSim *sim)
{
    return sim->model.dx;
}

double mns_sim_mean_neighbours(const MnsSim *sim)
{
    const Particles *s = &sim->s;
    const size_t n = particles_fluid(s);
    const double reach = sim->model.kernel.support;
    uint64_t pairs = 0;
#pragma omp parallel for schedule(static) reduction(+ : pairs) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++) {
        const uint32_t *j = neighbours_of(&sim->nb, i);
        for (size_t k = 0; k < sim->nb.end[i][END_WALLS]; k++) {
            double r2 = 0;
            for (int d = 0; d < s->dim; d++) {
                const double x = model_nearest(&sim->model, d, s->x[d][i * s->x_step] - s->x[d][j[k] * s->x_step]);
                r2 += x * x;
            }
            pairs += r2 < reach * reach;
        }
        if (sim->nb.has[i] & LIST_MIRRORS)
            pairs += mirrors_count(&sim->model, s, i, j, sim->nb.end[i][END_WALLS], reach, SIZE_MAX, MIRRORED_NOW);
    }
    return (double)pairs / (double)n;
}

size_t mns_sim_bytes(const MnsSim *sim)
{
    return particles_bytes(&sim->s) + neighbours_bytes(&sim->nb) + belts_bytes(sim->belts.n) +
           (sim->scheme->projects ? system_bytes(&sim->system) : 0);
}

const void *mns_sim_field(const MnsSim *sim, int field, int d)
{
    return shown_field(sim, field, d);
}

uint64_t mns_sim_fields(const MnsSim *sim)
{
    return shown_fields(sim);
}

const MnsTimer *mns_sim_timers(const MnsSim *sim, size_t *ret_n)
{
    *ret_n = sim->n_timers;
    return sim->timers;
}
