/* SPDX-License-Identifier: BSD-3-Clause */
/* Which runs of a fluid hang together: from one run to all that touch it, and on from those. */
#include "sim/bodies.h"
#include "sim/making.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A run, by its row and its place there. */
typedef struct Member {
    size_t row, k;
} Member;

/* The search for one fluid. */
typedef struct Search {
    const MnsSim *sim;
    Lattice *lattice;
    Body *body;
    uint32_t number;
    Member *members; /* of the body, as they are found; room for all runs of the fluid */
    size_t n, seen;
    size_t
        beside[MNS_MAX_FLUIDS]; /* points of other fluids that touch the body, counted once for each run they touch */
    int around;                 /* the direction in which it meets itself beyond a seam; -1: none */
    bool survey;                /* for bodies_survey() */
    size_t plane[6];            /* where the wall on a side is, as a point of the lattice, once it has met one there */
} Search;

/* Where to look for what touches a run: a row, by so many periods off, and the points [from, to) of the run and one more on
 * each side, as that row counts them. */
typedef struct View {
    size_t row;
    int image[3];
    ptrdiff_t from, to;
} View;

/* x: of its first point. */
static void note_mirrors(Search *s, const LatticeRun *run, const double x[3])
{
    const Model *model = &s->sim->model;
    const double *spacing = s->lattice->spacing;
    for (int side = 0; side < 2 * model->dim; side++) {
        const int d = side / 2;
        const double at = side == 1 ? x[0] + (run->n - 1) * spacing[0] : x[d];
        if (model->mirrors >> side & 1 && model_before_mirror(model, side, at) < spacing[d])
            s->body->mirrors |= 1u << side;
    }
}

static void note_extent(Search *s, const LatticeRun *run, const double x[3])
{
    for (int d = 0; d < 3; d++) {
        const double at = x[d] + run->image[d] * s->sim->model.period[d];
        const double length = d == 0 ? (run->n - 1) * s->lattice->spacing[0] : 0;
        s->body->min[d] = fmin(s->body->min[d], at);
        s->body->max[d] = fmax(s->body->max[d], at + length);
    }
}

static void join(Search *s, size_t row, size_t k, const int image[3])
{
    LatticeRun *run = &s->lattice->row[row].runs[k];
    double x[3];
    run->body = s->number;
    for (int d = 0; d < 3; d++) run->image[d] = (short)image[d];
    s->members[s->n++] = (Member){row, k};
    s->body->points += run->n;
    lattice_place(s->lattice, row, run->first, x);
    note_mirrors(s, run, x);
    note_extent(s, run, x);
    x[0] += 0.5 * (run->n - 1) * s->lattice->spacing[0];
    for (int d = 0; d < 3; d++) s->body->centre[d] += run->n * (x[d] + image[d] * s->sim->model.period[d]);
}

/* A run of the same fluid touches the body. */
static void meet(Search *s, size_t row, size_t k, const int image[3])
{
    const LatticeRun *run = &s->lattice->row[row].runs[k];
    if (!run->body) join(s, row, k, image);
    for (int d = 0; d < 3; d++)
        if (run->image[d] != image[d]) {
            s->around = d;
            s->body->spans |= 1u << d;
        }
}

/* The first run of a row that ends beyond a point. */
static size_t first_beyond(const LatticeRow *row, ptrdiff_t point)
{
    size_t low = 0, high = row->n;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if ((ptrdiff_t)row->runs[middle].first + (ptrdiff_t)row->runs[middle].n > point) high = middle;
        else low = middle + 1;
    }
    return low;
}

static void look(Search *s, const View *view)
{
    const LatticeRow *row = &s->lattice->row[view->row];
    for (size_t k = first_beyond(row, view->from); k < row->n && row->runs[k].first < view->to; k++) {
        const LatticeRun *run = &row->runs[k];
        const ptrdiff_t first = run->first, end = first + run->n;
        const ptrdiff_t from = first > view->from ? first : view->from, to = end < view->to ? end : view->to;
        if ((size_t)run->owner == s->body->fluid) meet(s, view->row, k, view->image);
        else if ((size_t)run->owner < s->sim->model.n_phases) s->beside[run->owner] += (size_t)(to - from);
    }
}

/* One step along d, across the seam if there is one. False beyond an end. */
static bool step(const Search *s, ptrdiff_t *at, int *image, int d, int by)
{
    const ptrdiff_t n = (ptrdiff_t)s->lattice->n[d];
    *at += by;
    if (*at >= 0 && *at < n) return true;
    if (s->sim->model.period[d] == 0) return false;
    *image += by;
    *at -= by * n;
    return true;
}

