/* SPDX-License-Identifier: BSD-3-Clause */
/* What a wall loses of the velocity that the case gives its surface, face by face. */
#include "sim/belt_faces.h"
#include "sim/solid.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static const double LOSS_MAX = 0.01; /* of a face, beyond which it is said */
static const double NONE = 1e-6;     /* what of a velocity along a surface is rounding */
static const double NEAR = 1e-2;     /* what is on a surface, and what is before it [dx] */
enum { MOMENTS = 65, BELT_FACES_MAX = 64 };

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The velocity that the case gives a surface, at moments of the run that no period has in common. */
typedef struct Asked {
    double u[MOMENTS][3], most; /* its greatest size [m/s] */
} Asked;

static Asked ask(const MnsSim *sim, size_t k)
{
    static const double golden = 0.61803398874989485;
    const double end = isfinite(sim->c->end_time) ? sim->c->end_time : 1;
    Asked asked = {.most = 0};
    for (int q = 0; q < MOMENTS; q++) {
        const double t = end * (q * golden - floor(q * golden));
        for (int d = 0; d < sim->model.dim; d++) asked.u[q][d] = formula_eval(sim->surface[k][d], &t);
        const double size = sqrt(dot(asked.u[q], asked.u[q]));
        if (isfinite(size)) asked.most = fmax(asked.most, size);
        else asked.u[q][0] = asked.u[q][1] = asked.u[q][2] = 0; /* which the run will say */
    }
    return asked;
}

/* A face of a wall that loses some of its velocity: flat, or all of a part that is round. */
typedef struct BeltFace {
    size_t part, n; /* particles */
    bool round;
    double normal[3], sum[3]; /* of the first particle; of places */
    double lost;              /* the most, of 1 */
    double where[3];
} BeltFace;

static bool is_of(const BeltFace *face, size_t part, bool round, const BeltTouch *touch)
{
    if (face->part != part || face->round != round) return false;
    return round || dot(face->normal, touch->normal) > 0.99;
}

/* Is a particle of a cylinder beside one of its ends, which are flat? */
static bool is_round(const MnsPart *part, const double normal[3], int dim)
{
    const double axis[3] = {part->b[0] - part->a[0], part->b[1] - part->a[1], part->b[2] - part->a[2]};
    if (part->primitive == MNS_BALL) return true;
    return part->primitive == MNS_CYLINDER && dim == 3 && fabs(dot(axis, normal)) < 0.99 * sqrt(dot(axis, axis));
}

/* Is a place on the surface of wall k, with room before it? */
static bool is_bare(const MnsSim *sim, size_t k, const double place[3], const double normal[3])
{
    const double near = NEAR * sim->model.dx;
    double before[3];
    for (int d = 0; d < 3; d++) before[d] = place[d] + near * normal[d];
    return fabs(shape_distance(&sim->solid[k], place)) < near && solid_leaves_room(sim, before);
}

/* Straight before particle i, if the face is there; else the place found, which is elsewhere if what is straight before i is outside of the domain. */
static void find_place(const MnsSim *sim, size_t k, size_t i, const BeltTouch *touch, double ret[3])
{
    double x[3] = {0, 0, 0}, away = 0;
    for (int d = 0; d < sim->model.dim; d++) x[d] = sim->s.x[d][i];
    for (int d = 0; d < 3; d++) away += (x[d] - touch->place[d]) * touch->normal[d];
    for (int d = 0; d < 3; d++) ret[d] = x[d] - away * touch->normal[d];
    if (!is_bare(sim, k, ret, touch->normal)) memcpy(ret, touch->place, sizeof touch->place);
}

