/* SPDX-License-Identifier: BSD-3-Clause */
/* A step of an incompressible flow with one projection, where the particles are at its beginning.               P5 eq. 20-25
 *   u* = u + dt a,   solve for the pressure,   u' = u* - dt grad p / rho
 * The step before leaves the divergence of u. In a step cut short from dt_0 to dt, u* = dt/dt_0 u + dt a, and the rest of u is added to u' afterwards: to
 * remove all of it in less time would raise the pressure by up to dt_0/dt.
 *   x += dt/2 (u + u'),   particles are shifted to where there are fewer
 *   a = forces but pressure, at the new positions and velocities */
#include "sim/integrator.h"
#include "sim/integrators/integrators.h"
#include "sim/integrators/pressure.h"
#include "sim/terms/terms.h"
#include <math.h>
#include <omp.h>
#include <string.h>

/* Velocities of before are kept where accelerations were, which nobody asks for until there are new ones. */
static void push(MnsSim *sim, double dt)
{
    Particles *s = &sim->s;
    const size_t n = particles_fluid(s), step = s->v_step;
    for (int d = 0; d < s->dim; d++) {
        double *restrict v = s->v[d], *restrict a = s->a[d];
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
        for (size_t i = 0; i < n; i++) {
            const double before = v[i * step];
            v[i * step] += dt * a[i];
            a[i] = before;
        }
    }
    particles_changed(s, ON_FLUID, FIELD(V) | FIELD(A));
}

/* Add part times the velocities before the step: below 0 to keep them out of the projection, above 0 to bring them back. */
static void add_before(MnsSim *sim, double part)
{
    Particles *s = &sim->s;
    const size_t n = particles_fluid(s), step = s->v_step;
    if (part == 0) return;
    for (int d = 0; d < s->dim; d++) {
        double *restrict v = s->v[d];
        const double *restrict before = s->a[d];
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
        for (size_t i = 0; i < n; i++) v[i * step] += part * before[i];
    }
    particles_changed(s, ON_FLUID, FIELD(V));
}

/* Of a step that failed before there were new accelerations: what is shown are those of before once more. */
static void show_accelerations(MnsSim *sim, double dt)
{
    Particles *s = &sim->s;
    for (int d = 0; d < s->dim; d++)
        for (size_t i = 0; i < particles_fluid(s); i++) s->a[d][i] = (s->v[d][i * s->v_step] - s->a[d][i]) / dt;
}

/* And in the places of differences and of the colour's gradient are changes of positions and velocities, which are none of those: 0. */
static void show_no_differences(MnsSim *sim)
{
    Particles *s = &sim->s;
    for (int d = 0; d < s->dim; d++)
        for (size_t i = 0; i < particles_fluid(s); i++) s->correction[d][i] = s->colour_gradient[d][i] = 0;
}

static void drift(MnsSim *sim, double dt)
{
    Particles *s = &sim->s;
    const size_t n = particles_fluid(s), step = s->x_step, v_step = s->v_step;
    for (int d = 0; d < s->dim; d++) {
        double *restrict x = s->x[d];
        const double *restrict v = s->v[d], *restrict v0 = s->a[d];
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
        for (size_t i = 0; i < n; i++) x[i * step] += 0.5 * dt * (v0[i] + v[i * v_step]);
    }
    particles_changed(s, ON_FLUID, FIELD(X));
}

/* A particle, and how far it is from a point. */
typedef struct Candidate {
    double r2;
    size_t i;
} Candidate;

/* Of several as near, the one of the least id, as storage order changes. */
static bool is_nearer(const Particles *s, Candidate a, Candidate b)
{
    return a.r2 < b.r2 || (a.r2 == b.r2 && s->id[a.i] < s->id[b.i]);
}

/* When the lists were made, which a restart knows: it is the same one until they are made again. */
static size_t nearest(const MnsSim *sim, const double at[3])
{
    const Particles *s = &sim->s;
    Candidate best = {INFINITY, 0};
#pragma omp parallel num_threads(sim->threads)
    {
        Candidate mine = {INFINITY, 0};
#pragma omp for schedule(static) nowait
        for (size_t i = 0; i < particles_fluid(s); i++) {
            Candidate one = {0, i};
            for (int d = 0; d < s->dim; d++) {
                const double x = model_nearest(&sim->model, d, s->ref[d][i] - at[d]);
                one.r2 += x * x;
            }
            if (is_nearer(s, one, mine)) mine = one;
        }
#pragma omp critical(nearest_particle)
        if (is_nearer(s, mine, best)) best = mine;
    }
    return best.i;
}

