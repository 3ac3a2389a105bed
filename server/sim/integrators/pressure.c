/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/integrators/pressure.h"
#include "sim/mirrors.h"
#include "sim/terms/matrix_row.h"
#include <math.h>
#include <omp.h>

static void book(MnsSim *sim, double start, double setup_before)
{
    const double setup = sim->system.setup_seconds - setup_before;
    integrator_clock(sim, sim->timer_solve, start);
    sim->timers[sim->timer_solve].seconds -= setup;
    sim->timers[sim->timer_setup].seconds += setup;
    sim->timers[sim->timer_setup].calls += setup > 0;
}

/* More iterations make no number of what is none. */
static MnsStatus fail_numbers(const MnsSim *sim, const char *what, MnsError *error)
{
    return mns_fail(
        error, MNS_E_DIVERGED,
        "diverged in step %llu at t = %g s: in the pressure that corrects the %s something is no number, as a "
        "velocity or a pressure was none or the system has no solution. Look at the snapshot, then take "
        "smaller steps by a smaller scheme.cfl or a higher scheme.%s.reference_speed",
        (unsigned long long)sim->progress.step + 1, sim->model.t, what, sim->scheme->name);
}

static MnsStatus fail_method(const MnsSim *sim, const SolveMethod *method, MnsStatus status, MnsError *error)
{
    const char *other = sim->scheme->symmetric ? "cg" : "bicgstab";
    if (status == MNS_E_MEMORY)
        return mns_fail(error, status,
                        "no memory for what %s keeps of the pressure system of %zu rows: write scheme.%s.solver: "
                        "%s, or lower the resolution",
                        method->name, sim->system.matrix.n, sim->scheme->name, other);
    return mns_fail(error, status, "%s failed on the pressure system of %zu rows: write scheme.%s.solver: %s",
                    method->name, sim->system.matrix.n, sim->scheme->name, other);
}

static MnsStatus fail_solve(const MnsSim *sim, const SolveMethod *method, const SolveReport *report,
                            const PressureGoal *goal, MnsError *error)
{
    char history[512];
    if (!isfinite(report->residual)) return fail_numbers(sim, goal->corrects, error);
    solve_history(report, history, sizeof history);
    return mns_fail(error, MNS_E_DIVERGED,
                    "diverged in step %llu at t = %g s: the pressure that corrects the %s was not found by %s in %u "
                    "iterations to a residual of %g; residuals: %s. Look at the snapshot, then allow more "
                    "scheme.%s.iterations or a larger scheme.%s.%s, or take smaller steps",
                    (unsigned long long)sim->progress.step + 1, sim->model.t, goal->corrects, method->name,
                    report->iterations, goal->tolerance, history, sim->scheme->name, sim->scheme->name, goal->entry);
}

MnsStatus pressure_lay(MnsSim *sim, MnsError *error)
{
    sim->system.threads = sim->threads;
    if (matrix_rows_lay(&sim->s, &sim->nb)) return MNS_OK;
    return mns_fail(error, MNS_E_MEMORY, "no memory for the pressure system of %zu particles", sim->s.n);
}

static const SolveMethod *method_of(const MnsSim *sim)
{
    return solve_method(sim->model.projection.solver, &sim->system, sim->scheme->symmetric);
}

MnsStatus pressure_solve(MnsSim *sim, const PressureGoal *goal, SolveReport *ret_report, MnsError *error)
{
    const SolveMethod *method = method_of(sim);
    const double start = omp_get_wtime(), before = sim->system.setup_seconds;
    const SolveGoal within = {goal->tolerance, sim->model.projection.iterations};
    method->solve(&sim->system, &within, ret_report);
    sim->solver = method->name;
    book(sim, start, before);
    if (ret_report->status) return fail_method(sim, method, ret_report->status, error);
    return ret_report->converged ? MNS_OK : fail_solve(sim, method, ret_report, goal, error);
}

/* Where particles are, and where they were when the lists were made. */
static void exchange_positions(Particles *s, int threads)
{
    const size_t step = s->x_step;
    for (int d = 0; d < s->dim; d++) {
        double *restrict x = s->x[d], *restrict ref = s->ref[d];
#pragma omp parallel for simd schedule(static) num_threads(threads)
        for (size_t i = 0; i < s->n; i++) {
            const double now = x[i * step];
            x[i * step] = ref[i];
            ref[i] = now;
        }
    }
    particles_changed(s, ON_ALL, FIELD(X) | FIELD(REF));
}

static void prepare(MnsSim *sim, const SolveMethod *method)
{
    const double start = omp_get_wtime(), before = sim->system.setup_seconds;
    method->prepare(&sim->system);
    book(sim, start, before);
}

void pressure_prepare(MnsSim *sim, const int passes[], size_t n)
{
    const SolveMethod *method = method_of(sim);
    if (!method->prepare || system_is_ready(&sim->system)) return;
    exchange_positions(&sim->s, sim->threads);
    for (size_t k = 0; k < n; k++) integrator_pass(sim, passes[k]);
    prepare(sim, method);
    exchange_positions(&sim->s, sim->threads);
    integrator_pass(sim, passes[0]);
}

void pressure_guess(MnsSim *sim, double dt)
{
    System *y = &sim->system;
    const size_t n = particles_fluid(&sim->s);
    const size_t step = sim->s.p_step;
    const double *restrict p = sim->s.p;
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++) y->x[i] = p[i * step] * dt;
    system_relax(y, n);
}

double pressure_share(const MnsSim *sim, double dt)
{
    return dt < sim->whole ? dt / sim->whole : 1;
}

void pressure_keep(MnsSim *sim, double dt, double share)
{
    const double *restrict P = sim->system.x;
    const uint32_t *restrict blocks = sim->system.matrix.blocks;
    const size_t step = sim->s.p_step;
    double *restrict p = sim->s.p;
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < sim->s.n; i++) {
        const bool known = blocks[i] || mirrors_hide(&sim->model, &sim->s, i);
        p[i * step] += share * ((known ? P[i] / dt : 0) - p[i * step]);
    }
    particles_changed(&sim->s, ON_ALL, FIELD(P));
}
