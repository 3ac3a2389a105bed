/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/losses.h"
#include "sim/motion.h"
#include "sim/probes/probes.h"

enum { EVERY = 300 }; /* steps it is looked at, and at the end: the coverage takes as long as one */

static const double LEAST_COVERED = 0.3; /* sum of W V; of a domain that fluids fill */
static const double MOST_ESCAPED = 0.01; /* of all fluid particles */

void losses_step(MnsSim *sim)
{
    /* A tank takes the domain along. */
    const MnsProbe all = {.fluid = -1, .wall = sim->model.n_walls > 0 && motion_of_all(sim->c) ? 0 : -1};
    Measure m = {.sim = sim, .probe = &all, .threads = sim->threads};
    if (sim->progress.step % EVERY && !(sim->progress.t >= sim->c->end_time)) return;
    const double escaped = sim->told.escaped ? 0 : probe_escaped(&m), n = (double)particles_fluid(&sim->s);
    if (escaped > MOST_ESCAPED * n) {
        sim->told.escaped = true;
        plan_tell(sim,
                  "domain: after step %llu %.0f of %.0f fluid particles are outside of it. Close its sides by walls, "
                  "or widen it",
                  (unsigned long long)sim->progress.step, escaped, n);
    }
    if (!sim->model.filled || sim->told.bare) return;
    const double covered = probe_coverage(&m);
    if (!(covered < LEAST_COVERED)) return;
    sim->told.bare = true;
    plan_tell(sim,
              "coverage: after step %llu a place has only %.2g of the fluid that would fill it, allowed: %g: particles "
              "have left a void. Shifting, a higher background pressure or a finer resolution may close it",
              (unsigned long long)sim->progress.step, covered, LEAST_COVERED);
}
