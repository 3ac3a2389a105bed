/* SPDX-License-Identifier: BSD-3-Clause */
/* What a run is going to take, by the length of its steps: what would never end, or fill any disk, is refused before it
 * begins, and what is allowed but hardly meant is said. */
#include "sim/limits.h"
#include "sim/probes/probes.h"
#include <math.h>
#include <omp.h>
#include <stdarg.h>
#include <stdio.h>

static const double STEPS_MAX = 1e9; /* weeks, for the smallest of cases */
static const double FILES_MAX = 1e6;
static const double STEPS_SLOWED = 1e11; /* a run may slow down so much on its way, and no more */

double plan_floor(const MnsSim *sim)
{
    const double end = sim->c->end_time;
    return fmax(sim->model.dt_floor * sim->progress.dt_first, isfinite(end) ? end / STEPS_SLOWED : 0);
}

/* One output for each interval, but not more than one for each step. */
static double outputs(double interval, double time, double dt)
{
    return interval > 0 ? time / fmax(interval, dt) : 0;
}

MnsStatus plan_check(const MnsSim *sim, const MnsCase *c, MnsError *error)
{
    const Limit *limit = NULL;
    const double dt = limits_dt(sim, &limit), left = c->end_time - sim->progress.t;
    if (!isfinite(left)) return MNS_OK; /* of a C program, which knows when to stop */
    if (left > 0 && !(left / dt <= STEPS_MAX))
        return mns_fail_at(error, MNS_E_LIMIT, "end_time",
                           "%g s more would take %.1e steps of %.1e s, allowed: %.0e; what limits the step is %s, "
                           "%s. End earlier, or change %s",
                           left, left / dt, dt, STEPS_MAX, limit->name, limit->source, limit->entries);
    const double files = outputs(c->output.snapshot_interval, left, dt);
    if (files > FILES_MAX)
        return mns_fail_at(
            error, MNS_E_LIMIT, "output.snapshot_interval",
            "one every %g s would make %.1e files in %g s, allowed: %.0e, which is an interval of %.2g s",
            c->output.snapshot_interval, files, left, FILES_MAX, left / FILES_MAX);
    return MNS_OK;
}

static void warn(MnsSim *sim, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void warn(MnsSim *sim, const char *format, ...)
{
    if (sim->n_warnings == SIM_WARNINGS_MAX) return;
    va_list list;
    va_start(list, format);
    vsnprintf(sim->warning[sim->n_warnings++], sizeof *sim->warning, format, list);
    va_end(list);
}

static void warn_interval(MnsSim *sim, const char *entry, double interval, double dt)
{
    if (interval > 0 && interval < dt)
        warn(sim, "%s: %g s is shorter than the first time step, %.2g s: it means after every step", entry, interval,
             dt);
}

/* Is particle i beside the domain's lower (-1) or upper (1) side along d, with no wall behind that side? */
static bool is_exposed(const MnsSim *sim, size_t i, int d, int side)
{
    const Model *model = &sim->model;
    double x[3] = {0, 0, 0};
    for (int e = 0; e < model->dim; e++) x[e] = sim->s.x[e][i];
    x[d] += side * model->cell[d];
    if (x[d] >= model->min[d] && x[d] <= model->max[d]) return false;
    for (size_t k = 0; k < model->n_walls; k++)
        if (shape_distance(&sim->solid[k], x) < 0) return false;
    return true;
}

/* Nothing holds a fluid back at a side that is neither a wall nor periodic. It may be meant to fall. */
static void warn_open_sides(MnsSim *sim)
{
    for (int d = 0; d < sim->model.dim; d++)
        for (int side = -1; side <= 1 && sim->model.period[d] == 0; side += 2)
            for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
                if (!is_exposed(sim, i, d, side)) continue;
                warn(sim,
                     "domain: %s touches the %s %c side, which is neither a wall nor periodic: what leaves there is "
                     "lost, as a probe of kind `escaped` would show; put a wall there, or make %c periodic",
                     sim->c->fluids[sim->s.phase[i]].name, side < 0 ? "lower" : "upper", "xyz"[d], "xyz"[d]);
                break;
            }
}

/* A probe at a place that no fluid can be near has no value, ever. One that moves with a wall may come in. */
static void warn_probes_outside(MnsSim *sim)
{
    const Model *model = &sim->model;
    for (size_t k = 0; k < sim->c->n_probes; k++) {
        const MnsProbe *probe = &sim->c->probes[k];
        const unsigned uses = probe_kind(probe)->uses;
        const bool placed = uses & (PROBE_AT_POINT | PROBE_ON_LINE);
        const double reach = probe->radius > 0 ? probe->radius : model->kernel.support;
        for (int d = 0; placed && probe->wall < 0 && d < model->dim; d++) {
            if (model->period[d] > 0 || (uses & PROBE_ON_LINE && d == probe->axis)) continue;
            if (probe->at[d] >= model->min[d] - reach && probe->at[d] <= model->max[d] + reach) continue;
            warn(sim,
                 "probes[%zu]: %.60s is at %c = %g m, outside the domain, %g to %g m: where no fluid comes it has no "
                 "value",
                 k, probe->name, "xyz"[d], probe -> at[d], model -> min[d], model -> max[d]);
            break;
        }
    }
}

void plan_look(MnsSim *sim)
{
    warn_open_sides(sim);
    warn_probes_outside(sim);

    const MnsOutput *output = &sim->c->output;
    const double dt = limits_dt(sim, NULL);
    if (sim->c->n_probes) warn_interval(sim, "output.probe_interval", output->probe_interval, dt);
    warn_interval(sim, "output.snapshot_interval", output->snapshot_interval, dt);
    warn_interval(sim, "output.checkpoint_interval", output->checkpoint_interval, dt);
    const unsigned processors = (unsigned)omp_get_num_procs();
    if (sim->c->threads > processors)
        warn(sim,
             "threads: %u on %u processors only wait for each other; %d are used, and the results are the same for "
             "any number",
             sim->c->threads, processors, sim->threads);
}

const char *mns_sim_warning(const MnsSim *sim, size_t k)
{
    return k < sim->n_warnings ? sim->warning[k] : NULL;
}
