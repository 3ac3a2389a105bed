/* SPDX-License-Identifier: BSD-3-Clause */
/* Velocities continued into walls, as points for differences. A wall particle w at the depth d below its surface, of normal n, with y the
 * height of a fluid particle above the tangent plane there:
 *   what the wall holds    u_w = u_0 - d g,  g = sum_f W (u_f - u_0) y / sum_f W y^2     all of u without slip, with slip u . n
 *   what glides            u_w = sum_f W u_f / sum_f W
 *   in the divergence      u_w = u_0                                                     in place of the first, without slip
 * As u = g(x) y makes v = -g' y^2/2 beside what it sticks to, the velocity towards the wall is even in y and not odd: continued as the first line has it, its
 * divergence would not be 0 (a lid's cavity is 5 % off by that). The first is exact for all linear fields that keep u_0 on the surface; a mean mirrored at it is not, as it is that of fluid nearer to the
 * surface the deeper the particle is (schemes/differences.md). */
#include "sim/terms/differences.h"
#include "sim/terms/terms.h"

/* Which velocities are continued: those of the fluid, or those that the projection sees, without the step's body forces and with its share of the walls'.
 * To these a belt is a wall along which they glide: it neither pushes nor holds what the divergence is of. */
typedef enum Moves { MOVES_AS_IT_IS, MOVES_UNFORCED } Moves;

INLINE void continue_velocity(const Row *row, Particles *s, const Model *model, Moves moves, How how)
{
    const size_t i = row->i, wall = i - particles_fluid(s);
    const WallState *body = &model->wall[s->phase[i] - model->n_phases];
    const bool unforced = moves == MOVES_UNFORCED, settles = body->no_slip && unforced,
               sticks = body->no_slip && !(settles && body->has_belt);
    const double dt = unforced ? model->dt : 0, share = unforced ? model->differences.share : 1;
    double n[3], u_0[3], depth2 = 0;
    for (int d = 0; d < how.dim; d++) {
        u_0[d] = unforced ? share * s->v[d][i * s->v_step] : particles_surface_velocity(s, d, i);
        n[d] = s->to_surface[d][wall];
        depth2 += n[d] * n[d];
    }
    const Mixture density = mixture_of_densities(model);
    Lanes weight = {0}, sum[3] = {0}, height2 = {0}, rise[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++) {
        double colour[LANES], its[3][LANES];
        gather(s->colour, row_j(row, b), colour);
        gather_velocities(row, b, s, how, its);
        if (dt > 0 && are_images(row, b)) add_body_force(row, b, s, model, 2 * dt, how, its);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double W = b->W[l], rho = mixed(density, colour[l]);
            double y = -depth2; /* times the depth */
            for (int d = 0; d < how.dim; d++) y -= n[d] * b->x[d][l];
            weight.of[l] += W;
            height2.of[l] += W * y * y;
            for (int d = 0; d < how.dim; d++) {
                const double u = its[d][l] - dt * body_force_of(model, rho, d) - u_0[d];
                sum[d].of[l] += W * u;
                rise[d].of[l] += W * y * u;
            }
        }
    }
    const double all = lanes_sum(&weight), square = lanes_sum(&height2);
    double held[3] = {0}, glides[3] = {0}, along = 0;
    for (int d = 0; d < how.dim && all > 0 && square > 0; d++) {
        held[d] = settles ? 0 : -depth2 * lanes_sum(&rise[d]) / square;
        glides[d] = lanes_sum(&sum[d]) / all;
    }
    for (int d = 0; d < how.dim; d++) along += depth2 > 0 ? (held[d] - glides[d]) * n[d] / depth2 : 0;
    for (int d = 0; d < how.dim; d++) {
        const double u = sticks ? held[d] : glides[d] + along * n[d];
        s->v_wall[d][wall] = u_0[d] + u + dt * body_force_of(model, mixed(density, s->colour[i]), d);
    }
}

INLINE void continued_velocity_row(const Row *row, Particles *s, const Model *model, How how)
{
    continue_velocity(row, s, model, MOVES_AS_IT_IS, how);
}
ROW_FUNCTIONS(continued_velocity_row)

INLINE void continued_start_row(const Row *row, Particles *s, const Model *model, How how)
{
    continue_velocity(row, s, model, MOVES_UNFORCED, how);
}
ROW_FUNCTIONS(continued_start_row)

const Term continued_velocity = {
    .name = "continued velocity",
    .source = "schemes/differences.md",
    .equation = "u_w = u_0 - d sum_f W (u_f - u_0) y / sum_f W y^2;  what glides, sum_f W u_f / sum_f W",
    .on = ON_WALL,
    .needs = NEED_W | NEED_V,
    .row = ROW_TABLE(continued_velocity_row),
};

const Term continued_start = {
    .name = "continued velocity",
    .source = "schemes/differences.md",
    .equation = "the same of u - dt b, and dt b, which the pressure of the wall balances",
    .on = ON_WALL,
    .needs = NEED_W | NEED_V,
    .row = ROW_TABLE(continued_start_row),
};
