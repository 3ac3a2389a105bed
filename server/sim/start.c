/* SPDX-License-Identifier: BSD-3-Clause */
/* The initial fields of fluids, of formulas and of what stands for one. */
#include "sim/start.h"
#include "sim/state.h"
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>

static const char *const XYZ[] = {"x", "y", "z", NULL};

static MnsStatus compile(Start *start, const MnsSim *sim, size_t k, const Constants *constants, MnsError *error)
{
    const MnsFluid *f = &sim->c->fluids[k];
    MnsStatus status = MNS_OK;
    start->at_rest = strcmp(f->pressure, "hydrostatic") == 0;
    start->laplace = strcmp(f->pressure, "laplace") == 0;
    for (int d = 0; d < sim->c->dim && !status; d++)
        status = formula_team_init(&start->velocity[d], sim->threads, f->velocity[d], XYZ, constants->list,
                                   constants->n, error);
    if (status || start->at_rest || start->laplace) return status;
    return formula_team_init(&start->pressure, sim->threads, f->pressure, XYZ, constants->list, constants->n, error);
}

/* Drops and bubbles first, as they do not weigh on what is around them; then what is at rest; then the pressure in the drops. */
static MnsStatus lay(const Start starts[], MnsSim *sim, Lattice *lattice, MnsError *error)
{
    const size_t n = sim->c->n_fluids;
    Bodies bodies = {0};
    MnsStatus status = MNS_OK;
    for (size_t k = 0; k < n && !status; k++)
        if (starts[k].laplace) status = bodies_find(&bodies, sim, lattice, k, error);
    for (size_t k = 0, laid = 0; k < n && !status && !laid; k++)
        if ((laid = starts[k].at_rest)) status = start_hydrostatic(sim, lattice, k, error);
    if (!status) status = start_laplace(sim, lattice, starts, &bodies, error);
    bodies_done(&bodies);
    return status;
}

MnsStatus start_init(Start starts[], MnsSim *sim, Lattice *lattice, const Constants *constants, MnsError *error)
{
    MnsStatus status = MNS_OK;
    for (size_t k = 0; k < sim->c->n_fluids && !status; k++) status = compile(&starts[k], sim, k, constants, error);
    return status ? status : lay(starts, sim, lattice, error);
}

void start_done(Start starts[], size_t n)
{
    for (size_t k = 0; k < n; k++) {
        for (int d = 0; d < 3; d++) formula_team_done(&starts[k].velocity[d]);
        formula_team_done(&starts[k].pressure);
    }
}

static const char *const VELOCITY[3] = {"velocity[0]", "velocity[1]", "velocity[2]"};

/* Why one of the formulas of thread `me` failed, and which: NULL if none did. */
static const char *failure(const Start *start, int dim, int me, const char **ret_which)
{
    const char *why = start->pressure.n == 0 ? NULL : formula_failure(formula_of(&start->pressure, me));
    *ret_which = "pressure";
    for (int d = 0; d < dim && !why; d++) {
        why = formula_failure(formula_of(&start->velocity[d], me));
        *ret_which = VELOCITY[d];
    }
    return why;
}

/* What of a particle is no number: the pressure, or else a component of the velocity. */
static const char *not_finite(const Particles *s, size_t i, double p)
{
    for (int d = 0; isfinite(p) && d < s->dim; d++)
        if (!isfinite(s->v[d][i])) return VELOCITY[d];
    return "pressure";
}

static bool in_bounds(const Model *model, double ratio)
{
    return ratio > model->density_min && ratio < model->density_max;
}

static MnsStatus fail_particle(const Start starts[], const MnsSim *sim, size_t i, double p, const double x[3],
                               MnsError *error)
{
    const unsigned phase = sim->s.phase[i];
    const double ratio = sim->s.rho[i] / sim->model.phase[phase].rho0;
    const char *which, *why = failure(&starts[phase], sim->s.dim, omp_get_thread_num(), &which);
    char at[64];
    if (!why) which = not_finite(&sim->s, i, p);
    snprintf(at, sizeof at, "fluids[%u].%s", phase, which);
    if (why)
        return mns_fail_at(error, MNS_E_INVALID, at, "the formula fails at (%g, %g, %g) m: %s", x[0], x[1], x[2], why);
    if (!isfinite(ratio) && isfinite(p)) {
        snprintf(at, sizeof at, "fluids[%u].pressure", phase);
        return mns_fail_at(
            error, MNS_E_INVALID, at,
            "the pressure %g Pa at (%g, %g, %g) m is below any that the equation of state has: raise it, or "
            "background_pressure or the sound speed",
            p, x[0], x[1], x[2]);
    }
    if (!isfinite(p) || in_bounds(&sim->model, ratio))
        return mns_fail_at(error, MNS_E_INVALID, at, "it is not finite at (%g, %g, %g) m", x[0], x[1], x[2]);
    snprintf(at, sizeof at, "fluids[%u].pressure", phase);
    return mns_fail_at(error, MNS_E_INVALID, at,
                       "the pressure %g Pa is too %s for the sound speed at (%g, %g, %g) m: the density would be %.3g "
                       "times that of reference, allowed (%g, %g)",
                       p, p < 0 ? "low" : "high", x[0], x[1], x[2], ratio, sim->model.density_min,
                       sim->model.density_max);
}

/* A particle stands for a cell of the lattice, or what has become of it where it was moved; what is summed there is the density that the
 * pressure asks for. */
MnsStatus start_particle(const Start starts[], MnsSim *sim, size_t i, MnsError *error)
{
    const Model *model = &sim->model;
    Particles *s = &sim->s;
    double x[3] = {0};
    for (int d = 0; d < s->dim; d++) x[d] = s->x[d][i];
    const Phase *phase = &model->phase[s->phase[i]];
    const Start *start = &starts[s->phase[i]];
    const int me = omp_get_thread_num();
    const double p = start->pressure.n == 0 ? s->p[i] : formula_eval(formula_of(&start->pressure, me), x);
    s->rho[i] = state_density(phase, p);
    s->m[i] *= s->rho[i];
    if (isinf(phase->c)) s->p[i] = p; /* no density says it */
    bool finite = isfinite(p) && in_bounds(model, s->rho[i] / phase->rho0);
    for (int d = 0; d < s->dim; d++) {
        s->v[d][i] = formula_eval(formula_of(&start->velocity[d], me), x);
        finite = finite && isfinite(s->v[d][i]);
    }
    return finite ? MNS_OK : fail_particle(starts, sim, i, p, x, error);
}
