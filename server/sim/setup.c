/* SPDX-License-Identifier: BSD-3-Clause */
/* From the case to the model: what is fixed, what can be steered, and what follows the time. */
#include "sim/belts.h"
#include "sim/gravity.h"
#include "sim/mirror_planes.h"
#include "sim/motion.h"
#include "sim/probes/probes.h"
#include "sim/terms/terms.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char *const T[] = {"t", NULL}, *const XYZT[] = {"x", "y", "z", "t", NULL};

static void set_geometry(Model *model, const MnsCase *c)
{
    model->dim = c->dim;
    model->dx = c->reference_length / c->resolution;
    model->level = level_in_use();
    model->cell_volume = 1;
    for (int d = 0; d < c->dim; d++) {
        case_fit(c, d, &model->cell[d]);
        model->cell_volume *= model->cell[d];
        model->min[d] = c->min[d];
        model->max[d] = c->max[d];
        if (c->periodic[d]) {
            model->period[d] = c->max[d] - c->min[d];
            model->frequency[d] = 1 / model->period[d];
            model->periodic = true;
        }
    }
    model->kernel = kernel_make(c->scheme.kernel, c->dim, c->scheme.smoothing * model->dx);
    kernel_calibrate(&model->kernel, model->dim, model->cell);
    model->spread =
        model->cell_volume * kernel_lattice_sum(&model->kernel, model->dim, model->cell, kernel_quantity_spread);
    model->skin = c->scheme.skin * model->dx;
    model->viscous_scale = viscosity_scale(&model->kernel, model->dim, model->cell);
    model->radial_scale = radial_viscosity_scale(&model->kernel, model->dim, model->cell);
}

void setup_options(MnsSim *sim, const MnsCase *c)
{
    Model *model = &sim->model;
    model->n_phases = c->n_fluids;
    model->n_walls = c->n_walls;
    model->c_max = model->rho_max = 0;
    model->rho_min = INFINITY;
    model->viscous = false;
    for (size_t k = 0; k < c->n_fluids; k++) {
        const MnsFluid *f = &c->fluids[k];
        model->phase[k] = (Phase){.rho0 = f->density, .c = f->sound_speed, .mu = f->viscosity, .exponent = 1};
        model->c_max = fmax(model->c_max, f->sound_speed);
        model->rho_max = fmax(model->rho_max, f->density);
        model->rho_min = fmin(model->rho_min, f->density);
        model->viscous = model->viscous || f->viscosity > 0;
    }
    model->tense = false;
    for (size_t a = 0; a < c->n_fluids; a++)
        for (size_t b = 0; b < c->n_fluids; b++) {
            model->tension[a][b] = c->tension[a][b];
            model->tense = model->tense || c->tension[a][b] > 0;
        }
    tension_share(model);
    model->cfl = c->scheme.cfl;
    model->density_min = c->limits.density_min;
    model->density_max = c->limits.density_max;
    model->dt_floor = c->limits.time_step_floor;
    for (size_t k = 0; k < c->n_walls; k++) {
        model->wall[k].no_slip = c->walls[k].no_slip;
        model->wall[k].has_belt = belts_are_on(&c->walls[k], c->dim);
    }
    sim->scheme->options(model, c);
}

static MnsStatus compile(Formula **ret, int n, char *const *texts, const Constants *constants, MnsError *error)
{
    MnsStatus status = MNS_OK;
    for (int d = 0; d < n && !status; d++)
        status = formula_new(texts[d], T, constants->list, constants->n, &ret[d], error);
    return status;
}

/* What mirrors what lies beside it (terms/images.c). */
static MnsStatus find_faces(MnsSim *sim, MnsError *error)
{
    size_t room = 0, n = 0;
    for (size_t k = 0; k < sim->c->n_walls; k++) room += sim->c->walls[k].shape.n * FACES_MAX;
    sim->face = calloc(room + 1, sizeof *sim->face);
    if (!sim->face) return mns_fail(error, MNS_E_MEMORY, "no memory for the faces of walls");
    for (size_t k = 0; k < sim->c->n_walls; k++) {
        const size_t first = n;
        n += shape_faces(&sim->solid[k], sim->face + n);
        for (size_t q = first; q < n; q++) sim->face[q].wall = k;
    }
    sim->model.n_faces = n;
    sim->model.face = sim->face;
    return MNS_OK;
}

