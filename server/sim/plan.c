/* SPDX-License-Identifier: BSD-3-Clause */
/* What a run is going to take, by the length of its steps: what would never end, or fill any disk, is refused before it
 * begins, and what is allowed but hardly meant is said. */
#include "sim/limits.h"
#include "sim/mirror_planes.h"
#include "sim/probes/probes.h"
#include "sim/sim.h"
#include "sim/sounds.h"
#include "sim/unlike.h"
#include <math.h>
#include <omp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

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

/* A flow without sound that is at rest, inviscid and weightless has nothing to be quick about: it would be over in one step, whatever
 * gravity or walls are going to do. */
static MnsStatus fail_boundless(const MnsCase *c, MnsError *error)
{
    char entry[64];
    snprintf(entry, sizeof entry, "scheme.%s.reference_speed", c->scheme.name);
    return mns_fail_at(error, MNS_E_INVALID, entry,
                       "nothing bounds the time step, as the fluids are at rest and have neither weight, viscosity nor "
                       "surface tension: give %s, the speed in m/s that you expect, above 0",
                       entry);
}

MnsStatus plan_check(const MnsSim *sim, const MnsCase *c, bool under_way, MnsError *error)
{
    const Limit *limit = NULL;
    const double dt = limits_dt(sim, &limit), left = c->end_time - sim->progress.t;
    const double most = under_way ? STEPS_SLOWED : STEPS_MAX;
    if (isinf(dt) && sim->s.n > 0) return fail_boundless(c, error); /* without particles speeds are not known */
    if (!isfinite(left)) return MNS_OK;                             /* of a C program, which knows when to stop */
    if (left > 0 && !(left / dt <= most))
        return mns_fail_at(error, MNS_E_LIMIT, "end_time",
                           "%g s more would take %.1e steps of %.1e s, allowed: %.0e; what limits the step is %s, "
                           "%s. End earlier, or change %s",
                           left, left / dt, dt, most, limit->name, limit->source, limit->entries);
    const double files = outputs(c->output.snapshot_interval, left, dt);
    if (files > FILES_MAX)
        return mns_fail_at(
            error, MNS_E_LIMIT, "output.snapshot_interval",
            "one every %g s would make %.1e files in %g s, allowed: %.0e, which is an interval of %.2g s",
            c->output.snapshot_interval, files, left, FILES_MAX, left / FILES_MAX);
    return MNS_OK;
}

/* What is looked at again after a change may be as it was. */
static bool is_warned(const MnsSim *sim, const char *text)
{
    for (size_t k = 0; k < sim->n_warnings; k++)
        if (strcmp(sim->warning[k], text) == 0) return true;
    return false;
}

void plan_warn(MnsSim *sim, const char *format, ...)
{
    const size_t of_case = sim->n_warnings - sim->n_told;
    if (of_case == SIM_WARNINGS_MAX) return;
    char text[sizeof *sim->warning];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    if (is_warned(sim, text)) return;
    if (of_case == SIM_WARNINGS_MAX - 1) {
        snprintf(sim->warning[sim->n_warnings++], sizeof *sim->warning,
                 "there is more to warn of than these %d: mend what they say first", SIM_WARNINGS_MAX - 1);
        return;
    }
    memcpy(sim->warning[sim->n_warnings++], text, sizeof text);
}

void plan_tell(MnsSim *sim, const char *format, ...)
{
    if (sim->n_told == SIM_TOLD_MAX) return; /* one of each kind, and as many again after a restore */
    sim->n_told++;
    va_list list;
    va_start(list, format);
    vsnprintf(sim->warning[sim->n_warnings++], sizeof *sim->warning, format, list);
    va_end(list);
}

static void warn_interval(MnsSim *sim, const char *entry, double interval, double dt)
{
    if (interval > 0 && interval < dt)
        plan_warn(sim, "%s: %g s is shorter than the first time step, %.2g s: it means after every step", entry,
                  interval, dt);
}

/* Is particle i beside the domain's lower (-1) or upper (1) side along d, with no wall behind that side? */
static bool is_exposed(const MnsSim *sim, size_t i, int d, int side)
{
    const Model *model = &sim->model;
    double x[3] = {0, 0, 0};
    for (int e = 0; e < model->dim; e++) x[e] = sim->s.x[e][i * sim->s.x_step];
    x[d] += side * model->cell[d];
    if (x[d] >= model->min[d] && x[d] <= model->max[d]) return false;
    for (size_t k = 0; k < model->n_walls; k++)
        if (shape_distance(&sim->solid[k], x) < 0) return false;
    return true;
}

/* SIZE_MAX: none is. */
static size_t first_exposed(const MnsSim *sim, int d, int side)
{
    size_t first = SIZE_MAX;
#pragma omp parallel for schedule(static) reduction(min : first) num_threads(sim->threads)
    for (size_t i = 0; i < particles_fluid(&sim->s); i++)
        if (i < first && is_exposed(sim, i, d, side)) first = i;
    return first;
}

/* Nothing holds a fluid back at a side that is neither a wall nor periodic. It may be meant to fall. */
static void warn_open_sides(MnsSim *sim)
{
    for (int d = 0; d < sim->model.dim; d++)
        for (int side = -1; side <= 1 && sim->model.period[d] == 0; side += 2) {
            const size_t i = first_exposed(sim, d, side);
            if (i == SIZE_MAX) continue;
            plan_warn(sim,
                      "domain: %s touches the %s %c side, which is neither a wall nor periodic: what leaves there is "
                      "lost, as a probe of kind `escaped` would show; put a wall there, or make %c periodic",
                      sim->c->fluids[sim->s.phase[i]].name, side < 0 ? "lower" : "upper", "xyz"[d], "xyz"[d]);
        }
}