/* All rows that touch a run, its own too, and their images where the run is at a seam. */
static void look_around(Search *s, Member member)
{
    const Lattice *lattice = s->lattice;
    const LatticeRun *run = &lattice->row[member.row].runs[member.k];
    const ptrdiff_t n = (ptrdiff_t)lattice->n[0];
    const int seams = s->sim->model.period[0] > 0;
    for (int z = -1; z <= 1; z++)
        for (int y = -1; y <= 1; y++) {
            ptrdiff_t at[2] = {(ptrdiff_t)(member.row % lattice->n[1]), (ptrdiff_t)(member.row / lattice->n[1])};
            int image[3] = {run->image[0], run->image[1], run->image[2]};
            if ((y && !step(s, &at[0], &image[1], 1, y)) || (z && !step(s, &at[1], &image[2], 2, z))) continue;
            for (int x = -seams; x <= seams; x++)
                look(s, &(View){.row = (size_t)at[1] * lattice->n[1] + (size_t)at[0],
                                .image = {image[0] + x, image[1], image[2]},
                                .from = (ptrdiff_t)run->first - 1 - x * n,
                                .to = (ptrdiff_t)run->first + run->n + 1 - x * n});
        }
}

/* What of a row lies beside some points of a run, on one side of it. */
static void touch(Search *s, const LatticeRow *row, size_t first, size_t n, int side, size_t plane)
{
    size_t covered = 0;
    for (size_t k = first_beyond(row, (ptrdiff_t)first); k < row->n && row->runs[k].first < first + n; k++) {
        const LatticeRun *run = &row->runs[k];
        const size_t from = run->first > first ? run->first : first, end = run->first + run->n;
        covered += (end < first + n ? end : first + n) - from;
        if ((size_t)run->owner < s->sim->model.n_phases) continue;
        if (s->body->walls >> side & 1 && s->plane[side] != plane) s->body->uneven |= 1u << side;
        s->body->walls |= 1u << side;
        s->plane[side] = plane;
    }
    s->body->open = s->body->open || covered < n;
}

/* Walls, empty places and ends of the domain beside a run, in the directions of the axes. */
static void touch_around(Search *s, Member member)
{
    const Lattice *lattice = s->lattice;
    const LatticeRun *run = &lattice->row[member.row].runs[member.k];
    for (int side = 0; side < 2 * s->sim->model.dim; side++) {
        const int d = side / 2, by = side % 2 ? 1 : -1;
        ptrdiff_t at[3] = {by < 0 ? (ptrdiff_t)run->first : (ptrdiff_t)run->first + run->n - 1,
                           (ptrdiff_t)(member.row % lattice->n[1]), (ptrdiff_t)(member.row / lattice->n[1])};
        int image = 0;
        if (!step(s, &at[d], &image, d, by)) {
            s->body->open = true;
            continue;
        }
        const LatticeRow *row = &lattice->row[(size_t)at[2] * lattice->n[1] + (size_t)at[1]];
        touch(s, row, d == 0 ? (size_t)at[0] : run->first, d == 0 ? 1 : run->n, side, (size_t)at[d]);
    }
}

static MnsStatus fail_body(const Search *s, const char *why, MnsError *error)
{
    const Body *body = s->body;
    const Model *model = &s->sim->model;
    char at[64];
    double x[3];
    for (int d = 0; d < 3; d++) /* its image in the domain */
        x[d] = body->centre[d] - model->period[d] * floor((body->centre[d] - model->min[d]) * model->frequency[d]);
    snprintf(at, sizeof at, "fluids[%zu].pressure", body->fluid);
    return mns_fail_at(error, MNS_E_INVALID, at,
                       "a laplace start is for drops and bubbles, and the %s of %zu particles about (%g, %g, %g) m %s",
                       s->sim->c->fluids[body->fluid].name, body->points, x[0], x[1], x[2], why);
}