static MnsStatus solve(MnsSim *sim, MnsError *error)
{
    const PressureGoal goal = {"velocity", "tolerance", sim->model.projection.tolerance};
    SolveReport report;
    /* Of divergences, a millionth of the speed over h at each particle: on a lattice there may be none but rounding. */
    sim->system.least = 1e-6 * sim->v_max / sim->model.kernel.h * sqrt((double)particles_fluid(&sim->s));
    const MnsStatus status = pressure_solve(sim, &goal, &report, error);
    sim->solved = (Solved){.iterations = report.iterations, .residual = report.residual};
    return status;
}

/* Neighbours, but no diagonal to divide by. */
static bool is_silent(const MnsSim *sim, size_t i)
{
    return sim->system.matrix.blocks[i] == 0 && sim->nb.end[i][END_WALLS] > 0;
}

/* Of a particle whose neighbours lie so that its row has no diagonal to divide by, the pressure would stay what it was, and the fluid around
 * would take it as given. Of several it is the one with the smallest id. */
static MnsStatus check_rows(const MnsSim *sim, MnsError *error)
{
    const Particles *s = &sim->s;
    const size_t n = particles_fluid(s);
    size_t silent = 0, worst = n;
#pragma omp parallel for schedule(static) reduction(+ : silent) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++) silent += is_silent(sim, i);
    if (silent == 0) return MNS_OK;
    for (size_t i = 0; i < n; i++)
        if (is_silent(sim, i) && (worst == n || s->id[i] < s->id[worst])) worst = i;
    return mns_fail(
        error, MNS_E_DIVERGED,
        "diverged in step %llu at t = %g s: the neighbours of %zu particles lie too much to one side for the "
        "pressure to be solved for there, as of particle %u of %s at (%g, %g, %g) m. Look at the snapshot, "
        "then try a smaller scheme.cfl, a larger scheme.%s.shifting_strength or a larger scheme.smoothing",
        (unsigned long long)sim->progress.step + 1, sim->model.t, silent, s->id[worst],
        sim->c->fluids[s->phase[worst]].name, s->x[0][worst * s->x_step], s->x[1][worst * s->x_step],
        s->dim == 3 ? s->x[2][worst * s->x_step] : 0, sim->scheme->name);
}

static MnsStatus correct(MnsSim *sim, double dt, MnsError *error)
{
    const Differences *options = &sim->model.differences;
    System *y = &sim->system;
    y->zero = options->holds ? nearest(sim, options->zero) : NO_ROW;
    MnsStatus status = pressure_lay(sim, error);
    if (status) return status;
    pressure_prepare(sim, (const int[]){PASS_SHAPE, PASS_CONTINUED, PASS_SYSTEM}, 3);
    integrator_pass(sim, PASS_CONTINUED);
    integrator_pass(sim, PASS_SYSTEM);
    status = check_rows(sim, error);
    if (status) return status;
    pressure_guess(sim, dt);
    status = solve(sim, error);
    if (status) return status; /* what was not found corrects nothing */
    system_centre(y);
    integrator_pass(sim, PASS_CORRECTION);
    pressure_keep(sim, dt, 1);
    return MNS_OK;
}

static MnsStatus project(MnsSim *sim, double dt, MnsError *error)
{
    const double share = pressure_share(sim, dt);
    sim->model.differences.share = share;
    add_before(sim, share - 1);
    const MnsStatus status = correct(sim, dt, error);
    add_before(sim, 1 - share);
    return status;
}

/* To where the rates are found. */
static MnsStatus move(MnsSim *sim, double t, double dt, bool *ret_well, MnsError *error)
{
    const double start = omp_get_wtime();
    drift(sim, dt);
    *ret_well = integrator_look(sim);
    sim->progress.guarded += integrator_walls(sim, t, dt, 0);
    integrator_clock(sim, TIMER_DRIFT, start);
    MnsStatus status = integrator_lists(sim, error);
    if (!status) {
        integrator_pass(sim, PASS_SPACING);
        status = integrator_lists(sim, error);
    }
    if (status) show_no_differences(sim);
    return status;
}

static MnsStatus step(MnsSim *sim, double t, double dt, MnsError *error)
{
    bool well = true;
    sim->model.dt = dt;
    integrator_gravity(sim, t, dt);
    push(sim, dt);
    MnsStatus status = project(sim, dt, error);
    if (!status) status = move(sim, t, dt, &well, error);
    if (status) {
        show_accelerations(sim, dt);
        return status;
    }
    integrator_rates(sim, PASS_SHAPE);
    well = integrator_look(sim) && well;
    return well ? MNS_OK : fault_particle(sim, error);
}

const Integrator single_projection = {
    .name = "one projection",
    .source = "P5 eq. 20-25",
    .equation = "u' = u + dt a - dt grad p/rho;  x += dt/2 (u + u');  shift;  rates",
    .step = step,
};
