/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/displacement.h"
#include <math.h>
#include <omp.h>
#include <string.h>

static const char *const ENTRY = "domain.displacement";

MnsStatus displacement_init(Displacement *displacement, const MnsSim *sim, const Constants *constants, MnsError *error)
{
    static const char *const xyz[] = {"x", "y", "z", NULL};
    MnsStatus status = MNS_OK;
    for (int d = 0; d < sim->c->dim && !status; d++) {
        const char *text = sim->c->displacement[d];
        displacement->moves = displacement->moves || strcmp(text, "0") != 0;
        status = formula_team_init(&displacement->by[d], sim->threads, text, xyz, constants->list, constants->n, error);
    }
    for (size_t k = 0; k < sim->c->n_fluids && !status && displacement->moves; k++)
        if (strcmp(sim->c->fluids[k].pressure, "laplace") == 0)
            return mns_fail_at(
                error, MNS_E_INVALID, ENTRY,
                "moves %.60s, whose pressure is that of a drop on the lattice as it is (laplace): give it a "
                "formula, or move nothing",
                sim->c->fluids[k].name);
    return status;
}

void displacement_done(Displacement *displacement)
{
    for (int d = 0; d < 3; d++) formula_team_done(&displacement->by[d]);
}

static void move(const Displacement *displacement, int dim, const double x[3], double ret[3])
{
    const int me = omp_get_thread_num();
    for (int d = 0; d < dim; d++) ret[d] = x[d] + formula_eval(formula_of(&displacement->by[d], me), x);
}

static const char *failure(const Displacement *displacement, int dim)
{
    const char *why = NULL;
    for (int d = 0; d < dim && !why; d++) why = formula_failure(formula_of(&displacement->by[d], omp_get_thread_num()));
    return why;
}

/* From differences over a thousandth of a spacing to both sides; a volume grows as the determinant says. */
static Stretch stretch_at(const Displacement *displacement, const Model *model, const double x[3])
{
    double of[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double step = 1e-3 * model->dx;
    for (int e = 0; e < model->dim; e++) {
        double there[3] = {x[0], x[1], x[2]}, above[3], below[3];
        there[e] = x[e] + step;
        move(displacement, model->dim, there, above);
        there[e] = x[e] - step;
        move(displacement, model->dim, there, below);
        for (int d = 0; d < model->dim; d++) of[d][e] = (above[d] - below[d]) / (2 * step);
    }
    return (Stretch){of[0][0] * (of[1][1] * of[2][2] - of[1][2] * of[2][1]) -
                         of[0][1] * (of[1][0] * of[2][2] - of[1][2] * of[2][0]) +
                         of[0][2] * (of[1][0] * of[2][1] - of[1][1] * of[2][0]),
                     {of[0][0], of[1][1], of[2][2]}};
}

static MnsStatus fail(const double x[3], const double to[3], const char *what, MnsError *error)
{
    return mns_fail_at(error, MNS_E_INVALID, ENTRY, "moves the particle at (%g, %g, %g) m to (%g, %g, %g) m, %s", x[0],
                       x[1], x[2], to[0], to[1], to[2], what);
}

static MnsStatus check_place(const MnsSim *sim, const double x[3], const double to[3], MnsError *error)
{
    const MnsCase *c = sim->c;
    for (int d = 0; d < c->dim; d++)
        if (!c->periodic[d] && (to[d] < c->min[d] || to[d] > c->max[d])) return fail(x, to, "out of the domain", error);
    for (size_t k = 0; k < c->n_walls; k++)
        if (shape_distance(&sim->solid[k], to) < 0) return fail(x, to, "into a wall", error);
    return MNS_OK;
}

MnsStatus displacement_apply(const Displacement *displacement, const MnsSim *sim, double x[3], Stretch *stretch,
                             MnsError *error)
{
    double to[3] = {0};
    *stretch = (Stretch){1, {1, 1, 1}};
    if (!displacement->moves) return MNS_OK;
    move(displacement, sim->c->dim, x, to);
    *stretch = stretch_at(displacement, &sim->model, x);
    const char *why = failure(displacement, sim->c->dim);
    if (why) return mns_fail_at(error, MNS_E_INVALID, ENTRY, "fails at (%g, %g, %g) m: %s", x[0], x[1], x[2], why);
    if (!(stretch->volume > 0.5 && stretch->volume < 2)) /* or no number */
        return mns_fail_at(error, MNS_E_INVALID, ENTRY,
                           "makes a particle's volume %g times what it is, at (%g, %g, %g) m: allowed (0.5, 2)",
                           stretch->volume, x[0], x[1], x[2]);
    for (int d = 0; d < sim->c->dim; d++) {
        const double period = sim->c->max[d] - sim->c->min[d];
        if (sim->c->periodic[d]) to[d] -= period * floor((to[d] - sim->c->min[d]) / period);
    }
    const MnsStatus status = check_place(sim, x, to, error);
    for (int d = 0; d < sim->c->dim; d++) x[d] = to[d];
    return status;
}