/* The names of fields, as a list for people. */
static const char *list_fields(Fields fields, size_t size, char text[])
{
    size_t used = 0;
    text[0] = 0;
    for (int f = 0; mns_fields()[f].name && used < size; f++)
        if (fields >> f & 1)
            used += (size_t)snprintf(text + used, size - used, "%s%s", used ? ", " : "", mns_fields()[f].name);
    return text;
}

MnsStatus setup_probes(const MnsSim *sim, const MnsCase *c, MnsError *error)
{
    const Fields fields = scheme_fields(sim->scheme, &sim->model) | scheme_made(sim->scheme, &sim->model);
    for (size_t k = 0; k < c->n_probes; k++) {
        const MnsProbe *probe = &c->probes[k];
        const ProbeKind *kind = probe_kind(probe);
        char entry[64], list[480];
        if (!(kind->uses & PROBE_FIELD) || fields >> mns_field_find(probe->field) & 1) continue;
        snprintf(entry, sizeof entry, "probes[%zu].%s.field", k, kind->name);
        return mns_fail_at(error, MNS_E_INVALID, entry,
                           "the scheme %s has no field \"%.60s\" with these options; take one of %s", sim->scheme->name,
                           probe->field, list_fields(fields, sizeof list, list));
    }
    return MNS_OK;
}

MnsStatus setup_model(MnsSim *sim, MnsError *error)
{
    const MnsCase *c = sim->c;
    Constants constants;
    MnsStatus status = constants_init(&constants, c, error);
    if (status) return status;
    set_geometry(&sim->model, c);
    setup_options(sim, c);
    status = setup_probes(sim, c, error);
    if (!status) status = compile(sim->gravity, c->dim, c->gravity, &constants, error);
    for (size_t k = 0; k < c->n_walls && !status; k++) {
        status = compile(sim->surface[k], c->dim, c->walls[k].surface_velocity, &constants, error);
        if (!status)
            status =
                shape_init(&sim->solid[k], &c->walls[k].shape, c->dim, constants.list, constants.n, "walls", error);
        if (!status) shape_repeat(&sim->solid[k], sim->model.period);
    }
    if (!status) status = find_faces(sim, error);
    if (!status) {
        mirror_planes_place(sim);
        sim->model.mirrors = mirror_planes_find(sim, sim->gravity);
    }
    for (size_t k = 0; k < c->n_probes && !status; k++)
        if (probe_kind(&c->probes[k])->uses & PROBE_FORMULA)
            status = formula_team_init(&sim->probe_formula[k], sim->threads, c->probes[k].formula, XYZT, constants.list,
                                       constants.n, error);
    if (!status) {
        setup_at(sim, sim->progress.t, sim->progress.dt, 0);
        status = setup_check(sim, sim->progress.t, 0, error);
    }
    if (!status) status = plan_check(sim, c, false, error); /* before particles are placed in vain */
    if (!status) status = build_particles(sim, &constants, error);
    constants_done(&constants);
    return status;
}

/* The velocity of a wall is its mean from t - dt to t + ahead, so that velocity and displacement agree. Schemes that project take the velocity at t, as they
 * add the wall's acceleration: with the mean, the fluid in a shaken tank is half a step late. */
static void move_wall(MnsSim *sim, size_t k, double t, double dt, double ahead)
{
    WallState *wall = &sim->model.wall[k];
    const MnsMotion *motion = &sim->c->walls[k].motion;
    double before[3], after[3], v[3], a[3];
    motion_at(motion, t - dt, before, v, a);
    motion_at(motion, t + ahead, after, v, a);
    motion_at(motion, t, wall->x, v, wall->a);
    for (int d = 0; d < sim->model.dim; d++) {
        const double material = dt > 0 && !sim->scheme->projects ? (after[d] - before[d]) / (dt + ahead) : v[d];
        wall->v[d] = material;
        wall->belt[d] = formula_eval(sim->surface[k][d], &t);
    }
}

