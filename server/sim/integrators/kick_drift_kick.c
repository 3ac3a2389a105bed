/* SPDX-License-Identifier: BSD-3-Clause */
/* One evaluation of the rates a step.                                                       P3 eq. 15-18, schemes/riemann.md
 *   v += dt/2 a;  w = dt/2 b;  x += dt (v + w);  densities, pressures, walls, forces at the new positions;  v += dt/2 a */
#include "sim/integrator.h"
#include "sim/integrators/integrators.h"
#include <math.h>
#include <omp.h>

enum { CHUNK = 256 }; /* particles whose bundles stay in the first cache from one component to the next */

/* Component d of particles [first, last). */
static void kick_component(const Particles *s, int d, double dt, size_t first, size_t last)
{
    const size_t x_step = s->x_step, v_step = s->v_step;
    double *restrict x = s->x[d], *restrict v = s->v[d];
    const double *restrict a = s->a[d], *restrict b = s->b[d], half = 0.5 * dt;
    if (!b) { /* no transport velocity in this scheme */
        for (size_t i = first; i < last; i++) {
            const double now = v[i * v_step] + half * a[i];
            v[i * v_step] = now;
            x[i * x_step] += dt * now;
        }
        return;
    }
    for (size_t i = first; i < last; i++) {
        const double now = v[i * v_step] + half * a[i];
        v[i * v_step] = now;
        x[i * x_step] += dt * (now + half * b[i]);
    }
}

/* Half a kick and the drift of the fluid. */
static void kick_and_drift(MnsSim *sim, double dt)
{
    Particles *s = &sim->s;
    const size_t n = particles_fluid(s);
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t first = 0; first < n; first += CHUNK)
        for (int d = 0; d < s->dim; d++) kick_component(s, d, dt, first, first + CHUNK < n ? first + CHUNK : n);
    particles_changed(s, ON_FLUID, FIELD(X) | FIELD(V));
}

/* The second half of the kick, and the two questions about its result: how fast, and is all well? */
static bool kick_and_look(MnsSim *sim, double dt)
{
    Particles *s = &sim->s;
    const Model *model = &sim->model;
    const size_t n = particles_fluid(s), step = s->v_step;
    double *const v[3] = {s->v[0], s->v[1], s->v[2]};
    const double *const a[3] = {s->a[0], s->a[1], s->a[2]}, half = 0.5 * dt;
    double fastest = 0;
    size_t bad = 0;
#pragma omp parallel for schedule(static) reduction(max : fastest) reduction(+ : bad) num_threads(sim->threads)
    for (size_t i = 0; i < n; i++) {
        double v2 = 0;
        for (int d = 0; d < s->dim; d++) {
            const double now = v[d][i * step] + half * a[d][i];
            v[d][i * step] = now;
            v2 += now * now;
        }
        bad += !sim_is_well(s, model, i, v2);
        fastest = v2 > fastest ? v2 : fastest;
    }
    particles_changed(s, ON_FLUID, FIELD(V));
    sim->v_max = sqrt(fastest);
    return bad == 0;
}

static MnsStatus step(MnsSim *sim, double t, double dt, MnsError *error)
{
    const double start = omp_get_wtime();
    integrator_gravity(sim, t, dt);
    kick_and_drift(sim, dt);
    sim->progress.guarded += integrator_walls(sim, t, dt, 0);
    integrator_clock(sim, TIMER_DRIFT, start);

    const MnsStatus status = integrator_lists(sim, error);
    if (status) return status;
    integrator_rates(sim, 0);

    const double last = omp_get_wtime();
    const bool well = kick_and_look(sim, dt);
    integrator_clock(sim, TIMER_KICK, last);
    return well ? MNS_OK : fault_particle(sim, error);
}

const Integrator kick_drift_kick = {
    .name = "kick, drift, kick",
    .source = "P3 eq. 15-18",
    .equation = "v += dt/2 a;  x += dt (v + dt/2 b);  rates;  v += dt/2 a",
    .step = step,
    .staggered = true,
};
