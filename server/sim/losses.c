/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/losses.h"
#include "sim/mirror_planes.h"
#include "sim/probes/probes.h"
#include "sim/sides.h"
#include "sim/solid.h"
#include <math.h>

/* Steps it is looked at, at the end and after 64, 128 and 256: the coverage takes as long as one. */
enum { EVERY = 300 };

static const double LEAST_COVERED = 0.3; /* sum of W V; of a domain that fluids fill */
static const double MOST_ESCAPED = 0.01; /* of all fluid particles */

/* Outside of the domain, or so deep in a wall that it went through its surface? */
static double is_lost(const Measure *m, size_t i)
{
    const Particles *s = &m->sim->s;
    double x[3] = {0, 0, 0};
    for (int d = 0; d < s->dim; d++) {
        x[d] = s->x[d][i * s->x_step];
        if (!(x[d] >= m->probe->min[d] && x[d] <= m->probe->max[d])) return 1;
    }
    return solid_distance_now(m->sim, x) < -m->sim->model.dx;
}

void losses_step(MnsSim *sim)
{
    MnsProbe domain = {.fluid = -1};
    const uint64_t step = sim->progress.step;
    const bool doubled = step >= 64 && step < EVERY && !(step & (step - 1));
    if (step % EVERY && !doubled && !(sim->progress.t >= sim->c->end_time)) return;
    mirror_planes_look(sim);
    domain.wall = sides_now(sim, domain.min, domain.max);
    Measure m = {.sim = sim, .probe = &domain, .threads = sim->threads};
    const double escaped = measure_sum(&m, is_lost), n = (double)particles_fluid(&sim->s);
    sim->losses.escaped_share = fmax(sim->losses.escaped_share, escaped / n);
    if (escaped > MOST_ESCAPED * n && !sim->told.escaped) {
        sim->told.escaped = true;
        plan_tell(
            sim,
            "domain: after step %llu %.0f of %.0f fluid particles are outside of it or deep in walls. Close its sides "
            "by walls, widen it, or take smaller steps",
            (unsigned long long)sim->progress.step, escaped, n);
    }
    if (!sim->model.filled) return;
    domain.within = true;
    for (int d = 0; d < sim->model.dim; d++) {
        domain.min[d] -= measure_shift(&m, d);
        domain.max[d] -= measure_shift(&m, d);
    }
    const double covered = probe_coverage(&m);
    sim->losses.least_coverage = fmin(sim->losses.least_coverage, covered); /* of a number and NAN the number */
    if (!(covered < LEAST_COVERED) || sim->told.bare) return;
    sim->told.bare = true;
    plan_tell(sim,
              "coverage: after step %llu a place has only %.2g of the fluid that would fill it, allowed: %g: particles "
              "have left a void. Shifting, a higher background pressure or a finer resolution may close it",
              (unsigned long long)sim->progress.step, covered, LEAST_COVERED);
}

MnsLosses mns_sim_losses(const MnsSim *sim)
{
    return sim->losses;
}
