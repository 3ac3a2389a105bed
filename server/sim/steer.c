/* SPDX-License-Identifier: BSD-3-Clause */
/* Adopt the steerable entries of a case, for all of the next step: rates that were found under the old ones push nobody any more. All that particles, lists and formulas were made from must be as it was; what is new
 * is made first and taken into use last, so that a refused change changes nothing. */
#include "base/vector.h"
#include "sim/energy.h"
#include "sim/gravity.h"
#include "sim/home.h"
#include "sim/integrator.h"
#include "sim/mirror_planes.h"
#include "sim/motion.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* NULL is a text too: of what has no formula. */
static bool same_text(const char *a, const char *b)
{
    return a == b || (a && b && strcmp(a, b) == 0);
}

static bool same_texts(char *const *a, char *const *b, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (!same_text(a[k], b[k])) return false;
    return true;
}

static bool same_part(const MnsPart *p, const MnsPart *q)
{
    return p->operation == q->operation && p->outside == q->outside && p->primitive == q->primitive &&
           same_vector(p->a, q->a) && same_vector(p->b, q->b) && same_vector(p->c, q->c) && p->radius == q->radius &&
           p->length == q->length && p->width == q->width && p->thickness == q->thickness &&
           same_text(p->formula, q->formula);
}

static bool same_shape(const MnsShape *a, const MnsShape *b)
{
    if (a->n != b->n) return false;
    for (size_t k = 0; k < a->n; k++)
        if (!same_part(&a->parts[k], &b->parts[k])) return false;
    return true;
}

static const char *domain_changed(const MnsCase *a, const MnsCase *b)
{
    const MnsSchemeOptions *o = &a->scheme, *p = &b->scheme;
    if (a->dim != b->dim) return "dimensions";
    if (a->reference_length != b->reference_length || a->resolution != b->resolution) return "resolution";
    for (int d = 0; d < a->dim; d++)
        if (a->min[d] != b->min[d] || a->max[d] != b->max[d] || a->periodic[d] != b->periodic[d]) return "domain";
    if (o->kernel != p->kernel || o->smoothing != p->smoothing || o->skin != p->skin || strcmp(o->name, p->name) != 0)
        return "scheme";
    if (a->disorder != b->disorder || a->seed != b->seed || !same_texts(a->displacement, b->displacement, 3))
        return "domain";
    const Scheme *scheme = scheme_find(o->name);
    if (scheme->keeps_options && !scheme->keeps_options(o, p)) return "scheme";
    if (a->limits.time_step_floor != b->limits.time_step_floor || a->limits.density_min != b->limits.density_min ||
        a->limits.density_max != b->limits.density_max)
        return "limits";
    if (a->n_constants != b->n_constants) return "constants";
    for (size_t k = 0; k < a->n_constants; k++)
        if (strcmp(a->constants[k].name, b->constants[k].name) != 0 ||
            strcmp(a->constants[k].value, b->constants[k].value) != 0)
            return "constants";
    return NULL;
}

static bool same_fluids(const MnsCase *a, const MnsCase *b)
{
    for (size_t k = 0; k < a->n_fluids; k++) {
        const MnsFluid *f = &a->fluids[k], *g = &b->fluids[k];
        if (f->density != g->density || f->viscosity != g->viscosity || f->sound_speed != g->sound_speed ||
            f->density_method != g->density_method || f->exponent != g->exponent || !same_shape(&f->shape, &g->shape) ||
            !same_texts(f->velocity, g->velocity, 3) || !same_text(f->pressure, g->pressure))
            return false;
    }
    return true;
}

static bool same_walls(const MnsCase *a, const MnsCase *b)
{
    for (size_t k = 0; k < a->n_walls; k++) {
        const MnsWall *w = &a->walls[k], *x = &b->walls[k];
        if (w->no_slip != x->no_slip || !same_shape(&w->shape, &x->shape) || !motion_same(&w->motion, &x->motion) ||
            !same_texts(w->surface_velocity, x->surface_velocity, 3))
            return false;
    }
    return true;
}

static bool same_probes(const MnsCase *a, const MnsCase *b)
{
    for (size_t k = 0; k < a->n_probes; k++) {
        const MnsProbe *p = &a->probes[k], *q = &b->probes[k];
        if (p->kind != q->kind || p->fluid != q->fluid || p->fluids != q->fluids || p->wall != q->wall ||
            p->axis != q->axis || p->quantity != q->quantity || p->least != q->least || p->radius != q->radius ||
            p->within != q->within || !same_vector(p->at, q->at) || !same_vector(p->min, q->min) ||
            !same_vector(p->max, q->max) || strcmp(p->name, q->name) != 0 || !same_text(p->field, q->field) ||
            !same_text(p->formula, q->formula))
            return false;
    }
    return true;
}

