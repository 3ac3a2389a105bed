/* SPDX-License-Identifier: BSD-3-Clause */
/* Which planes mirror the fluid. */
#include "sim/mirror_planes.h"
#include "sim/motion.h"
#include "sim/solid.h"
#include <math.h>

/* Of a spacing: how near to a border between cells of the lattice the surface of a wall has to be. */
static const double FLUSH = 1e-3;

/* Does a wall move along d? */
static bool moves(const MnsMotion *motion, int d)
{
    if (motion->kind == MNS_STILL) return false;
    if (motion->kind != MNS_TABLE) return motion->amplitude[d] != 0;
    for (size_t k = 0; k < motion->n; k++)
        if (motion->points[k].x[d] != motion->points[0].x[d] || motion->points[k].v[d] != 0) return true;
    return false;
}

static bool slips(const MnsSim *sim, size_t wall)
{
    return !sim->model.wall[wall].no_slip && !sim->model.wall[wall].has_belt;
}

/* Times at which a wall is looked at, for all places that it comes to. */
static size_t count_times(const MnsMotion *motion)
{
    return motion->kind == MNS_STILL ? 1 : motion->kind == MNS_TABLE ? 257 : 33;
}

/* Time k of these: from the first to the last of a table, or of a period. */
static double time_of(const MnsMotion *motion, size_t k)
{
    if (motion->kind == MNS_STILL) return 0;
    const double part = (double)k / (double)(count_times(motion) - 1);
    if (motion->kind != MNS_TABLE) return motion->frequency > 0 ? part / motion->frequency : 0;
    return motion->points[0].t + part * (motion->points[motion->n - 1].t - motion->points[0].t);
}

/* Is a place inside of a wall at all times? */
static bool always_covers(const MnsSim *sim, size_t wall, const double x[3])
{
    const MnsMotion *motion = &sim->c->walls[wall].motion;
    for (size_t k = 0; k < count_times(motion); k++) {
        double moved[3], v[3], a[3], then[3];
        motion_at(motion, time_of(motion, k), moved, v, a);
        for (int d = 0; d < 3; d++) then[d] = x[d] - moved[d];
        if (!(shape_distance(&sim->solid[wall], then) < 0)) return false;
    }
    return true;
}

/* Is a place behind a plane across d always inside of a wall along which fluid slips, and of none that is no mirror? What moves along the plane and
 * stands out before it goes on behind it as its image does. */
static bool is_backed(const MnsSim *sim, int d, const double before[3], const double behind[3])
{
    bool any = false;
    for (size_t k = 0; k < sim->model.n_walls; k++) {
        const MnsMotion *motion = &sim->c->walls[k].motion;
        if (!(shape_distance(&sim->solid[k], behind) < 0)) continue;
        if (moves(motion, d)) return false;
        if (slips(sim, k) && always_covers(sim, k, behind)) any = true;
        else if (motion->kind == MNS_STILL || !(shape_distance(&sim->solid[k], before) < 0)) return false;
    }
    return any;
}

/* Is a place always inside of a wall that does not move along d? */
static bool is_solid(const MnsSim *sim, int d, const double x[3])
{
    for (size_t k = 0; k < sim->model.n_walls; k++)
        if (!moves(&sim->c->walls[k].motion, d) && always_covers(sim, k, x)) return true;
    return false;
}

/* Cells of the lattice along each direction of the domain. */
static void count_cells(const Model *model, size_t n[3])
{
    for (int d = 0; d < 3; d++)
        n[d] = d < model->dim ? (size_t)lround((model->max[d] - model->min[d]) / model->cell[d]) : 1;
}

/* The middle of cell k of n of a layer across direction d, at a coordinate along it. */
static void place_in_layer(const Model *model, const size_t n[3], int d, size_t k, double at, double x[3])
{
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    const size_t of[2] = {k % n[e], k / n[e]};
    x[d] = at;
    x[e] = e < model->dim ? model->min[e] + ((double)of[0] + 0.5) * model->cell[e] : 0;
    x[f] = f < model->dim ? model->min[f] + ((double)of[1] + 0.5) * model->cell[f] : 0;
}

/* Is a layer of the lattice nothing but walls, always? */
static bool is_solid_layer(const MnsSim *sim, const size_t n[3], int d, double at)
{
    const size_t cells = n[0] * n[1] * n[2] / n[d];
    for (size_t k = 0; k < cells; k++) {
        double x[3];
        place_in_layer(&sim->model, n, d, k, at, x);
        if (!is_solid(sim, d, x)) return false;
    }
    return true;
}

/* The side of the domain, or further in if there is nothing but walls before that. */
void mirror_planes_place(MnsSim *sim)
{
    Model *model = &sim->model;
    size_t n[3];
    count_cells(model, n);
    for (int side = 0; side < 2 * model->dim; side++) {
        const int d = side / 2;
        const double first = side % 2 ? model->max[d] : model->min[d],
                     cell = side % 2 ? -model->cell[d] : model->cell[d];
        size_t k = 0;
        while (k < n[d] && is_solid_layer(sim, n, d, first + ((double)k + 0.5) * cell)) k++;
        model->mirror_at[side] = k < n[d] ? first + (double)k * cell : first;
    }
}

