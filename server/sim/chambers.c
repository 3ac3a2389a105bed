/* SPDX-License-Identifier: BSD-3-Clause */
/* Through a thin wall the rows of two spaces refer to each other by little, and the pressures that this little asks for, to let through what
 * neither can hold, are without bound: runs of P4 diverged in the third step. So spaces are told apart by where no wall is between neighbours, and
 * none may be joined by what rows refer to. */
#include "sim/chambers.h"
#include "base/array.h"
#include "base/forest.h"
#include "sim/making.h"
#include <math.h>
#include <stdlib.h>

static const double NEARER = 0.5; /* spacings that a fluid may come nearer to a wall than it is at the start */
enum { MAKING_ASKED = 1 << 20 };  /* particles, after which it is asked whether to go on */

typedef struct Chambers {
    const MnsSim *sim;
    size_t n;        /* fluid particles */
    size_t least;    /* of a space: fewer are what a lattice leaves in a corner */
    uint32_t *of;    /* [n] of each fluid particle the first of its space */
    uint32_t *count; /* [n] how many a space has, at its first particle */
} Chambers;

/* ret: the way from i to the nearest image of j; returns its length. */
static double way(const MnsSim *sim, size_t i, size_t j, double ret[3])
{
    double r2 = 0;
    for (int d = 0; d < 3; d++) {
        ret[d] = d < sim->s.dim ? -model_nearest(&sim->model, d, sim->s.x[d][i] - sim->s.x[d][j]) : 0;
        r2 += ret[d] * ret[d];
    }
    return sqrt(r2);
}

/* Walls thinner than half a spacing would have no particles. */
static bool is_wall_between(const MnsSim *sim, size_t i, size_t j)
{
    double to[3], x[3];
    const int steps = (int)ceil(way(sim, i, j, to) / (0.25 * sim->model.dx));
    for (int k = 1; k < steps; k++) {
        for (int d = 0; d < 3; d++) x[d] = d < sim->s.dim ? sim->s.x[d][i] + to[d] * k / steps : 0;
        for (size_t w = 0; w < sim->model.n_walls; w++)
            if (shape_distance(&sim->solid[w], x) < 0) return true;
    }
    return false;
}

/* With those before it, most of which are of one space already. */
static void join_neighbours(Chambers *c, uint32_t i)
{
    const uint32_t *list = neighbours_of(&c->sim->nb, i);
    for (size_t k = 0; k < c->sim->nb.end[i][END_WALLS]; k++) {
        if (list[k] >= i) continue;
        if (forest_root(c->of, i) != forest_root(c->of, list[k]) && !is_wall_between(c->sim, i, list[k]))
            forest_join(c->of, i, list[k]);
    }
}

/* How many spaces of some size there are. */
static MnsStatus tell_apart(Chambers *c, size_t *ret_spaces, MnsError *error)
{
    MnsStatus status = MNS_OK;
#pragma omp parallel for schedule(static) num_threads(c->sim->threads)
    for (size_t i = 0; i < c->n; i++) c->of[i] = (uint32_t)i;
    for (size_t from = 0; from < c->n && !status; from += MAKING_ASKED) {
        const size_t end = from + MAKING_ASKED < c->n ? from + MAKING_ASKED : c->n;
#pragma omp parallel for schedule(dynamic, 256) num_threads(c->sim->threads)
        for (size_t i = from; i < end; i++) join_neighbours(c, (uint32_t)i);
        status = making_goes_on(&c->sim->making, error);
    }
#pragma omp parallel for schedule(static) num_threads(c->sim->threads)
    for (size_t i = 0; i < c->n; i++) forest_settle(c->of, (uint32_t)i);
    *ret_spaces = 0;
    for (size_t i = 0; i < c->n; i++) *ret_spaces += ++c->count[c->of[i]] == c->least;
    return status;
}

/* Does the row of a particle refer to two spaces? */
static bool joins(const Chambers *c, size_t i)
{
    const uint32_t none = UINT32_MAX, *list = neighbours_of(&c->sim->nb, i);
    const Model *model = &c->sim->model;
    const double reach = (model->kernel.support + fmin(NEARER * model->dx, model->skin)) * (1 + 1e-9);
    uint32_t space = i < c->n ? c->of[i] : none;
    double to[3];
    if (space != none && c->count[space] < c->least) return false;
    for (size_t k = 0; k < c->sim->nb.end[i][END_WALLS]; k++) {
        const uint32_t j = list[k];
        const uint32_t its = j < c->n ? c->of[j] : none;
        if (its == none || c->count[its] < c->least) continue;
        if (space == its || way(c->sim, i, j, to) > reach) continue;
        if (space != none) return true;
        space = its;
    }
    return false;
}

/* SIZE_MAX: none does. */
static size_t first_that_joins(const Chambers *c)
{
    size_t first = SIZE_MAX;
#pragma omp parallel for schedule(dynamic, 256) reduction(min : first) num_threads(c->sim->threads)
    for (size_t i = 0; i < c->sim->s.n; i++)
        if (i < first && joins(c, i)) first = i;
    return first;
}

static MnsStatus refuse(const MnsSim *sim, size_t i, MnsError *error)
{
    double x[3] = {0};
    for (int d = 0; d < sim->s.dim; d++) x[d] = sim->s.x[d][i];
    return mns_fail_at(
        error, MNS_E_INVALID, "walls",
        "the wall near (%g, %g, %g) m is so thin that the pressures of the two closed spaces beside it would not be "
        "apart: with the scheme %s and at this resolution, make it at least %.3g m thick, or open it",
        x[0], x[1], x[2], sim->scheme->name, 2 * (sim->model.kernel.support + NEARER * sim->model.dx));
}

MnsStatus chambers_check(const MnsSim *sim, MnsError *error)
{
    Chambers c = {.sim = sim, .n = particles_fluid(&sim->s), .least = sim->s.dim == 2 ? 9 : 27};
    c.of = array_new(c.n, sizeof *c.of);
    c.count = array_new(c.n, sizeof *c.count);
    MnsStatus status = MNS_OK;
    size_t spaces = 0;
    if (!c.of || !c.count)
        status = mns_fail(error, MNS_E_MEMORY, "no memory to tell the spaces of %zu particles apart", c.n);
    else status = tell_apart(&c, &spaces, error);
    if (spaces > 1 && !status) {
        const size_t first = first_that_joins(&c);
        if (first < sim->s.n) status = refuse(sim, first, error);
    }
    free(c.of);
    free(c.count);
    return status;
}