/* The entry that has changed and must not; NULL if there is none. */
static const char *changed(const MnsCase *a, const MnsCase *b)
{
    const char *entry = domain_changed(a, b);
    if (entry) return entry;
    if (a->n_fluids != b->n_fluids || !same_fluids(a, b)) return "fluids";
    if (memcmp(a->tension, b->tension, sizeof a->tension) != 0) return "interfaces";
    if (a->n_walls != b->n_walls || !same_walls(a, b)) return "walls";
    if (a->n_probes != b->n_probes || !same_probes(a, b)) return "probes";
    return NULL;
}

static MnsStatus compile_gravity(const MnsCase *c, double t, Formula *fresh[3], MnsError *error)
{
    static const char *const variables[] = {"t", NULL};
    Constants constants;
    MnsStatus status = constants_init(&constants, c, error);
    for (int d = 0; d < c->dim && !status; d++)
        status = formula_new(c->gravity[d], variables, constants.list, constants.n, &fresh[d], error);
    constants_done(&constants);
    for (int d = 0; d < c->dim && !status; d++)
        if (!isfinite(formula_eval(fresh[d], &t))) {
            char entry[32];
            snprintf(entry, sizeof entry, "gravity[%d]", d);
            status = mns_fail_at(error, MNS_E_INVALID, entry,
                                 "\"%.120s\" is no finite number at t = %g s, which is now", c->gravity[d], t);
        }
    return status;
}

/* With the options of c. */
static Model model_of(const MnsSim *sim, const MnsCase *c)
{
    Model model = sim->model;
    sim->scheme->options(&model, c);
    return model;
}

/* Lists for another number of threads or other mirrors, built from the same positions: no particle moves. */
static MnsStatus build_lists(MnsSim *sim, const MnsCase *c, int threads, unsigned mirrors, Neighbours *fresh,
                             MnsError *error)
{
    Model model = model_of(sim, c);
    model.mirrors = mirrors;
    const MnsStatus status =
        neighbours_init(fresh, sim->s.n, sim->s.dim, scheme_needs(sim->scheme, &model), threads, error);
    return status ? status : neighbours_build(fresh, &sim->s, &model, error);
}

/* Room for what terms write and ask their neighbours for that were not needed before. */
static MnsStatus add_fields(MnsSim *sim, const MnsCase *c, MnsError *error)
{
    const Model model = model_of(sim, c);
    const MnsStatus status = particles_add(&sim->s, scheme_fields(sim->scheme, &model), sim->threads, error);
    if (status || bundles_add(&sim->nb.bundles, sim->s.n, scheme_needs(sim->scheme, &model), sim->threads))
        return status;
    return mns_fail(error, MNS_E_MEMORY, "no memory for %zu particles", sim->s.n);
}

/* Can the rest of the run be done with the new options, the new gravity and the new end, and be measured? A probe that can go on by what
 * an older option has left could not after a restart. */
static MnsStatus affordable(MnsSim *sim, const MnsCase *c, Formula *const gravity[3], MnsError *error)
{
    const Model kept = sim->model;
    Formula *old[3];
    setup_options(sim, c);
    for (int d = 0; d < c->dim; d++) {
        old[d] = sim->gravity[d];
        sim->gravity[d] = gravity[d];
        sim->model.gravity[d] = formula_eval(gravity[d], &sim->progress.t);
    }
    MnsStatus status = setup_probes(sim, c, error);
    if (!status) status = plan_check(sim, c, false, error);
    for (int d = 0; d < c->dim; d++) sim->gravity[d] = old[d];
    sim->model = kept;
    return status;
}

/* A change that there was no memory for. To sort particles takes their rates as spare room, which the next step may read: so what
 * follows from the state is found again. */
static MnsStatus refuse(MnsSim *sim, MnsStatus status, Fields fields, bool sorted)
{
    home_enter(&sim->s, &sim->nb.bundles, sim->scheme, &sim->model, sim->threads);
    particles_keep(&sim->s, fields);
    bundles_keep(&sim->nb.bundles, scheme_needs(sim->scheme, &sim->model));
    if (sorted) integrator_derive(sim);
    return status;
}

