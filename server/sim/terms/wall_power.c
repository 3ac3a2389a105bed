/* SPDX-License-Identifier: BSD-3-Clause */
/* What walls do to the fluid beside them: the power of the forces that a scheme has between a particle and a wall.
 *   power_i += sum_w f_iw . v_w,   f_iw the pair's force on i as the scheme's terms have it
 * Pressures act along the normal, so that a surface that moves along itself does no work by them: v_w is there that of the wall alone. */
#include "sim/terms/wall_power.h"
#include "sim/solve/solve.h"
#include "sim/terms/gas.h"
#include "sim/terms/push.h"
#include "sim/terms/riemann.h"
#include "sim/terms/terms.h"
#include "sim/terms/viscosity.h"

INLINE void pressure_power(const Row *row, Particles *s, const Model *model, How how, Weights weights)
{
    const Pushed a = pushed_of(s, model, row->i);
    const WallPressure shown = wall_pressure_of(s, row->i);
    const double lift = weights == WEIGHTS_PRODUCT ? gas_lift(model, s->phase[row->i], &a) : 0;
    Lanes power = {0};
    for (const Block *b = row->block + row->n_fluid; b < row->block + row->n; b++) {
        const uint32_t *j = row_j(row, b);
        Lanes force[3] = {0};
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            pressure_wall(&a, &pair, shown_by(&shown, j[l]), how, l, force, weights);
            gas_wall(&a, lift, &pair, how, l, force);
        }
        add_wall_power(force, row, b, s, model, how, &power);
    }
    s->power[row->i] -= lanes_sum(&power);
}

INLINE void product_power_row(const Row *row, Particles *s, const Model *model, How how)
{
    pressure_power(row, s, model, how, WEIGHTS_PRODUCT);
}
ROW_FUNCTIONS(product_power_row)

INLINE void squares_power_row(const Row *row, Particles *s, const Model *model, How how)
{
    pressure_power(row, s, model, how, WEIGHTS_SQUARES);
}
ROW_FUNCTIONS(squares_power_row)

/* P5's differences of pressures have no share of a wall: what it pushes with is the pressure on its surface, by the sum that has both. */
INLINE void surface_power_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const double V = particles_volume(s, model, i), *P = s->system->x;
    Lanes power = {0};
    for (const Block *b = row->block + row->n_fluid; b < row->block + row->n && model->dt > 0; b++) {
        const uint32_t *j = row_j(row, b);
        Lanes force[3] = {0};
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            add_along(&pair, V * model->cell_volume * (P[i] + P[j[l]]) * pair.F, how, l, force);
        }
        add_wall_power(force, row, b, s, model, how, &power);
    }
    if (model->dt > 0) s->power[i] -= lanes_sum(&power) / model->dt;
}
ROW_FUNCTIONS(surface_power_row)

INLINE void riemann_power_row(const Row *row, Particles *s, const Model *model, How how)
{
    const Side a = side_of(s, model, row->i, how);
    Lanes power = {0};
    for (const Block *b = row->block + row->n_fluid; b < row->block + row->n; b++) {
        const uint32_t *j = row_j(row, b);
        Lanes force[3] = {0};
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            riemann_momentum_wall(&a, &pair, side_wall_pressure(&a, j[l]), how, l, force);
        }
        add_wall_power(force, row, b, s, model, how, &power);
    }
    s->power[row->i] -= 2 * lanes_sum(&power);
}
ROW_FUNCTIONS(riemann_power_row)

/* radial: the viscosity acts along the line of the pair. */
INLINE void work_of_friction(const Row *row, Particles *s, const Model *model, How how, bool radial)
{
    const size_t i = row->i;
    const unsigned mine = s->phase[i];
    const double mu = radial ? radial_viscosity_of(model, mine, mine) : wall_viscosity_of(model, mine),
                 soft = viscosity_softening(&model->kernel), V = particles_volume(s, model, i);
    double v[3];
    Lanes power = {0};
    if (mu == 0) return;
    for (int d = 0; d < how.dim; d++) v[d] = s->v[d][i * s->v_step];
    for (const Block *b = row->block + row->n_fluid; b < row->block + row->n; b++) {
        Sticking wall;
        Lanes force[3] = {0};
        sticking_of_block(row, b, s, model, mu, how, &wall);
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            if (radial) radial_friction_pair(v, V, &pair, &wall, how, l, force);
            else friction_pair(v, V, &pair, &wall, soft, how, l, force);
        }
        add_surface_power(force, s, row, b, how, &power);
    }
    s->power[i] += lanes_sum(&power);
}

INLINE void friction_power_row(const Row *row, Particles *s, const Model *model, How how)
{
    work_of_friction(row, s, model, how, false);
}
ROW_FUNCTIONS(friction_power_row)

INLINE void radial_friction_power_row(const Row *row, Particles *s, const Model *model, How how)
{
    work_of_friction(row, s, model, how, true);
}
ROW_FUNCTIONS(radial_friction_power_row)

NORMAL_POWER(product_power, "power of walls", "P1 eq. 9", "sum_w f_iw . v_w, f of the pressure force", plain_gradients,
             NEED_F | NEED_STATE);
NORMAL_POWER(squares_power, "power of walls", "P2 eq. 24", "sum_w f_iw . v_w, f of the pressure force", plain_gradients,
             NEED_F | NEED_STATE);
NORMAL_POWER(surface_power, "power of walls", "schemes/differences.md", "-sum_w V_i V_w (p_i + p_w) grad_i W . v_w",
             NULL, NEED_F);
NORMAL_POWER(riemann_power, "power of walls", "P3 eq. 9", "sum_w f_iw . v_w, f of the Riemann momentum", NULL,
             NEED_F | NEED_STATE);
SURFACE_POWER(friction_power, "power of friction", "P1 eq. 10", "sum_w f_iw . v_w, f of the wall friction",
              is_viscous_between, NEED_F | NEED_V | NEED_STATE);
SURFACE_POWER(radial_friction_power, "power of friction", "P2 eq. 25, without 1/r^2",
              "sum_w f_iw . v_w, f of the wall friction", is_viscous_along, NEED_F | NEED_V | NEED_STATE);
