/* SPDX-License-Identifier: BSD-3-Clause */
/* Walls that move as one close a side if every way straight from the fluid to it, as the case starts, meets them. If they leave one side open at most they are a
 * vessel, and fluid in it goes where it goes. A plate or a post is none: what it carries out is lost. */
#include "sim/sides.h"
#include "sim/motion.h"
#include "sim/solid.h"
#include <stdlib.h>

static const double LEAST_STEP = 1e-3; /* of a way, in spacings; what is thinner is not met */

/* Lines of the lattice along d, and between which points on each of them there is fluid. */
typedef struct Lines {
    const Lattice *lattice;
    int d, e, f; /* the others across */
    size_t n;
    uint32_t *first, *last; /* [n]; first > last: there is none */
} Lines;

static void lines_done(Lines *l)
{
    free(l->first);
    free(l->last);
}

/* The points of a run of fluid. */
static void mark(Lines *l, size_t row, const LatticeRun *run)
{
    const size_t *n = l->lattice->n;
    size_t index[3] = {run->first, row % n[1], row / n[1]};
    for (; index[0] < (size_t)run->first + run->n; index[0]++) {
        const size_t line = index[l->e] + n[l->e] * index[l->f];
        const uint32_t at = (uint32_t)index[l->d];
        if (at < l->first[line]) l->first[line] = at;
        if (at > l->last[line]) l->last[line] = at;
    }
}

static MnsStatus lines_init(Lines *l, const Lattice *lattice, const MnsSim *sim, int d, MnsError *error)
{
    *l = (Lines){.lattice = lattice, .d = d, .e = d == 0 ? 1 : 0, .f = d == 2 ? 1 : 2};
    l->n = lattice->n[l->e] * lattice->n[l->f];
    l->first = malloc(l->n * sizeof *l->first);
    l->last = calloc(l->n, sizeof *l->last);
    if (!l->first || !l->last) {
        lines_done(l);
        return mns_fail(error, MNS_E_MEMORY, "no memory for %zu lines of the lattice", l->n);
    }
    for (size_t k = 0; k < l->n; k++) l->first[k] = UINT32_MAX;
    for (size_t r = 0; r < lattice->rows; r++)
        for (size_t k = 0; k < lattice->row[r].n; k++)
            if ((size_t)lattice->row[r].runs[k].owner < sim->model.n_phases) mark(l, r, &lattice->row[r].runs[k]);
    return MNS_OK;
}

static void place_of(const Lines *l, size_t line, size_t at, double x[3])
{
    const Lattice *lattice = l->lattice;
    size_t index[3];
    index[l->d] = at;
    index[l->e] = line % lattice->n[l->e];
    index[l->f] = line / lattice->n[l->e];
    for (int d = 0; d < 3; d++) x[d] = lattice->low[d] + (double)index[d] * lattice->spacing[d];
}

/* Do those that move as `leader` does hold a way from x out through a side, before it has gone as far as walls have particles? */
static bool holds(const MnsSim *sim, size_t leader, int side, double x[3])
{
    const Model *model = &sim->model;
    while (model_inside(model, side, x[side / 2]) >= -model->kernel.support) {
        double away = INFINITY;
        for (size_t k = leader; k < model->n_walls; k++)
            if (sim->sides.leader[k] == leader) away = fmin(away, shape_distance(&sim->solid[k], x));
        if (away < 0) return true;
        x[side / 2] += (side % 2 ? 1 : -1) * fmax(away, LEAST_STEP * model->dx);
    }
    return false;
}

static bool closes(const MnsSim *sim, const Lines *l, size_t leader, int side)
{
    size_t open = 0;
#pragma omp parallel for schedule(dynamic, 64) reduction(+ : open) num_threads(sim->threads)
    for (size_t line = 0; line < l->n; line++) {
        double x[3];
        if (l->first[line] > l->last[line]) continue;
        place_of(l, line, side % 2 ? l->last[line] : l->first[line], x);
        open += !holds(sim, leader, side, x);
    }
    return open == 0;
}

MnsStatus sides_find(MnsSim *sim, const Lattice *lattice, MnsError *error)
{
    const MnsCase *c = sim->c;
    Sides *sides = &sim->sides;
    MnsStatus status = MNS_OK;
    for (size_t k = 0; k < c->n_walls; k++) {
        size_t leader = 0;
        while (!motion_same(&c->walls[leader].motion, &c->walls[k].motion)) leader++;
        sides->leader[k] = leader;
        sides->closed[k] = 0;
    }
    for (int d = 0; d < sim->model.dim && !status; d++) {
        Lines lines;
        if (sim->model.period[d] > 0) continue;
        status = lines_init(&lines, lattice, sim, d, error);
        if (status) break;
        for (size_t k = 0; k < c->n_walls; k++)
            for (int side = 2 * d; side < 2 * d + 2 && sides->leader[k] == k; side++)
                if (closes(sim, &lines, k, side)) sides->closed[k] |= 1u << side;
        lines_done(&lines);
    }
    return status;
}

static bool is_vessel(const MnsSim *sim, size_t leader)
{
    int open = 0;
    for (int side = 0; side < 2 * sim->model.dim; side++)
        open += sim->model.period[side / 2] == 0 && !(sim->sides.closed[leader] >> side & 1);
    return open <= 1;
}

/* The farthest out that anything takes a side. Unless a vessel does, or fluids fill the domain, so that there is no way around a wall, not less than to where it is. */
static double farthest(const MnsSim *sim, int side, bool any_vessel)
{
    const int d = side / 2, sign = side % 2 ? 1 : -1;
    const bool filled = sim->model.filled;
    double out = any_vessel || filled ? -INFINITY : 0;
    for (size_t k = 0; k < sim->model.n_walls; k++) {
        if (sim->sides.leader[k] != k) continue;
        const double moved = sign * sim->model.wall[k].x[d];
        if (sim->sides.closed[k] >> side & 1) out = fmax(out, moved);
        else if (!filled && is_vessel(sim, k)) out = fmax(out, fmax(0, moved));
    }
    return out > -INFINITY ? sign * out : 0;
}

int sides_now(const MnsSim *sim, double ret_min[3], double ret_max[3])
{
    const Model *model = &sim->model;
    int vessels = 0, vessel = -1;
    for (size_t k = 0; k < model->n_walls; k++) {
        if (sim->sides.leader[k] != k || !is_vessel(sim, k)) continue;
        vessels++;
        vessel = (int)k;
    }
    for (int d = 0; d < model->dim; d++) {
        const bool periodic = model->period[d] > 0;
        ret_min[d] = periodic ? -INFINITY : model->min[d] + farthest(sim, 2 * d, vessels > 0);
        ret_max[d] = periodic ? INFINITY : model->max[d] + farthest(sim, 2 * d + 1, vessels > 0);
    }
    return vessels == 1 ? vessel : -1;
}