/* By what lies just behind each cell of the lattice that is beside it, unless a wall is in it that goes on behind; and somewhere there is room before it. */
static bool is_mirror(const MnsSim *sim, int side)
{
    const Model *model = &sim->model;
    const int d = side / 2;
    const double at = model->mirror_at[side], behind = (side % 2 ? 1 : -1) * FLUSH * model->dx;
    size_t n[3], nearest;
    bool open = false;
    if (model->period[d] > 0) return false;
    count_cells(model, n);
    const size_t cells = n[0] * n[1] * n[2] / n[d];
    for (size_t k = 0; k < cells; k++) {
        double before[3], beyond[3];
        place_in_layer(model, n, d, k, at - behind, before);
        place_in_layer(model, n, d, k, at + behind, beyond);
        open = open || !(solid_distance(sim, before, &nearest) < 0);
        if (!is_solid(sim, d, before) && !is_backed(sim, d, before, beyond)) return false;
    }
    return open;
}

/* Has gravity no part along d, ever? */
static bool is_weightless(const Formula *gravity)
{
    const double t = 0;
    return formula_is_constant(gravity) && formula_eval(gravity, &t) == 0;
}

static bool any_slips(const MnsSim *sim)
{
    for (size_t k = 0; k < sim->model.n_walls; k++)
        if (slips(sim, k)) return true;
    return false;
}

/* Does a row have room for all listed neighbours on a lattice and a tenth denser, where these mirrors meet: fluid, images of the rest of the ball, and
 * the wall particles that these stand for? */
static bool have_room_in_corners(const Model *model, unsigned mirrors)
{
    const double reach = model->kernel.support + model->skin, pi = acos(-1),
                 ball = model->dim == 2 ? pi * reach * reach : 4 * pi / 3 * reach * reach * reach;
    double fluid = 1;
    for (int d = 0; d < model->dim; d++) fluid *= mirrors >> 2 * d & 3 ? 0.5 : 1;
    return 1.1 * (2 - fluid) * ball / model->cell_volume <= ROW_MAX;
}

unsigned mirror_planes_find(const MnsSim *sim, Formula *const gravity[3])
{
    const Model *model = &sim->model;
    unsigned mirrors = 0;
    for (int side = 0; side < 2 * model->dim && any_slips(sim); side++)
        if ((sim->scheme->floors_mirror || is_weightless(gravity[side / 2])) && is_mirror(sim, side))
            mirrors |= 1u << side;
    for (int side = 0; side < 2 * model->dim; side += 2)
        if ((mirrors >> side & 3) == 3 && model->mirror_at[side + 1] - model->mirror_at[side] < model->kernel.support)
            mirrors &= ~(3u << side);
    return have_room_in_corners(model, mirrors) ? mirrors : 0;
}

bool mirror_planes_have(const Model *model, const Face *face)
{
    if (!model->mirrors) return false;
    for (int d = 0; d < model->dim; d++) {
        const int side = face->normal[d] > 0 ? 2 * d : 2 * d + 1;
        const double at = face->point[d] + model->wall[face->wall].x[d];
        if (!(model->mirrors >> side & 1) || !(fabs(face->normal[d]) > 1 - 1e-9)) continue;
        if (fabs(model_before_mirror(model, side, at)) < FLUSH * model->dx) return true;
    }
    return false;
}

/* Is there an acceleration across a face, by gravity or by how its wall moves? */
static bool is_pushed(const MnsSim *sim, const Face *face)
{
    const MnsMotion *motion = &sim->c->walls[face->wall].motion;
    double across = 0, size = 0;
    for (int d = 0; d < sim->model.dim; d++) {
        const double n = face->normal[d], t = 0;
        if (!(fabs(n) > 1e-9)) continue;
        if (moves(motion, d) || !formula_is_constant(sim->gravity[d])) return true;
        across += n * formula_eval(sim->gravity[d], &t);
        size += fabs(n * formula_eval(sim->gravity[d], &t));
    }
    return fabs(across) > 1e-9 * size;
}

/* Does a face mirror nothing, but stand as a plane of symmetry does? */
static bool may_be_taken_for_one(const MnsSim *sim, const Face *face)
{
    const WallState *wall = &sim->model.wall[face->wall];
    return !wall->no_slip && !wall->has_belt && !mirror_planes_have(&sim->model, face) &&
           (sim->scheme->floors_mirror || !is_pushed(sim, face));
}

/* Is there more than one fluid beside a face? */
static bool is_met(const MnsSim *sim, const Face *face)
{
    const Particles *s = &sim->s;
    const WallState *wall = &sim->model.wall[face->wall];
    const double near = 1.5 * sim->model.dx;
    unsigned fluids = 0;
#pragma omp parallel for schedule(static) reduction(| : fluids) num_threads(sim->threads)
    for (size_t i = 0; i < particles_fluid(s); i++) {
        double then[3] = {0, 0, 0}, away = 0; /* where the case puts the wall */
        for (int d = 0; d < s->dim; d++) {
            then[d] = s->x[d][i * s->x_step] - wall->x[d];
            away += face->normal[d] * (then[d] - face->point[d]);
        }
        if (away > 0 && away < near && shape_distance(&sim->solid[face->wall], then) < near)
            fluids |= 1u << s->phase[i];
    }
    return fluids & (fluids - 1);
}

void mirror_planes_look(MnsSim *sim)
{
    for (size_t q = 0; sim->model.n_phases > 1 && q < sim->model.n_faces && !sim->told.cut; q++) {
        const Face *face = &sim->face[q];
        if (!may_be_taken_for_one(sim, face) || !is_met(sim, face)) continue;
        sim->told.cut = true;
        plan_tell(
            sim,
            "walls[%zu].slip: an interface meets the face of %.60s around (%.4g, %.4g, %.4g) m, which is no plane "
            "of symmetry: speeds may be 12 %% off, and more. One is a face that moves along itself at most and "
            "covers a side of the domain, or all that is open of a border between cells of the lattice, at all "
            "times: end the domain there",
            face->wall, sim->c->walls[face->wall].name, face->point[0], face->point[1], face->point[2]);
    }
}
