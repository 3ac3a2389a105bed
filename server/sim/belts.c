/* SPDX-License-Identifier: BSD-3-Clause */
/* A velocity across the surface of a wall that stays where it is would pump fluid through it. So from each particle of a belt the nearest places of
 * the wall's surface with room before them are looked up, and what its velocity has along their normals is taken away:
 *   u_t = (I - sum of n n^T) u,   n orthonormal, spanning the normals of the faces nearest to the particle
 * Where two faces are equally near, as in a corner, what is along both is left. Only friction knows of it: fluid beside an edge has particles of both
 * faces in reach, and would be compressed by those of the other one. */
#include "sim/belts.h"
#include "base/array.h"
#include "sim/belt_faces.h"
#include "sim/solid.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double OFF = 1e-2, STEP = 1e-3; /* of places around a particle; to find normals by [dx] */
static const double NEW_FACE = 0.1;          /* sine of the angle between normals from which on they are of two faces */

/* Orthonormal. */
typedef struct Normals {
    int n;
    double of[3][3], sum[3]; /* of all that are nearly the first */
} Normals;

bool belts_are_on(const MnsWall *wall, int dim)
{
    for (int d = 0; d < dim; d++)
        if (strcmp(wall->surface_velocity[d], "0") != 0) return true;
    return false;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void add_normal(Normals *normals, const double normal[3])
{
    double rest[3] = {normal[0], normal[1], normal[2]};
    for (int k = 0; k < normals->n; k++) {
        const double along = dot(rest, normals->of[k]);
        for (int d = 0; d < 3; d++) rest[d] -= along * normals->of[k][d];
    }
    const double length = sqrt(dot(rest, rest));
    if (length > NEW_FACE && normals->n < 3) {
        for (int d = 0; d < 3; d++) normals->of[normals->n][d] = normals->n == 0 ? normal[d] : rest[d] / length;
        normals->n++;
    }
    const double sign = dot(normal, normals->of[0]) < 0 ? -1 : 1; /* midway in a plate, they are opposite */
    for (int d = 0; d < 3; d++) normals->sum[d] += sign * normal[d];
}

/* The mean around a place is the normal there, where a single face is round. */
static void settle(Normals *normals)
{
    const double length = sqrt(dot(normals->sum, normals->sum));
    for (int d = 0; d < 3 && normals->n == 1; d++) normals->of[0][d] = normals->sum[d] / length;
}

/* The s-th of the places around x: off by OFF in all directions, so that none that matters is equally far from two faces. */
static void place_around(const MnsSim *sim, const double x[3], int s, double ret[3])
{
    for (int d = 0; d < 3; d++) ret[d] = d < sim->model.dim ? x[d] + (s >> d & 1 ? OFF : -OFF) * sim->model.dx : 0;
}

/* What has been found for a particle of wall k: normals of faces that have room before them, and of those that have none. */
typedef struct Search {
    const MnsSim *sim;
    size_t k;
    Normals bare, covered;
    BeltTouch *touch;
} Search;

/* Take notice of the wall's normal at y before its surface. */
static void take_notice(Search *search, const double y[3], double away)
{
    const MnsSim *sim = search->sim;
    BeltTouch *touch = search->touch;
    double normal[3];
    if (!(away > 0)) return;
    shape_normal(&sim->solid[search->k], y, STEP * sim->model.dx, normal);
    if (!(dot(normal, normal) > 0)) return;
    const bool room = solid_leaves_room(sim, y);
    add_normal(room ? &search->bare : &search->covered, normal);
    if (!room || touch->room) return;
    touch->room = true;
    for (int d = 0; d < 3; d++) touch->place[d] = y[d] - away * normal[d];
}

/* Look from before the surface at a place on it, `out` being where a particle sees it. Where it is as far as it seems it is one face; else a corner,
 * whose faces are nearest from here or from there. */
static void look_at(Search *search, const double place[3], const double out[3])
{
    const int dim = search->sim->model.dim;
    const double off = OFF * search->sim->model.dx;
    double from[3], y[3] = {0, 0, 0};
    for (int d = 0; d < 3; d++) from[d] = place[d] + 0.4 * off * out[d];
    const double away = shape_distance(&search->sim->solid[search->k], from);
    if (fabs(away - 0.4 * off) < 1e-3 * off) {
        take_notice(search, from, away);
        return;
    }
    for (int q = 0; q < (dim == 2 ? 9 : 27); q++) {
        for (int d = 0, all = q; d < dim; d++, all /= 3) y[d] = from[d] + off * (all % 3 - 1);
        take_notice(search, y, shape_distance(&search->sim->solid[search->k], y));
    }
}

/* At what is nearest to x. */
static void look_straight(Search *search, const double x[3])
{
    const MnsSim *sim = search->sim;
    const Shape *solid = &sim->solid[search->k];
    for (int s = 0; s < 1 << sim->model.dim; s++) {
        double from[3], out[3], place[3];
        place_around(sim, x, s, from);
        shape_normal(solid, from, STEP * sim->model.dx, out);
        const double away = shape_distance(solid, from);
        for (int d = 0; d < 3; d++) place[d] = from[d] - away * out[d];
        look_at(search, place, out);
    }
}

/* How far it is out of the wall along a unit vector, and where that is; INFINITY: beyond the reach of any fluid. */
static double way_out(const MnsSim *sim, size_t k, const double x[3], const double to[3], double ret[3])
{
    const double dx = sim->model.dx, reach = 2 * sim->model.kernel.support;
    double along = 0;
    for (double depth = 1; depth > 0 && along < reach;) {
        for (int d = 0; d < 3; d++) ret[d] = x[d] + along * to[d];
        depth = -shape_distance(&sim->solid[k], ret);
        along += depth > 0 ? fmax(depth, STEP * dx) : 2 * OFF * dx;
    }
    for (int d = 0; d < 3; d++) ret[d] = x[d] + (along - 2 * OFF * dx) * to[d];
    return along < reach ? along : INFINITY;
}

/* Where what is nearest is covered by another wall or outside of the domain: along rows and diagonals, at the nearest that is not. */
static void look_around(Search *search, const double x[3])
{
    const MnsSim *sim = search->sim;
    double least = INFINITY, nearest[3] = {0, 0, 0}, out[3] = {0, 0, 0};
    for (int k = 0; k < solid_ways(sim->model.dim); k++) {
        double to[3], place[3], before[3];
        solid_way(sim->model.dim, k, to);
        const double away = way_out(sim, search->k, x, to, place);
        for (int d = 0; d < 3; d++) before[d] = place[d] + OFF * sim->model.dx * to[d];
        if (!(away < least) || !solid_leaves_room(sim, before)) continue;
        least = away;
        memcpy(nearest, place, sizeof nearest);
        memcpy(out, to, sizeof out);
    }
    if (isfinite(least)) look_at(search, nearest, out);
}

static void find_along(const MnsSim *sim, size_t i, double ret[6], BeltTouch *touch)
{
    static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
    const size_t k = sim->s.phase[i] - sim->model.n_phases;
    Search search = {.sim = sim, .k = k, .touch = touch};
    double x[3] = {0, 0, 0};
    *touch = (BeltTouch){0};
    for (int d = 0; d < sim->model.dim; d++) x[d] = sim->s.x[d][i];
    look_straight(&search, x);
    if (!touch->room) look_around(&search, x);
    Normals *faces = touch->room ? &search.bare : &search.covered;
    settle(faces);
    touch->n = faces->n;
    if (touch->n == 1) memcpy(touch->normal, faces->of[0], sizeof touch->normal);
    for (int q = 0; q < 6; q++) {
        ret[q] = row[q] == column[q];
        for (int f = 0; f < faces->n; f++) ret[q] -= faces->of[f][row[q]] * faces->of[f][column[q]];
    }
}

void belt_along(const double along[6], const double u[3], double ret[3])
{
    ret[0] = along[0] * u[0] + along[3] * u[1] + along[4] * u[2];
    ret[1] = along[3] * u[0] + along[1] * u[1] + along[5] * u[2];
    ret[2] = along[4] * u[0] + along[5] * u[1] + along[2] * u[2];
}

static size_t count_belts(const MnsSim *sim)
{
    size_t n = 0;
    for (size_t i = sim->s.begin[GROUP_WALL]; i < sim->s.n; i++)
        n += sim->model.wall[sim->s.phase[i] - sim->model.n_phases].has_belt;
    return n;
}

/* Store their ids and indices; particles of walls are as yet in the order of their ids. */
static void name_belts(MnsSim *sim, size_t *of)
{
    size_t n = 0;
    for (size_t i = sim->s.begin[GROUP_WALL]; i < sim->s.n; i++)
        if (sim->model.wall[sim->s.phase[i] - sim->model.n_phases].has_belt) {
            sim->belts.id[n] = sim->s.id[i];
            of[n++] = i;
        }
}

MnsStatus belts_init(MnsSim *sim, MnsError *error)
{
    Belts *belts = &sim->belts;
    MnsStatus status = MNS_OK;
    const size_t n = count_belts(sim);
    if (!n) return MNS_OK;
    *belts = (Belts){.n = n, .id = array_room(n, sizeof *belts->id), .along = array_room(n, sizeof *belts->along)};
    size_t *of = array_room(n, sizeof *of);
    BeltTouch *touches = array_room(n, sizeof *touches);
    if (!belts->id || !belts->along || !of || !touches)
        status = mns_fail(error, MNS_E_MEMORY, "no memory for the belts of %zu particles", n);
    if (!status) {
        name_belts(sim, of);
#pragma omp parallel for schedule(dynamic, 64) num_threads(sim->threads)
        for (size_t b = 0; b < n; b++) find_along(sim, of[b], belts->along[b], &touches[b]);
        belts_run(sim);
    }
    for (size_t k = 0; k < sim->model.n_walls && !status; k++)
        if (sim->model.wall[k].has_belt) status = belt_faces_judge(sim, k, touches, error);
    free(of);
    free(touches);
    return status;
}

size_t belts_bytes(size_t n)
{
    const Belts none = {0};
    return n * (sizeof *none.id + sizeof *none.along);
}

void belts_done(Belts *belts)
{
    free(belts->id);
    free(belts->along);
    *belts = (Belts){0};
}

static const double *find_belt(const Belts *belts, uint32_t id)
{
    size_t low = 0, high = belts->n - 1;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (belts->id[middle] < id) low = middle + 1;
        else high = middle;
    }
    return belts->along[low];
}

void belts_run(MnsSim *sim)
{
    Particles *s = &sim->s;
    if (!sim->belts.n) return;
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t i = s->begin[GROUP_WALL]; i < s->n; i++) {
        const WallState *wall = &sim->model.wall[s->phase[i] - sim->model.n_phases];
        double u[3];
        if (!wall->has_belt) continue;
        belt_along(find_belt(&sim->belts, s->id[i]), wall->belt, u);
        for (int d = 0; d < s->dim; d++) s->belt[d][i - particles_fluid(s)] = u[d];
    }
}
