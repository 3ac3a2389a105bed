/* SPDX-License-Identifier: BSD-3-Clause */
/* Through a wall that is thinner than the kernel's support, the fluids on its two sides push each other: the pressure of its particles is a mean of
 * both, and the rows of the one see the other. So from each point of the lattice beside a wall a ray goes straight into it, and what it meets until it
 * comes out, of whatever walls that is made, must be a support in all, or there must be no room behind it. A neck between two corners has no side that is
 * normal to it: necks.c looks for those. */
#include "sim/solid.h"
#include "sim/necks.h"
#include <math.h>
#include <stdio.h>

/* In spacings. */
static const double ON_SURFACE = 0.005; /* rounding of walls that have moved is less */
static const double LEAST_STEP = 1e-4;  /* of a ray; what is thinner is not seen */
static const double ROOM_FROM = 0.4;    /* behind a wall, where it is looked for */
static const double ROOM_TO = 1.5;      /* a row of the lattice is nearer, wherever the wall lies in it */
static const double TIP =
    0.86602540378443865; /* cosine of 30 degrees: sides that meet at more are a tip, as long as it is thick */

double solid_distance(const MnsSim *sim, const double x[3], size_t *ret_wall)
{
    double least = INFINITY;
    *ret_wall = 0;
    for (size_t k = 0; k < sim->model.n_walls; k++) {
        const double distance = shape_distance(&sim->solid[k], x);
        if (!(distance < least)) continue;
        least = distance;
        *ret_wall = k;
    }
    return least;
}

double solid_distance_now(const MnsSim *sim, const double x[3])
{
    const Model *model = &sim->model;
    double least = INFINITY;
    for (size_t k = 0; k < model->n_walls; k++) {
        double then[3] = {0, 0, 0}; /* where the case puts the wall, and its particles, which is within the domain */
        for (int d = 0; d < model->dim; d++) {
            then[d] = x[d] - model->wall[k].x[d];
            if (model->period[d] > 0)
                then[d] -= model->period[d] * floor((then[d] - model->min[d]) * model->frequency[d]);
        }
        least = fmin(least, shape_distance(&sim->solid[k], then));
    }
    return least;
}

bool solid_covers(const MnsSim *sim, const double x[3], double away)
{
    const Model *model = &sim->model;
    const double near = ON_SURFACE * model->dx;
    if (fabs(away) > 2 * near) return away < 0;
    for (int corner = 0; corner < 1 << model->dim; corner++) {
        double y[3] = {x[0], x[1], x[2]};
        for (int d = 0; d < model->dim; d++) y[d] += corner >> d & 1 ? near : -near;
        if (solid_distance_now(sim, y) > 1e-6 * model->dx) return false;
    }
    return true;
}

bool solid_leaves_room(const MnsSim *sim, const double x[3])
{
    const Model *model = &sim->model;
    size_t wall;
    for (int d = 0; d < model->dim; d++)
        if (!(model->period[d] > 0) && !(x[d] >= model->min[d] && x[d] <= model->max[d])) return false;
    return solid_distance(sim, x, &wall) >= 0;
}

int solid_ways(int dim)
{
    return dim == 2 ? 8 : 26;
}

void solid_way(int dim, int k, double ret[3])
{
    const int q = k < solid_ways(dim) / 2 ? k : k + 1; /* the one in the middle leads nowhere */
    ret[0] = q % 3 - 1;
    ret[1] = q / 3 % 3 - 1;
    ret[2] = dim == 2 ? 0 : q / 9 - 1;
    const double length = sqrt(ret[0] * ret[0] + ret[1] * ret[1] + ret[2] * ret[2]);
    for (int d = 0; d < 3; d++) ret[d] /= length;
}

/* How far it is along a unit vector to where there is room, and where that is, to 1e-6 dx; INFINITY: not within `most`. */
static double way_out(const MnsSim *sim, const double x[3], const double to[3], double most, double ret[3])
{
    const double step = 0.1 * sim->model.dx;
    double solid = 0, room = step;
    while (room < most) {
        for (int d = 0; d < 3; d++) ret[d] = x[d] + room * to[d];
        if (solid_leaves_room(sim, ret)) break;
        solid = room;
        room += step;
    }
    if (!(room < most)) return INFINITY;
    while (room - solid > 1e-6 * sim->model.dx) {
        const double middle = 0.5 * (solid + room);
        for (int d = 0; d < 3; d++) ret[d] = x[d] + middle * to[d];
        if (solid_leaves_room(sim, ret)) room = middle;
        else solid = middle;
    }
    for (int d = 0; d < 3; d++) ret[d] = x[d] + room * to[d];
    return room;
}

/* To the plane that touches the surface at y, unless a ray comes out there askew: at an edge it is chance whose face is found. */
static bool to_plane(const MnsSim *sim, const double x[3], const double y[3], const double ray[3], double ret[3])
{
    static const double STRAIGHT = 0.85; /* cosine; along rows and diagonals some ray is, whatever the normal */
    size_t wall;
    double normal[3], depth = -solid_distance(sim, y, &wall), along = 0;
    shape_normal(&sim->solid[wall], y, 1e-3 * sim->model.dx, normal);
    for (int d = 0; d < 3; d++) along += ray[d] * normal[d];
    for (int d = 0; d < 3; d++) depth += (y[d] - x[d]) * normal[d];
    if (!(along > STRAIGHT)) return false;
    for (int d = 0; d < 3; d++) ret[d] = depth * normal[d];
    return true;
}

