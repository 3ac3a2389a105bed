/* SPDX-License-Identifier: BSD-3-Clause */
/* Which parts of a fluid are drops or bubbles, and how much their surface is curved at rest.
 *   A part that reaches from wall to wall, or around a period to itself, lies flat in that direction: what is left in two or three others is
 *   a disc or a ball. A flat wall that it touches on one side cuts it in half, as interfaces meet walls at 90 degrees. A part that lies flat in all
 *   directions but one is a layer, and one that is open to an empty place or to an end of the domain is under a free surface. */
#include "sim/drops.h"
#include "sim/bodies.h"
#include <math.h>
#include <string.h>

static void find_reach(MnsSim *sim)
{
    for (size_t k = 0; k < sim->model.n_phases; k++)
        for (int d = 0; d < 3; d++) {
            sim->start[k].min[d] = d < sim->model.dim ? INFINITY : 0;
            sim->start[k].max[d] = d < sim->model.dim ? -INFINITY : 0;
        }
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        FluidStart *start = &sim->start[sim->s.phase[i]];
        for (int d = 0; d < sim->model.dim; d++) {
            start->min[d] = fmin(start->min[d], sim->s.x[d][i]);
            start->max[d] = fmax(start->max[d], sim->s.x[d][i]);
        }
    }
}

/* Of the disc or ball that a part is at rest, whole; 0: it is neither. */
static double radius_of(const Model *model, const Body *body)
{
    double volume = (double)body->points * model->cell_volume;
    int ends = 0;
    for (int d = 0; d < model->dim; d++) {
        const unsigned walls = body->walls >> 2 * d & 3;
        if (body->spans >> d & 1) volume /= model->period[d];
        else if (walls == 3) volume /= body->max[d] - body->min[d] + model->cell[d];
        else {
            ends++;
            if (walls && !body->uneven) volume *= 2;
        }
    }
    if (body->open || ends < 2) return 0;
    return ends == 2 ? sqrt(volume / M_PI) : cbrt(0.75 * volume / M_PI);
}

static void note(Curved *curved, double tension, double R, bool bound)
{
    if (tension / R > curved->capillary) *curved = (Curved){tension / R, 2 * R, bound};
}

static void add(const Model *model, FluidStart *start, const Body *body)
{
    const double R = radius_of(model, body);
    if (!(R > 0)) {
        start->drops = false;
        return;
    }
    start->across = fmax(start->across, 2 * R);
    for (size_t m = 0; m < model->n_phases; m++) {
        const double tension = model->tension[body->fluid][m];
        if (!(body->beside >> m & 1) || !(tension > 0)) continue;
        note(&start->most, tension, R, body->uneven);
        note(&start->in[m], tension, R, body->uneven);
    }
}

MnsStatus drops_find(MnsSim *sim, Lattice *lattice, MnsError *error)
{
    MnsStatus status = MNS_OK;
    find_reach(sim);
    for (size_t k = 0; k < sim->model.n_phases && !sim->scheme->projects && !status; k++) {
        Bodies bodies = {0};
        if (!sim->model.tense && strcmp(sim->c->fluids[k].pressure, "laplace") != 0) continue;
        status = bodies_survey(&bodies, sim, lattice, k, error);
        sim->start[k].drops = !status;
        for (size_t q = 0; q < bodies.n && !status; q++) add(&sim->model, &sim->start[k], &bodies.body[q]);
        bodies_done(&bodies);
    }
    return status;
}
