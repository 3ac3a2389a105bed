/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/losses.h"
#include "sim/motion.h"
#include "sim/probes/probes.h"
#include <math.h>

enum { EVERY = 300 }; /* steps it is looked at, and at the end: the coverage takes as long as one */

static const double LEAST_COVERED = 0.3; /* sum of W V; of a domain that fluids fill */
static const double MOST_ESCAPED = 0.01; /* of all fluid particles */

/* Does a wall take the domain along, as a tank does? A plate that carries fluid out does not. */
static bool is_tank(const MnsSim *sim, int wall)
{
    const MnsShape *shape = &sim->c->walls[wall].shape;
    return motion_of_all(sim->c) || (shape->n > 0 && shape->parts[0].outside);
}

/* The domain at rest, or taken along by a tank: where fewest have escaped. */
static double fewest_escaped(const MnsSim *sim, MnsProbe *ret_frame)
{
    double fewest = INFINITY;
    const int n = (int)sim->model.n_walls;
    for (int k = 0; k <= n && fewest > 0; k++) {
        const MnsProbe frame = {.fluid = -1, .wall = k < n ? k : -1};
        if (k < n && !is_tank(sim, k)) continue;
        Measure m = {.sim = sim, .probe = &frame, .threads = sim->threads};
        const double escaped = probe_escaped(&m);
        if (escaped < fewest) *ret_frame = frame;
        fewest = fmin(fewest, escaped);
    }
    return fewest;
}

void losses_step(MnsSim *sim)
{
    MnsProbe frame = {.fluid = -1, .wall = -1};
    if (sim->progress.step % EVERY && !(sim->progress.t >= sim->c->end_time)) return;
    const double escaped = fewest_escaped(sim, &frame), n = (double)particles_fluid(&sim->s);
    if (escaped > MOST_ESCAPED * n && !sim->told.escaped) {
        sim->told.escaped = true;
        plan_tell(sim,
                  "domain: after step %llu %.0f of %.0f fluid particles are outside of it. Close its sides by walls, "
                  "or widen it",
                  (unsigned long long)sim->progress.step, escaped, n);
    }
    if (!sim->model.filled || sim->told.bare) return;
    Measure m = {.sim = sim, .probe = &frame, .threads = sim->threads};
    const double covered = probe_coverage(&m);
    if (!(covered < LEAST_COVERED)) return;
    sim->told.bare = true;
    plan_tell(sim,
              "coverage: after step %llu a place has only %.2g of the fluid that would fill it, allowed: %g: particles "
              "have left a void. Shifting, a higher background pressure or a finer resolution may close it",
              (unsigned long long)sim->progress.step, covered, LEAST_COVERED);
}
