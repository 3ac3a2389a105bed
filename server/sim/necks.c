/* SPDX-License-Identifier: BSD-3-Clause */
/* Where two corners of walls touch or nearly do, each is thick along its normals, and yet the fluids on the two sides of the neck between them are
 * neighbours. Around an edge or a tip of a wall a way leads from point to point of the lattice; past a neck none does. So the points around one are filled
 * from it, step by step where no solid is between, and what is left out behind too little solid is the other side of a neck. Only where surfaces
 * of unlike directions are near can there be one, which six distances tell. */
#include "sim/necks.h"
#include "sim/solid.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* In spacings. */
static const double APART = 1.5;  /* two distances that tell whether a surface bends towards the point between them */
static const double BEND = 0.25;  /* their mean is less than its own by this, twice */
static const double NARROW = 0.1; /* what is nearer than this to solid on both sides is no way */
static const double ASIDE = 0.3;  /* a way that grazes a surface goes around there */
static const double ON_IT = 0.01; /* a point so near to a surface is part of no way, though a particle may be there */
static const double LEAST = 1e-4; /* step through solid */
static const double EXACT = 1e-3; /* what is said of a place */
static const double BESIDE = 1.5; /* both ends together are from the solid between them */
static const double AROUND =
    2.5; /* supports: a way around a tip of 30 degrees is nearer, where that is thinner than a support */

/* Points of the lattice around one. */
typedef struct Window {
    const MnsSim *sim;
    const double *centre;
    int reach[3];
    size_t n;
    double *away;  /* [n] from the solid [m]; negative: no room */
    bool *filled;  /* [n] */
    size_t *queue; /* [n] */
} Window;

static void window_done(Window *w)
{
    free(w->away);
    free(w->filled);
    free(w->queue);
}

static void offset_of(const Window *w, size_t k, int offset[3])
{
    for (int d = 0; d < 3; d++) {
        const size_t side = 2 * (size_t)w->reach[d] + 1;
        offset[d] = (int)(k % side) - w->reach[d];
        k /= side;
    }
}

static void place_of(const Window *w, size_t k, double x[3])
{
    int offset[3];
    offset_of(w, k, offset);
    for (int d = 0; d < 3; d++) x[d] = w->centre[d] + offset[d] * (d < w->sim->model.dim ? w->sim->model.cell[d] : 0);
}