void solid_to_surface(const MnsSim *sim, const double x[3], size_t wall, double ret[3])
{
    const Model *model = &sim->model;
    double normal[3], y[3], least = 2 * model->kernel.support;
    const double depth = -shape_distance(&sim->solid[wall], x);
    shape_normal(&sim->solid[wall], x, 1e-3 * model->dx, normal);
    for (int d = 0; d < 3; d++) {
        ret[d] = depth * normal[d];
        y[d] = x[d] + (depth + 1e-2 * model->dx) * normal[d];
    }
    if (solid_leaves_room(sim, y)) return;
    for (int k = 0; k < solid_ways(model->dim); k++) {
        double to[3];
        solid_way(model->dim, k, to);
        const double away = way_out(sim, x, to, least, y);
        if (away < least && to_plane(sim, x, y, to, ret)) least = away;
    }
}

/* Is there room at the point of the lattice that is nearest to x? */
static bool is_room(const MnsSim *sim, const double x[3])
{
    const Model *model = &sim->model;
    double point[3] = {0, 0, 0};
    for (int d = 0; d < model->dim; d++)
        point[d] = model->min[d] + (floor((x[d] - model->min[d]) / model->cell[d]) + 0.5) * model->cell[d];
    return solid_leaves_room(sim, point);
}

/* What a ray has met. */
typedef struct Ray {
    const MnsSim *sim;
    const double *from, *to; /* unit vector */
    double solid, behind;    /* how much of it, and of what is free since [m] */
    bool tip;                /* it came out through a side that is oblique to it */
} Ray;

/* Is what lies between two places thinner than the support? */
static bool is_thin(Ray *ray)
{
    const MnsSim *sim = ray->sim;
    const double dx = sim->model.dx, support = sim->model.kernel.support, least = LEAST_STEP * dx;
    bool met = false;
    for (double along = 0; ray->solid < support - 5 * least && ray->behind < ROOM_TO * dx;) {
        double x[3], normal[3];
        size_t wall;
        for (int d = 0; d < 3; d++) x[d] = ray->from[d] + along * ray->to[d];
        const double distance = solid_distance(sim, x, &wall);
        const double step = fmax(least, distance < 0 ? -distance : fmin(distance, met ? 0.25 * dx : dx));
        along += step;
        if (distance < 0) {
            met = true;
            ray->solid += step;
            ray->behind = 0;
            continue;
        }
        if (!met && along > 3 * dx) return false;
        if (!met) continue;
        if (ray->behind == 0) {
            shape_normal(&sim->solid[wall], x, 0.5 * least, normal);
            ray->tip = normal[0] * ray->to[0] + normal[1] * ray->to[1] + normal[2] * ray->to[2] < TIP;
        }
        if (ray->behind > ROOM_FROM * dx && is_room(sim, x)) return !ray->tip;
        ray->behind += step;
    }
    return false;
}

static MnsStatus refuse(const MnsSim *sim, double thickness, const double x[3], size_t wall, MnsError *error)
{
    char at[64];
    snprintf(at, sizeof at, "walls[%zu].shape", wall);
    return mns_fail_at(error, MNS_E_INVALID, at,
                       "%.60s is %.3g m thick near (%g, %g, %g) m, with room for fluid on both sides, which would push "
                       "each other through it: make it at least as thick as the kernel's support, %.6g m, or leave no "
                       "room on one side",
                       sim->c->walls[wall].name, thickness, x[0], x[1], x[2], sim->model.kernel.support);
}

/* Midway between two sides of a wall both are the nearest, and no normal says where to: a little off, one is. */
static bool find_way(const MnsSim *sim, const double x[3], size_t wall, int side, double to[3])
{
    static const double off[3] = {1, 0.7, 0.4};
    const double dx = sim->model.dx;
    double from[3] = {0, 0, 0};
    for (int d = 0; d < sim->model.dim; d++) from[d] = x[d] + side * 0.01 * dx * off[d];
    shape_normal(&sim->solid[wall], from, 1e-3 * dx, to);
    for (int d = 0; d < 3; d++) to[d] = -to[d];
    return to[0] != 0 || to[1] != 0 || to[2] != 0;
}

MnsStatus solid_check(const MnsSim *sim, const double x[3], double away, size_t wall, MnsError *error)
{
    const Model *model = &sim->model;
    double to[3];
    if (!(away < 1.01 * fmax(model->cell[0], fmax(model->cell[1], model->cell[2])))) return MNS_OK;
    const bool both = !find_way(sim, x, wall, 0, to);
    for (int side = both ? -1 : 1; side <= 1; side += 2) {
        Ray ray = {.sim = sim, .from = x, .to = to};
        if (both && !find_way(sim, x, wall, side, to)) continue;
        if (is_thin(&ray)) return refuse(sim, ray.solid, x, wall, error);
    }
    bool found;
    double thickness, place[3];
    const MnsStatus status = necks_find(sim, x, away, &found, &thickness, place, error);
    if (status || !found) return status;
    solid_distance(sim, place, &wall);
    return refuse(sim, thickness, place, wall, error);
}
