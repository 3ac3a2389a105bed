/* SPDX-License-Identifier: BSD-3-Clause */
/* Drops and bubbles at rest: each under the pressure that the fluid around would have in the middle of it, that of surface
 * tension, and its own weight.
 *   p_i = p_around(x_c) + sigma (dim - 1) / R + rho0 g . (x_i - x_c),   R of the disc or ball of equal volume, with what is behind mirrors
 *
 * To start with the profile of the fluid around makes bubbles swing up and down. */
#include "sim/making.h"
#include "sim/start.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static MnsStatus fail_body(const MnsSim *sim, const Body *body, const char *why, MnsError *error)
{
    char at[64];
    snprintf(at, sizeof at, "fluids[%zu].pressure", body->fluid);
    return mns_fail_at(error, MNS_E_INVALID, at, "%s lies in %s at (%g, %g, %g) m, whose pressure there %s",
                       sim->c->fluids[body->fluid].name, sim->c->fluids[body->around].name, body->centre[0],
                       body->centre[1], body->centre[2], why);
}

/* To be called for each run of a body. */
typedef void Visit(MnsSim *sim, const Lattice *lattice, size_t row, const LatticeRun *run, const Body *body, double *p);

/* All of them, in one order for any number of threads. */
static MnsStatus visit(MnsSim *sim, const Lattice *lattice, const Bodies *bodies, double *p, Visit *each,
                       MnsError *error)
{
    MnsStatus status = MNS_OK;
    for (size_t r = 0; r < lattice->rows && !status; r++) {
        for (size_t k = 0; k < lattice->row[r].n; k++) {
            const LatticeRun *run = &lattice->row[r].runs[k];
            if (run->body) each(sim, lattice, r, run, &bodies->body[run->body - 1], &p[run->body - 1]);
        }
        status = making_goes_on(&sim->making, error);
    }
    return status;
}

/* The fluid around has been laid in its place, and its pressure is linear there: that in the middle is the mean. */
static void add_mean(MnsSim *sim, const Lattice *lattice, size_t row, const LatticeRun *run, const Body *body,
                     double *p)
{
    (void)lattice;
    (void)row;
    for (size_t q = 0; q < run->n; q++) *p += sim->s.p[run->at + q] / (double)body->points;
}

static void set_pressure(MnsSim *sim, const Lattice *lattice, size_t row, const LatticeRun *run, const Body *body,
                         double *p)
{
    const Model *model = &sim->model;
    for (size_t q = 0; q < run->n; q++) {
        double x[3], lower = 0;
        lattice_place(lattice, row, run->first + q, x);
        for (int d = 0; d < model->dim; d++)
            lower += model->gravity[d] * (x[d] + run->image[d] * model->period[d] - body->centre[d]);
        sim->s.p[run->at + q] = *p + model->phase[body->fluid].rho0 * lower;
    }
}

/* Of a formula, at the image of the body's middle that is in the domain. */
static double pressure_at(const Model *model, const Start *start, const double centre[3])
{
    double x[3];
    for (int d = 0; d < 3; d++)
        x[d] = centre[d] - model->period[d] * floor((centre[d] - model->min[d]) * model->frequency[d]);
    return formula_eval(formula_of(&start->pressure, 0), x);
}

/* What is around the body, if that is a formula, and what surface tension adds to it. */
static MnsStatus add_jump(const MnsSim *sim, const Start starts[], const Body *body, double *p, MnsError *error)
{
    const Start *around = &starts[body->around];
    const double R = bodies_radius(&sim->model, bodies_whole(body)),
                 capillary = sim->c->tension[body->fluid][body->around] / R;
    if (around->laplace) return fail_body(sim, body, "is laplace too: give one of them another start", error);
    if (!around->at_rest) *p = pressure_at(&sim->model, around, body->centre);
    if (!isfinite(*p)) return fail_body(sim, body, "is not finite", error);
    *p += (sim->model.dim - 1) * capillary;
    return MNS_OK;
}

MnsStatus start_laplace(MnsSim *sim, const Lattice *lattice, const Start starts[], const Bodies *bodies,
                        MnsError *error)
{
    if (bodies->n == 0) return MNS_OK;
    double *p = calloc(bodies->n, sizeof *p);
    if (!p) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu drops and bubbles", bodies->n);
    MnsStatus status = visit(sim, lattice, bodies, p, add_mean, error);
    for (size_t k = 0; k < bodies->n && !status; k++) status = add_jump(sim, starts, &bodies->body[k], &p[k], error);
    if (!status) status = visit(sim, lattice, bodies, p, set_pressure, error);
    free(p);
    return status;
}