/* The search has come to its end: what is it that was found? */
static MnsStatus conclude(Search *s, MnsError *error)
{
    Body *body = s->body;
    char why[64];
    for (int d = 0; d < 3; d++) body->centre[d] /= (double)body->points;
    for (size_t k = 0; k < s->sim->model.n_phases; k++) body->beside |= s->beside[k] > 0 ? 1u << k : 0;
    if (s->survey) return MNS_OK;
    if (s->around >= 0) {
        snprintf(why, sizeof why, "reaches around the periodic direction %c to itself", "xyz"[s->around]);
        return fail_body(s, why, error);
    }
    for (size_t k = 0; k < s->sim->model.n_phases; k++)
        if (s->beside[k] > s->beside[body->around]) body->around = k;
    if (s->beside[body->around] == 0) return fail_body(s, "touches no other fluid", error);
    for (size_t k = 0; k < s->n; k++)
        s->lattice->row[s->members[k].row].runs[s->members[k].k].weighs_as = (int)body->around;
    return MNS_OK;
}

/* The body that a run is in. */
static MnsStatus find(Search *s, Bodies *bodies, Member from, MnsError *error)
{
    Body *body = realloc(bodies->body, (bodies->n + 1) * sizeof *body);
    if (!body) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu drops and bubbles", bodies->n + 1);
    const int here[3] = {0, 0, 0};
    const size_t fluid = (size_t)s->lattice->row[from.row].runs[from.k].owner;
    MnsStatus status = MNS_OK;
    bodies->body = body;
    s->body = &body[bodies->n++];
    *s->body = (Body){.fluid = fluid, .min = {INFINITY, INFINITY, INFINITY}, .max = {-INFINITY, -INFINITY, -INFINITY}};
    s->number = (uint32_t)bodies->n;
    s->n = s->seen = 0;
    s->around = -1;
    memset(s->beside, 0, sizeof s->beside);
    join(s, from.row, from.k, here);
    while (s->seen < s->n && !status) {
        if (s->survey) touch_around(s, s->members[s->seen]);
        look_around(s, s->members[s->seen++]);
        status = making_goes_on(&s->sim->making, error);
    }
    return status ? status : conclude(s, error);
}

static size_t count_runs(const Lattice *lattice, size_t fluid)
{
    size_t n = 0;
    for (size_t r = 0; r < lattice->rows; r++)
        for (size_t k = 0; k < lattice->row[r].n; k++) n += (size_t)lattice->row[r].runs[k].owner == fluid;
    return n;
}

static MnsStatus find_all(Bodies *bodies, const MnsSim *sim, Lattice *lattice, size_t fluid, bool survey,
                          MnsError *error)
{
    const size_t runs = count_runs(lattice, fluid);
    Search search = {
        .sim = sim, .lattice = lattice, .members = malloc(runs * sizeof *search.members), .survey = survey};
    MnsStatus status = MNS_OK;
    if (!search.members) status = mns_fail(error, MNS_E_MEMORY, "no memory for drops and bubbles of %zu runs", runs);
    for (size_t r = 0; r < lattice->rows && !status; r++)
        for (size_t k = 0; k < lattice->row[r].n && !status; k++) {
            const LatticeRun *run = &lattice->row[r].runs[k];
            if ((size_t)run->owner == fluid && !run->body) status = find(&search, bodies, (Member){r, k}, error);
        }
    free(search.members);
    return status;
}

MnsStatus bodies_find(Bodies *bodies, const MnsSim *sim, Lattice *lattice, size_t fluid, MnsError *error)
{
    return find_all(bodies, sim, lattice, fluid, false, error);
}

MnsStatus bodies_survey(Bodies *bodies, const MnsSim *sim, Lattice *lattice, size_t fluid, MnsError *error)
{
    const MnsStatus status = find_all(bodies, sim, lattice, fluid, true, error);
    for (size_t r = 0; r < lattice->rows; r++)
        for (size_t k = 0; k < lattice->row[r].n; k++) {
            LatticeRun *run = &lattice->row[r].runs[k];
            if ((size_t)run->owner != fluid) continue;
            run->body = 0;
            memset(run->image, 0, sizeof run->image);
        }
    return status;
}

void bodies_done(Bodies *bodies)
{
    free(bodies->body);
    *bodies = (Bodies){0};
}

/* Between two mirrors there is no end of it. */
size_t bodies_whole(const Body *body)
{
    size_t points = body->points;
    for (int d = 0; d < 3; d++) {
        const unsigned both = body->mirrors >> 2 * d & 3;
        if (both == 1 || both == 2) points *= 2;
    }
    return points;
}

double bodies_radius(const Model *model, size_t points)
{
    const double volume = (double)points * model->cell_volume;
    return model->dim == 2 ? sqrt(volume / M_PI) : cbrt(0.75 * volume / M_PI);
}