/* Fields and bundles of an option that is off now go: nobody writes them any more, and a restart would not have them. */
static void give_up_fields(MnsSim *sim)
{
    particles_keep(&sim->s, scheme_fields(sim->scheme, &sim->model));
    bundles_keep(&sim->nb.bundles, scheme_needs(sim->scheme, &sim->model));
}

static void free_gravity(Formula *gravity[3])
{
    for (int d = 0; d < 3; d++) formula_free(gravity[d]);
}

/* Everything that is asked of a case but memory. gravity: as it will be, for the caller to free, also after a failure. */
static MnsStatus check_change(MnsSim *sim, const MnsCase *c, Formula *gravity[3], MnsError *error)
{
    MnsStatus status = mns_case_check(c, error);
    if (status) return status;
    const char *entry = changed(sim->c, c);
    if (entry) return mns_fail_at(error, MNS_E_INVALID, entry, "cannot change in a run: load the case anew");
    status = compile_gravity(c, sim->progress.t, gravity, error);
    return status ? status : affordable(sim, c, gravity, error);
}

MnsStatus mns_sim_check_steer(MnsSim *sim, const MnsCase *c, MnsError *error)
{
    Formula *gravity[3] = {0};
    const MnsStatus status = check_change(sim, c, gravity, error);
    free_gravity(gravity);
    return status;
}

/* Do these push alike? All that rates are made from and that can be steered, whatever the scheme: what only bounds steps, solves, or keeps
 * particles from walls is not among it, so that to set that changes no bit of the flow. */
static bool same_push(const Model *a, const Model *b)
{
    const Differences *p = &a->differences, *q = &b->differences;
    if (!same_vector(a->gravity, b->gravity) || a->mirrors != b->mirrors) return false;
    for (size_t k = 0; k < a->n_phases; k++)
        if (a->phase[k].p_b != b->phase[k].p_b || a->phase[k].summation != b->phase[k].summation) return false;
    return a->limiter == b->limiter && a->transport_stress == b->transport_stress &&
           a->reconstructs == b->reconstructs && a->spared == b->spared && a->density_average == b->density_average &&
           a->any_fills == b->any_fills && a->delta == b->delta && a->repulsion == b->repulsion &&
           a->shifting == b->shifting && a->dissipates_rest == b->dissipates_rest &&
           a->keeps_pair_volume == b->keeps_pair_volume && a->shifts_along_interfaces == b->shifts_along_interfaces &&
           a->corrects_gradients == b->corrects_gradients && p->diffusion == q->diffusion &&
           p->threshold == q->threshold && p->along == q->along && p->buoyancy == q->buoyancy;
}

MnsStatus mns_sim_steer(MnsSim *sim, const MnsCase *c, MnsError *error)
{
    const int threads = sim_threads_for(c);
    const Fields fields = sim->s.fields;
    const Model before = sim->model;
    const double energy = energy_of(sim);
    Neighbours lists = {0};
    Formula *gravity[3] = {0};
    MnsStatus status = check_change(sim, c, gravity, error);
    if (!status && !home_leave(&sim->s, sim->threads))
        status = mns_fail(error, MNS_E_MEMORY, "no memory for %zu particles", sim->s.n);
    if (!status) status = add_fields(sim, c, error);
    const unsigned mirrors = status ? before.mirrors : mirror_planes_find(sim, gravity);
    const bool rebuilds = !status && (threads != sim->threads || mirrors != before.mirrors);
    if (rebuilds) status = build_lists(sim, c, threads, mirrors, &lists, error);
    if (status) {
        free_gravity(gravity);
        neighbours_done(&lists);
        return refuse(sim, status, fields, rebuilds);
    }
    for (int d = 0; d < 3; d++) {
        formula_free(sim->gravity[d]);
        sim->gravity[d] = gravity[d];
    }
    gravity_forget(sim);
    if (rebuilds) {
        neighbours_done(&sim->nb);
        sim->nb = lists;
        sim->threads = threads;
    }
    sim->c = c;
    sim->model.mirrors = mirrors;
    setup_options(sim, c);
    give_up_fields(sim);
    for (size_t k = 0; k < c->n_walls; k++) sim->solid[k].shape = &c->walls[k].shape;
    setup_at(sim, sim->progress.t, sim->progress.dt, 0);
    /* Pressures at walls know of gravity, and a restart from here would find them by the new one. */
    integrator_derive(sim);
    if (!same_push(&before, &sim->model)) integrator_renew(sim);
    home_enter(&sim->s, &sim->nb.bundles, sim->scheme, &sim->model, sim->threads);
    energy_steered(sim, energy);
    plan_look_at_options(sim);
    return MNS_OK;
}