void setup_at(MnsSim *sim, double t, double dt, double ahead)
{
    Model *model = &sim->model;
    model->t = t;
    model->dt = dt;
    model->lag = sim->scheme->integrator->staggered ? 0.5 * dt : 0;
    gravity_mean(sim, t - dt, t + ahead, model->gravity);
    for (int d = 0; d < model->dim; d++) model->gravity_now[d] = formula_eval(sim->gravity[d], &t);
    for (size_t k = 0; k < model->n_walls; k++) move_wall(sim, k, t, dt, ahead);
}

/* A formula that gives no finite number at t, and what can be done: nothing has begun yet, or the run stands before that. */
static MnsStatus fail_formula(const MnsSim *sim, const Formula *formula, const char *entry, const char *text, double t,
                              const char *change, MnsError *error)
{
    const char *why = formula_failure(formula);
    return mns_fail_at(error, MNS_E_INVALID, entry, "%s: \"%.120s\" is of no use at t = %g s: %s. %s", entry, text, t,
                       why ? why : "it is no finite number there", sim->progress.step ? change : "Change it");
}

static const char *const ANEW = "It cannot change in a run: load the case with another";

static MnsStatus check_surface(const MnsSim *sim, size_t k, double t, MnsError *error)
{
    for (int d = 0; d < sim->model.dim; d++) {
        const Formula *formula = sim->surface[k][d];
        char entry[64];
        if (isfinite(formula_eval(formula, &t))) continue;
        snprintf(entry, sizeof entry, "walls[%zu].surface_velocity[%d]", k, d);
        return fail_formula(sim, formula, entry, sim->c->walls[k].surface_velocity[d], t, ANEW, error);
    }
    return MNS_OK;
}

/* It may be as good as new elsewhere, so it is blamed once. */
static MnsStatus check_probe(MnsSim *sim, size_t k, MnsError *error)
{
    char entry[64];
    const char *why = formula_team_failure(&sim->probe_formula[k]);
    if (!why) return MNS_OK;
    snprintf(entry, sizeof entry, "probes[%zu].pressure_deviation.from", k);
    const MnsStatus status =
        mns_fail_at(error, MNS_E_INVALID, entry, "%s: \"%.120s\" failed at some particle at t = %g s: %s. %s", entry,
                    sim->c->probes[k].formula, sim->progress.t, why, ANEW);
    formula_team_forget(&sim->probe_formula[k]);
    return status;
}

static MnsStatus check_gravity(MnsSim *sim, double t, double dt, MnsError *error)
{
    int d;
    double when;
    char entry[64];
    if (!gravity_failure(sim, t - dt, t, &d, &when)) return MNS_OK;
    snprintf(entry, sizeof entry, "gravity[%d]", d);
    return fail_formula(sim, sim->gravity[d], entry, sim->c->gravity[d], when, "Set another, and the run can go on",
                        error);
}

static MnsStatus check_surfaces(const MnsSim *sim, double t, MnsError *error)
{
    MnsStatus status = MNS_OK;
    for (size_t k = 0; k < sim->model.n_walls && !status; k++) status = check_surface(sim, k, t, error);
    return status;
}

MnsStatus setup_check(MnsSim *sim, double t, double dt, MnsError *error)
{
    MnsStatus status = MNS_OK;
    for (size_t k = 0; k < sim->c->n_probes && !status; k++) status = check_probe(sim, k, error);
    if (!status) status = check_gravity(sim, t, dt, error);
    if (!status && sim->scheme->integrator->halfway) status = check_surfaces(sim, t - 0.5 * dt, error);
    return status ? status : check_surfaces(sim, t, error);
}