static double squared_distance(const double a[3], const double b[3])
{
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

static MnsStatus window_init(Window *w, const MnsSim *sim, const double centre[3], double radius, MnsError *error)
{
    *w = (Window){.sim = sim, .centre = centre, .n = 1};
    for (int d = 0; d < sim->model.dim; d++) {
        w->reach[d] = (int)(radius / sim->model.cell[d]);
        w->n *= 2 * (size_t)w->reach[d] + 1;
    }
    w->away = malloc(w->n * sizeof *w->away);
    w->filled = calloc(w->n, sizeof *w->filled);
    w->queue = malloc(w->n * sizeof *w->queue);
    if (!w->away || !w->filled || !w->queue) {
        window_done(w);
        return mns_fail(error, MNS_E_MEMORY, "no memory for %zu points around a wall", w->n);
    }
    for (size_t k = 0; k < w->n; k++) {
        double x[3];
        size_t wall;
        place_of(w, k, x);
        w->away[k] = squared_distance(x, centre) <= radius * radius && solid_leaves_room(sim, x)
                         ? solid_distance(sim, x, &wall)
                         : -1;
    }
    return MNS_OK;
}

/* Does a way from one place to another keep `least` from all solid, but for what is `from` and `to` of its ends? Else where it comes nearer. */
static bool is_free(const MnsSim *sim, const double a[3], const double b[3], double from, double to, double least,
                    double ret_where[3])
{
    const double length = sqrt(squared_distance(a, b));
    for (double along = from; along < length - to;) {
        double x[3];
        size_t wall;
        for (int d = 0; d < 3; d++) x[d] = a[d] + along / length * (b[d] - a[d]);
        const double distance = solid_distance(sim, x, &wall);
        if (distance < least) {
            memcpy(ret_where, x, sizeof x);
            return false;
        }
        along += distance;
    }
    return true;
}

/* A way around what a straight one meets at x, on one of its sides. It is looked at all along: a neck may begin right where it turns. */
static bool is_free_aside(const MnsSim *sim, const double a[3], const double b[3], const double x[3], double from,
                          double to, double least)
{
    for (int side = 0; side < 2 * sim->model.dim; side++) {
        double way[3] = {x[0], x[1], x[2]}, where[3];
        size_t wall;
        way[side / 2] += (side % 2 ? ASIDE : -ASIDE) * sim->model.dx;
        const double room = solid_distance(sim, way, &wall) - least;
        if (room > 0 && is_free(sim, a, way, from, room, least, where) && is_free(sim, way, b, room, to, least, where))
            return true;
    }
    return false;
}

/* Does a way lead from one point to the other, straight or around what it grazes? It may be as near to a surface as the ends are. */
static bool is_clear(const Window *w, size_t from, size_t to)
{
    const double dx = w->sim->model.dx, start = w->away[from], end = w->away[to];
    const double least = fmin(NARROW * dx, fmax(0.5 * fmin(start, end), ON_IT * dx));
    double a[3], b[3], x[3];
    place_of(w, from, a);
    place_of(w, to, b);
    if (start + end - sqrt(squared_distance(a, b)) > 2 * least) return true;
    const double from_a = fmax(start, 3 * least), to_b = fmax(end, 3 * least);
    return is_free(w->sim, a, b, from_a, to_b, least, x) || is_free_aside(w->sim, a, b, x, from_a, to_b, least);
}

/* How much solid is between two points [m], or at least `enough`; and where the middle of it is. */
static double solid_between(const Window *w, size_t from, size_t to, double enough, double middle[3])
{
    const double dx = w->sim->model.dx;
    double a[3], b[3], solid = 0, nearest = INFINITY, first = 0, last = 0;
    place_of(w, from, a);
    place_of(w, to, b);
    const double length = sqrt(squared_distance(a, b));
    for (double along = 0; along < length && solid < enough;) {
        double x[3];
        size_t wall;
        for (int d = 0; d < 3; d++) x[d] = a[d] + along / length * (b[d] - a[d]);
        const double distance = solid_distance(w->sim, x, &wall);
        const double step = fmax(LEAST * dx, fmin(fabs(distance), length - along));
        if (fmax(distance, 0) < nearest) first = along;
        if (fmax(distance, 0) <= nearest) last = along + (distance < 0 ? step : 0);
        nearest = fmin(nearest, fmax(distance, 0));
        if (distance < 0) solid += step;
        along += step;
    }
    for (int d = 0; d < 3; d++) middle[d] = a[d] + 0.5 * (first + last) / length * (b[d] - a[d]);
    return solid;
}

/* Fill the points around one, up to `far` of them away in each direction. */
static size_t fill_around(Window *w, size_t from, size_t queued, int far)
{
    const int side = 2 * far + 1, flat = w->sim->model.dim == 2, layer = side * side;
    int offset[3];
    offset_of(w, from, offset);
    for (int k = flat ? far * layer : 0; k < (flat ? (far + 1) * layer : side * layer); k++) {
        const int step[3] = {k % side - far, k / side % side - far, k / layer - far};
        size_t to = 0;
        bool inside = true;
        for (int d = 2; d >= 0; d--) {
            const int at = offset[d] + step[d];
            inside = inside && abs(at) <= w->reach[d];
            to = to * (2 * (size_t)w->reach[d] + 1) + (size_t)(at + w->reach[d]);
        }
        if (!inside || w->filled[to] || w->away[to] < 0 || !is_clear(w, from, to)) continue;
        w->filled[to] = true;
        w->queue[queued++] = to;
    }
    return queued;
}

/* Fill from the centre; with care, from whatever is in its sight, and through gaps that have no point in them. */
static void fill(Window *w, bool with_care)
{
    const size_t centre = w->n / 2;
    size_t queued = 0;
    w->filled[centre] = true;
    w->queue[queued++] = centre;
    for (size_t k = 0; with_care && k < w->n; k++) {
        if (w->filled[k] || w->away[k] < 0 || !is_clear(w, centre, k)) continue;
        w->filled[k] = true;
        w->queue[queued++] = k;
    }
    for (size_t k = 0; k < queued; k++)
        if (k == 0 || w->away[w->queue[k]] >= ON_IT * w->sim->model.dx)
            queued = fill_around(w, w->queue[k], queued, with_care ? 2 : 1);
}

/* How near both ends of a neck are. */
static double near(const MnsSim *sim)
{
    return sim->model.kernel.support + BESIDE * sim->model.dx;
}

/* The least solid, below `least`, between a point and what is near it and not filled; and where that is. */
static double find_thinnest(const Window *w, size_t from, double least, double ret_place[3])
{
    double a[3], b[3], middle[3];
    place_of(w, from, a);
    for (size_t to = 0; to < w->n; to++) {
        if (w->filled[to] || w->away[to] < 0) continue;
        place_of(w, to, b);
        if (squared_distance(a, b) > near(w->sim) * near(w->sim)) continue;
        const double solid = solid_between(w, from, to, least, middle);
        if (!(solid < least) || is_clear(w, from, to)) continue;
        least = solid;
        for (int d = 0; d < 3; d++)
            ret_place[d] = round(middle[d] / (EXACT * w->sim->model.dx)) * EXACT * w->sim->model.dx;
    }
    return least;
}

/* Is there a neck, seen from the middle of the window? */
static bool find_neck(const Window *w, double *ret_thickness, double ret_place[3])
{
    const double enough = w->sim->model.kernel.support - 5 * LEAST * w->sim->model.dx;
    *ret_thickness = find_thinnest(w, w->n / 2, enough, ret_place);
    return *ret_thickness < enough;
}

/* Where it is the thinnest is seen from another point. */
static void look_elsewhere(const Window *w, double *thickness, double place[3])
{
    for (size_t k = 0; k < w->n; k++) {
        double x[3];
        place_of(w, k, x);
        if (w->filled[k] && squared_distance(x, w->centre) < near(w->sim) * near(w->sim))
            *thickness = find_thinnest(w, k, *thickness, place);
    }
}

/* Is more than one surface near? Past a flat one or around an edge a point is as far from it, in the mean, as those on its two sides. */
static bool is_bent(const MnsSim *sim, const double x[3], double away)
{
    const double dx = sim->model.dx;
    for (int d = 0; d < sim->model.dim; d++) {
        double one[3] = {x[0], x[1], x[2]}, other[3] = {x[0], x[1], x[2]};
        size_t wall;
        one[d] += APART * dx;
        other[d] -= APART * dx;
        if (2 * away - solid_distance(sim, one, &wall) - solid_distance(sim, other, &wall) > BEND * dx) return true;
    }
    return false;
}

MnsStatus necks_find(const MnsSim *sim, const double x[3], double away, bool *ret_found, double *ret_thickness,
                     double ret_place[3], MnsError *error)
{
    Window w;
    *ret_found = false;
    if (!is_bent(sim, x, away)) return MNS_OK;
    MnsStatus status = window_init(&w, sim, x, near(sim), error);
    if (status) return status;
    fill(&w, false);
    const bool apart = find_neck(&w, ret_thickness, ret_place);
    window_done(&w);
    if (!apart) return MNS_OK;
    status = window_init(&w, sim, x, fmax(near(sim), AROUND * sim->model.kernel.support), error);
    if (status) return status;
    fill(&w, true);
    *ret_found = find_neck(&w, ret_thickness, ret_place);
    if (*ret_found) look_elsewhere(&w, ret_thickness, ret_place);
    window_done(&w);
    return MNS_OK;
}
