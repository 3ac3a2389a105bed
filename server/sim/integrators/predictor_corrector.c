/* SPDX-License-Identifier: BSD-3-Clause */
/* Two evaluations of the rates a step, at its middle and at its end.                                        P1 eq. 20-22
 *   predictor  x += dt/2 v;  v += dt/2 a;  rho += dt/2 d rho/dt;  rates at the middle
 *   corrector  v = v0 + dt a;  x = x0 + dt (v0 + v)/2;  rho = rho0 + dt d rho/dt;  rates at the end
 * The corrector goes from the beginning to the end at once, which is what P1's two halves come to. Rates at the end are for the next predictor
 * alone, and so need one order less: curvatures there are those of the middle. */
#include "sim/integrator.h"
#include "sim/integrators/integrators.h"
#include <math.h>
#include <omp.h>

static void predict(MnsSim *sim, double dt)
{
    Particles *s = &sim->s;
    const size_t n = particles_fluid(s);
    const double half = 0.5 * dt;
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++)
        for (int d = 0; d < s->dim; d++) {
            double *x = &s->x[d][i * s->x_step], *v = &s->v[d][i * s->v_step];
            s->x0[d][i] = *x;
            s->v0[d][i] = *v;
            *x += half * *v;
            *v += half * s->a[d][i];
        }
    double *restrict rho = s->rho, *restrict rho0 = s->rho0;
    const double *restrict rate = s->rate;
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++) {
        rho0[i] = rho[i];
        rho[i] += half * rate[i];
    }
    particles_changed(s, ON_FLUID, FIELD(X) | FIELD(V) | FIELD(RHO) | FIELD(X0) | FIELD(V0) | FIELD(RHO0));
}

static void correct(MnsSim *sim, double dt)
{
    Particles *s = &sim->s;
    const size_t n = particles_fluid(s);
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++)
        for (int d = 0; d < s->dim; d++) {
            const double v0 = s->v0[d][i], v = v0 + dt * s->a[d][i];
            s->v[d][i * s->v_step] = v;
            s->x[d][i * s->x_step] = s->x0[d][i] + 0.5 * dt * (v0 + v);
        }
    double *restrict rho = s->rho;
    const double *restrict rate = s->rate, *restrict rho0 = s->rho0;
#pragma omp parallel for simd schedule(static) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++) rho[i] = rho0[i] + dt * rate[i];
    particles_changed(s, ON_FLUID, FIELD(X) | FIELD(V) | FIELD(RHO));
}

static MnsStatus step(MnsSim *sim, double t, double dt, MnsError *error)
{
    double start = omp_get_wtime();
    integrator_gravity(sim, t, dt);
    predict(sim, dt);
    integrator_walls(sim, t - 0.5 * dt, 0.5 * dt, 0.5 * dt); /* all of the step is done with these rates */
    integrator_clock(sim, TIMER_DRIFT, start);
    MnsStatus status = integrator_lists(sim, error);
    if (status) return status;
    integrator_rates(sim, sim->scheme->given);

    start = omp_get_wtime();
    correct(sim, dt);
    sim->progress.guarded += integrator_walls(sim, t, dt, 0);
    integrator_clock(sim, TIMER_KICK, start);
    status = integrator_lists(sim, error);
    if (status) return status;
    if (sim->scheme->given > 0 &&
        sim->model.shifting > 0) { /* once a step, and before the rates that it goes on with */
        for (int k = 0; k < sim->scheme->given; k++) integrator_pass(sim, k);
        status = integrator_lists(sim, error);
        if (status) return status;
    }
    const bool well = integrator_look(sim);
    integrator_end_rates(sim, sim->scheme->given);
    return well ? MNS_OK : fault_particle(sim, error);
}

const Integrator predictor_corrector = {
    .name = "predictor, corrector",
    .source = "P1 eq. 20-22",
    .equation = "rates at the middle of the step, from which all of it is done, and at its end",
    .step = step,
    .works = FIELD(X0) | FIELD(V0) | FIELD(RHO0),
    .halfway = true,
};