/* What is given to a scheme that does not ask for it. */
static void warn_ignored(MnsSim *sim)
{
    for (size_t k = 0; k < sim->c->n_fluids; k++) {
        const MnsFluid *fluid = &sim->c->fluids[k];
        static const char format[] = "fluids[%zu].%s: the scheme %s makes no use of it; leave it out";
        if (fluid->density_method != MNS_DENSITY_AUTOMATIC && !sim->scheme->reads_density_method)
            plan_warn(sim, format, k, "density_method", sim->scheme->name);
        if (fluid->exponent > 0 && !sim->scheme->reads_exponent)
            plan_warn(sim, format, k, "exponent", sim->scheme->name);
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
            const char axis = "xyz"[d];
            plan_warn(
                sim,
                "probes[%zu]: %.60s is at %c = %g m, outside the domain, %g to %g m: where no fluid comes it has no "
                "value",
                k, probe->name, axis, probe->at[d], model->min[d], model->max[d]);
            break;
        }
    }
}

static const char *const KERNELS[] = {"wendland-c2", "truncated-gaussian", "quintic-spline"};
static const double AS_GIVEN = 0.01; /* of a smoothing length: two digits are as many as people give */

/* That of the case in the scheme's list of those that it was measured with; NULL: it is not in it. */
static const Suited *suited(const MnsSim *sim)
{
    const Suited *known = sim->scheme->suited;
    for (int k = 0; k < SCHEME_KERNELS_MAX && known[k].most > 0; k++)
        if (known[k].kernel == sim->c->scheme.kernel) return &known[k];
    return NULL;
}

/* Shear along a free surface needs three rows of neighbours. */
static bool is_free_and_viscous(const MnsSim *sim)
{
    return sim->scheme->free_smoothing > 0 && sim->model.viscous && !sim->model.filled;
}

static void warn_kernel(MnsSim *sim)
{
    const Suited *known = suited(sim);
    const char *scheme = sim->scheme->name;
    const double smoothing = sim->c->scheme.smoothing;
    if (!known) {
        const Suited *first = sim->scheme->suited;
        plan_warn(
            sim,
            "scheme.kernel: the scheme %s was not measured with %s; take %s with a smoothing of %g, or leave both "
            "out",
            scheme, KERNELS[sim->c->scheme.kernel], KERNELS[first->kernel], first->advised);
        return;
    }
    const bool is_free = is_free_and_viscous(sim);
    const double least = is_free ? sim->scheme->free_smoothing : known->least;
    if (smoothing >= least * (1 - AS_GIVEN) && smoothing <= known->most * (1 + AS_GIVEN)) return;
    char range[64];
    if (least < known->most) snprintf(range, sizeof range, "from %g to %g", least, known->most);
    else snprintf(range, sizeof range, "%g", least);
    plan_warn(sim,
              "scheme.smoothing: with %s and a smoothing of %g the scheme %s was not measured%s, but with %s; take %g",
              KERNELS[known->kernel], smoothing, scheme, is_free ? " at the free surface of a viscous fluid" : "",
              range, is_free ? least : known->advised);
}

static void warn_gradients(MnsSim *sim)
{
    if (sim->model.corrects_gradients && !sim->model.filled)
        plan_warn(sim,
                  "scheme.%s.gradient_correction: the fluids leave a part of the domain empty, and at a free surface "
                  "corrected gradients diverge sooner or later; set it to false, or fill the domain with a gas",
                  sim->scheme->name);
}

void plan_look_at_options(MnsSim *sim)
{
    warn_gradients(sim);
    unlike_look_at_averages(sim);
    unlike_look_at_repulsion(sim);
    sounds_look(sim);
    if (sim->scheme->look) sim->scheme->look(sim);
}

/* Of particles that stand for other volumes than a cell, where numbers of particles are evened out. */
static void warn_displacement(MnsSim *sim)
{
    const Model *model = &sim->model;
    const Particles *s = &sim->s;
    double off = 0;
#pragma omp parallel for reduction(max : off) num_threads(sim->threads)
    for (size_t i = 0; i < particles_fluid(s); i++) {
        const double change = fabs(s->m[i] / (s->rho[i] * model->cell_volume) - 1);
        if (change > off) off = change;
    }
    if (off > model->projection.density_tolerance)
        plan_warn(
            sim,
            "domain.displacement: particles stand for up to %.2g %% more or less than a cell, and the scheme %s evens "
            "out how many there are, so that what was moved moves back; keep volumes, or take no displacement",
            100 * off, sim->scheme->name);
}

void plan_look(MnsSim *sim)
{
    if (sim->scheme->corrects_density && !sim->resumed) warn_displacement(sim);
    warn_kernel(sim);
    plan_look_at_options(sim);
    unlike_look_at_tension(sim);
    warn_open_sides(sim);
    mirror_planes_look(sim);
    warn_probes_outside(sim);
    warn_ignored(sim);
    unlike_look_at_lines(sim);

    const MnsOutput *output = &sim->c->output;
    const double dt = limits_dt(sim, NULL);
    if (sim->c->n_probes) warn_interval(sim, "output.probe_interval", output->probe_interval, dt);
    warn_interval(sim, "output.snapshot_interval", output->snapshot_interval, dt);
    warn_interval(sim, "output.checkpoint_interval", output->checkpoint_interval, dt);
    const unsigned processors = (unsigned)omp_get_num_procs();
    if (sim->c->threads > processors)
        plan_warn(
            sim,
            "threads: %u on %u processors only wait for each other; %d are used, and the results are the same for "
            "any number",
            sim->c->threads, processors, sim->threads);
}

const char *mns_sim_warning(const MnsSim *sim, size_t k)
{
    return k < sim->n_warnings ? sim->warning[k] : NULL;
}