static void count_face(const MnsSim *sim, size_t k, size_t i, const BeltTouch *touch, double lost, BeltFace *faces,
                       size_t *n)
{
    double place[3];
    find_place(sim, k, i, touch, place);
    const size_t part = shape_nearest_part(&sim->solid[k], place);
    const bool round = is_round(&sim->solid[k].shape->parts[part], touch->normal, sim->model.dim);
    size_t f = 0;
    while (f < *n && !is_of(&faces[f], part, round, touch)) f++;
    if (f == BELT_FACES_MAX) return; /* there are not as many warnings */
    if (f == *n) {
        faces[(*n)++] = (BeltFace){.part = part, .round = round};
        memcpy(faces[f].normal, touch->normal, sizeof faces[f].normal);
    }
    BeltFace *face = &faces[f];
    face->n++;
    for (int d = 0; d < 3; d++) face->sum[d] += place[d];
    if (lost > face->lost) {
        face->lost = lost;
        memcpy(face->where, place, sizeof face->where);
    }
}

/* The most that is left along the surface, and that is lost, at any moment, of the greatest velocity asked for. */
static void compare(const double along[6], const Asked *asked, double *ret_left, double *ret_lost)
{
    *ret_left = *ret_lost = 0;
    for (int q = 0; q < MOMENTS; q++) {
        double left[3];
        belt_along(along, asked->u[q], left);
        const double size = sqrt(dot(left, left));
        *ret_left = fmax(*ret_left, size / asked->most);
        *ret_lost = fmax(*ret_lost, (sqrt(dot(asked->u[q], asked->u[q])) - size) / asked->most);
    }
}

/* The middle of a flat face if the face is there; else where most is lost. */
static void name_place(const MnsSim *sim, size_t k, const BeltFace *face, double ret[3])
{
    for (int d = 0; d < 3; d++) ret[d] = face->sum[d] / (double)face->n;
    if (face->round || !is_bare(sim, k, ret, face->normal)) memcpy(ret, face->where, sizeof face->where);
    for (int d = 0; d < 3; d++) ret[d] = fabs(ret[d]) < 1e-9 * sim->model.dx ? 0 : ret[d];
}

static void warn_faces(MnsSim *sim, size_t k, const BeltFace *faces, size_t n)
{
    for (size_t f = 0; f < n; f++) {
        const BeltFace *face = &faces[f];
        double at[3];
        name_place(sim, k, face, at);
        plan_warn(sim,
                  "walls[%zu].surface_velocity: %.3g %% of it is lost on the %s face of shape[%zu] of %.60s around "
                  "(%.4g, %.4g, %.4g) m, as only what is along a surface acts",
                  k, 100 * face->lost, face->round ? "round" : "flat", face->part, sim->c->walls[k].name, at[0], at[1],
                  at[2]);
    }
}

MnsStatus belt_faces_judge(MnsSim *sim, size_t k, const BeltTouch touches[], MnsError *error)
{
    const size_t first = sim->s.begin[GROUP_WALL];
    const Asked asked = ask(sim, k);
    BeltFace faces[BELT_FACES_MAX];
    size_t n = 0, touched = 0;
    double most = 0;
    if (!(asked.most > 0)) return MNS_OK;
    for (size_t b = 0, i = first; i < sim->s.n; i++) {
        const size_t wall = sim->s.phase[i] - sim->model.n_phases;
        if (!sim->model.wall[wall].has_belt) continue;
        const BeltTouch *touch = &touches[b];
        double left, lost;
        const double *along = sim->belts.along[b++];
        if (wall != k || !touch->room) continue;
        touched++;
        compare(along, &asked, &left, &lost);
        most = fmax(most, left);
        if (touch->n == 1 && lost > LOSS_MAX) count_face(sim, k, i, touch, lost, faces, &n);
    }
    char at[64];
    snprintf(at, sizeof at, "walls[%zu].surface_velocity", k);
    if (touched > 0 && most <= NONE)
        return mns_fail_at(error, MNS_E_INVALID, at,
                           "at no point of %.60s is any of it along the surface, and what is across it cannot act, as "
                           "it would pump fluid through the wall: give a velocity along a face, or a `motion`",
                           sim->c->walls[k].name);
    if (!sim->model.wall[k].no_slip)
        plan_warn(sim, "%s: nothing is moved by it, as fluids glide along %.60s; write slip: none", at,
                  sim->c->walls[k].name);
    warn_faces(sim, k, faces, n);
    return MNS_OK;
}
