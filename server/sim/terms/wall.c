/* SPDX-License-Identifier: BSD-3-Clause */
/* What a wall's dummy particles show to the fluid, extrapolated from the fluid around them.            P3 eq. 14, Adami 2012
 *   p_b   = [ sum_f w p_f + (g - a_w) . sum_f w rho_f (x_w - x_f) ] / s_b,   s_b = sum_f w,   w = W V_f,   f of fluid b only
 *   p_w^a = sum_b q_ab (p_b + J_ab) / sum_b q_ab,   q_ab = s_b^4 min(1, rho_a/rho_b)
 * A wall particle is of the fluid it has most of, as one in the midst of fluids is of one: what rises or spreads along a wall feels the
 * fluid ahead of it. If each fluid is shown its own p_a, nothing there tells it that the other is heavier or at rest, and it is held
 * back. What a heavy fluid shows a light one counts for as much less as it would move it more: one pressure for both shoots air away
 * where it meets water at a wall (schemes/README.md). Across an interface with tension another fluid's pressure counts as it is
 * seen from here, J_ab = s_ab kappa_a - s_ba kappa_b of the curvatures that are near (jump.h): without it the lower pressure of what is outside would
 * draw a drop out along the wall. */
#include "sim/terms/terms.h"
#include <math.h>

INLINE unsigned phases_in(const Row *row, const Particles *s)
{
    unsigned present = 0;
    for (const Block *b = row->block; b < row->block + row->n; b++)
        for (int l = 0; l < LANES; l++) present |= 1u << s->phase[row_j(row, b)[l]];
    return present;
}

/* Sums over the pairs of one fluid: W V_f, W V_f p_f, W V_f rho_f (x_w - x_f). */
typedef struct Shown {
    double weight, pressure, along[3];
} Shown;

INLINE Shown weigh(const Row *row, const Particles *s, unsigned fluid, How how)
{
    Lanes weight = {0}, pressure = {0}, along[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++) {
        const uint32_t *j = row_j(row, b);
        double one[LANES], rho[LANES];
        for (int l = 0; l < LANES; l++) {
            one[l] = s->phase[j[l]] == fluid ? 1 : 0;
            rho[l] = s->rho[j[l]];
        }
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double w = one[l] * (b->W[l] * b->V[l]);
            weight.of[l] += w;
            add_product(&pressure, l, w, b->p[l], how);
            for (int d = 0; d < how.dim; d++) add_product(&along[d], l, w * rho[l], b->x[d][l], how);
        }
    }
    Shown shown = {lanes_sum(&weight), lanes_sum(&pressure), {0}};
    for (int d = 0; d < how.dim; d++) shown.along[d] = lanes_sum(&along[d]);
    return shown;
}

/* One fluid as a wall particle has it. */
typedef struct Near {
    double share, p, curvature; /* s^4, 0 where it is not; of its interface, 0 if that is out of reach */
} Near;

INLINE double fourth_power(double s)
{
    return s * s * (s * s);
}

/* The mean curvature of those of a fluid that have an interface in reach. */
INLINE double curvature_near(const Row *row, const Particles *s, unsigned fluid)
{
    double weight = 0, sum = 0;
    for (const Block *b = row->block; b < row->block + row->n; b++) {
        const uint32_t *j = row_j(row, b);
        for (int l = 0; l < LANES; l++) {
            const double kappa = s->curvature[j[l]];
            const double w = s->phase[j[l]] == fluid && kappa != 0 ? b->W[l] * b->V[l] : 0;
            weight += w;
            sum += w * kappa;
        }
    }
    return weight > 0 ? sum / weight : 0;
}

/* Of a wall particle that has two fluids or more; there are few. */
INLINE void find_curvatures(const Row *row, const Particles *s, const Model *model, Near near[])
{
    unsigned n = 0;
    for (unsigned a = 0; a < model->n_phases; a++) n += near[a].share > 0;
    for (unsigned a = 0; a < model->n_phases && n > 1 && model->tense; a++)
        near[a].curvature = curvature_near(row, s, a);
}

/* What another fluid bears may be no pressure of this one: where a density is made of what is shown, it has none or less. */
INLINE double bearable(const Phase *phase, const Model *model, double p)
{
    if (phase->exponent != 1) return p;
    const double unit = phase->rho0 * phase->c * phase->c;
    return fmin(fmax(p, (model->density_min - 1) * unit), (model->density_max - 1) * unit);
}

/* p_a - p_b at rest. A fluid none of which has the interface in reach here takes its curvature from the other one. */
INLINE double jump_between(unsigned a, unsigned b, const Near near[], const Model *model)
{
    const double k_a = near[a].curvature, k_b = near[b].curvature;
    return model->tension_share[a][b] * (k_a != 0 ? k_a : -k_b) - model->tension_share[b][a] * (k_b != 0 ? k_b : -k_a);
}

/* What a fluid's own pressure differs by from that of all as it sees them across their interfaces. */
INLINE double departure_of(unsigned a, const Near near[], const Model *model)
{
    double shares = 0, departure = 0;
    for (unsigned b = 0; b < model->n_phases; b++) {
        const double ratio = model->phase[a].rho0 / model->phase[b].rho0;
        const double share = ratio < 1 ? near[b].share * ratio : near[b].share;
        shares += share;
        departure += share * (near[b].p + jump_between(a, b, near, model) - near[a].p);
    }
    return shares > 0 ? departure / shares : 0;
}

/* The same of one pressure for all, by what the wall has of each: of two fluids the difference is their jump, whatever their densities. */
INLINE double jump_of_wall(unsigned a, const Near near[], const Model *model)
{
    double shares = 0, jump = 0;
    for (unsigned b = 0; b < model->n_phases; b++) {
        shares += near[b].share;
        jump += near[b].share * jump_between(a, b, near, model);
    }
    return shares > 0 ? jump / shares : 0;
}

INLINE void wall_pressure_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i, wall = i - particles_fluid(s);
    const WallState *body = &model->wall[s->phase[i] - model->n_phases];
    const unsigned present = phases_in(row, s);
    Near near[MNS_MAX_FLUIDS] = {0};
    double all_weight = 0, all_pressure = 0;
    for (unsigned a = 0; a < model->n_phases; a++) {
        if (!(present & 1u << a)) continue;
        Shown shown = weigh(row, s, a, how);
        for (int d = 0; d < how.dim; d++) shown.pressure += (model->gravity[d] - body->a[d]) * shown.along[d];
        all_weight += shown.weight;
        all_pressure += shown.pressure;
        if (!(shown.weight > NOTHING_NEAR)) continue;
        near[a] = (Near){.share = fourth_power(shown.weight), .p = shown.pressure / shown.weight};
    }
    find_curvatures(row, s, model, near);
    for (unsigned a = 0; a < model->n_phases; a++)
        s->p_wall[a][wall] = bearable(&model->phase[a], model, near[a].p + departure_of(a, near, model));
    s->p[i * s->p_step] = all_weight > NOTHING_NEAR ? all_pressure / all_weight : 0; /* for pictures */
}
ROW_FUNCTIONS(wall_pressure_row)

/* Where a wall has one pressure for all fluids: what that lacks as each sees it. */
INLINE void wall_jump_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)how;
    const size_t wall = row->i - particles_fluid(s);
    Near near[MNS_MAX_FLUIDS] = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
        for (int l = 0; l < LANES; l++) near[s->phase[row_j(row, b)[l]]].share += b->W[l] * b->V[l];
    for (unsigned a = 0; a < model->n_phases; a++) near[a].share = fourth_power(near[a].share);
    find_curvatures(row, s, model, near);
    for (unsigned a = 0; a < model->n_phases; a++) s->p_wall[a][wall] = jump_of_wall(a, near, model);
}
ROW_FUNCTIONS(wall_jump_row)

/* What is shared by several fluids has a density between, by the fourth powers of what each has of the kernel. */
INLINE void wall_density_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)how;
    double near[MNS_MAX_FLUIDS] = {0}, shares = 0, sum = 0;
    for (const Block *b = row->block; b < row->block + row->n; b++) {
        const uint32_t *j = row_j(row, b);
        for (int l = 0; l < LANES; l++) near[s->phase[j[l]]] += b->W[l];
    }
    for (unsigned a = 0; a < model->n_phases; a++) {
        const double share = near[a] * near[a] * (near[a] * near[a]);
        shares += share;
        sum += share * model->phase[a].rho0;
    }
    s->rho[row->i] = shares > 0 ? sum / shares : model->rho_min;
}
ROW_FUNCTIONS(wall_density_row)

INLINE void wall_velocity_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)model;
    const size_t wall = row->i - particles_fluid(s);
    Lanes weight = {0}, sum[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double w = b->W[l] * b->V[l];
            weight.of[l] += w;
            for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, w, b->v[d][l], how);
        }
    const double all = lanes_sum(&weight);
    for (int d = 0; d < how.dim; d++) {
        const double v = particles_surface_velocity(s, d, row->i);
        s->v_wall[d][wall] = all > NOTHING_NEAR ? 2 * v - lanes_sum(&sum[d]) / all : v;
    }
}
ROW_FUNCTIONS(wall_velocity_row)

/* What a wall shows: along its surface the fluid's velocity, or that turned round; along the normal, from sum_f grad_w W V_f, turned round or none. */
typedef enum Shows { TURNED_ROUND, GLIDING, GLIDING_ALONE } Shows;

INLINE void mirror(const Row *row, Particles *s, const double about[3], Shows shows, How how)
{
    const size_t i = row->i, wall = i - particles_fluid(s);
    Lanes weight = {0}, sum[3] = {0}, towards[3] = {0};
    for (const Block *b = row->block; b < row->block + row->n; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double w = pair.W * pair.V, f = pair.F * pair.V;
            weight.of[l] += w;
            for (int d = 0; d < how.dim; d++) {
                add_product(&sum[d], l, w, pair.v[d], how);
                add_product(&towards[d], l, f, pair.x[d], how);
            }
        }
    const double all = lanes_sum(&weight);
    double v[3], n[3], n2 = 0, into = 0;
    for (int d = 0; d < how.dim; d++) {
        v[d] = all > NOTHING_NEAR ? lanes_sum(&sum[d]) / all : about[d];
        n[d] = lanes_sum(&towards[d]);
        n2 += n[d] * n[d];
    }
    for (int d = 0; d < how.dim; d++) into += n2 > 0 ? (about[d] - v[d]) * n[d] / n2 : 0;
    const double times = shows == GLIDING ? 2 : 1;
    for (int d = 0; d < how.dim; d++)
        s->v_wall[d][wall] = shows == TURNED_ROUND ? 2 * about[d] - v[d] : v[d] + times * into * n[d];
}

INLINE void mirrored_velocity_row(const Row *row, Particles *s, const Model *model, How how)
{
    double v[3] = {0};
    for (int d = 0; d < how.dim; d++) v[d] = particles_surface_velocity(s, d, row->i);
    mirror(row, s, v, model->wall[s->phase[row->i] - model->n_phases].no_slip ? TURNED_ROUND : GLIDING, how);
}
ROW_FUNCTIONS(mirrored_velocity_row)

/* Of a fluid that a wall has not yet pushed: what it has gained on it within the step, a flow at rest on the wall has not. Where fluid sticks, what comes
 * nearer to the wall goes with the square of the distance, as u = g(x) y makes v = -g' y^2/2: that is even, and turned round its divergence would not be 0
 * (a lid's cavity is 5 % off by that); the wall's own velocity stands for it. A belt neither pushes nor holds what the divergence is of: the fluid's own
 * velocity goes on along it. */
INLINE void mirrored_start_row(const Row *row, Particles *s, const Model *model, How how)
{
    const WallState *body = &model->wall[s->phase[row->i] - model->n_phases];
    double v[3] = {0};
    for (int d = 0; d < how.dim; d++) v[d] = s->v[d][row->i * s->v_step] - model->dt * body->a[d];
    if (body->no_slip && !body->has_belt)
        for (int d = 0; d < how.dim; d++) s->v_wall[d][row->i - particles_fluid(s)] = v[d];
    else mirror(row, s, v, body->no_slip ? GLIDING_ALONE : GLIDING, how);
}
ROW_FUNCTIONS(mirrored_start_row)

const Term wall_pressure = {
    .name = "wall pressure",
    .source = "P3 eq. 14 of each fluid b, schemes/README.md",
    .equation = "p_w^a = sum_b q_ab (p_b + J_ab) / sum_b q_ab,  q_ab = s_b^4 min(1, rho_a/rho_b),  "
                "p_b = [sum_f w p_f + (g - a_w) . sum_f w rho_f x_wf] / s_b,  s_b = sum_f w,  w = W V_f",
    .on = ON_WALL,
    .needs = NEED_W | NEED_STATE,
    .writes = FIELD(P),
    .row = ROW_TABLE(wall_pressure_row),
};

/* What has not moved shows the same. To find it again, by fewer pairs, would round otherwise than a restart, which finds it once. */
const Term shifted_wall_pressure = {
    .name = "wall pressure",
    .source = "P3 eq. 14 of each fluid b, schemes/README.md",
    .equation = "the same, where the fluid has been shifted",
    .on = ON_WALL,
    .needed = is_shifted,
    .needs = NEED_W | NEED_STATE,
    .writes = FIELD(P),
    .row = ROW_TABLE(wall_pressure_row),
};

const Term wall_jump = {
    .name = "jump at walls",
    .source = "schemes/README.md, interfaces at walls",
    .equation = "J_w^a = sum_b s_b^4 J_ab / sum_b s_b^4,  J_ab = s_ab kappa_a - s_ba kappa_b",
    .on = ON_WALL,
    .needed = is_tense,
    .needs = NEED_W | NEED_STATE,
    .row = ROW_TABLE(wall_jump_row),
};

const Term wall_density = {
    .name = "wall density",
    .source = "schemes/incompressible.md",
    .equation = "rho_w = sum_b s_b^4 rho_b / sum_b s_b^4,  s_b = sum_f W,  f of fluid b only",
    .on = ON_WALL,
    .needs = NEED_W,
    .writes = FIELD(RHO),
    .row = ROW_TABLE(wall_density_row),
};

const Term wall_velocity = {
    .name = "wall velocity",
    .source = "Adami 2012 eq. 22, 23",
    .equation = "v_w' = 2 v_w - v~, v~ = sum_f W V_f v_f / sum_f W V_f",
    .on = ON_WALL,
    .needed = is_viscous,
    .needs = NEED_W | NEED_V | NEED_STATE,
    .row = ROW_TABLE(wall_velocity_row),
};

const Term mirrored_velocity = {
    .name = "mirrored velocity",
    .source = "P2 eq. 38-42",
    .equation = "v_w' = 2 v_w - v~ without slip; v~ + 2 ((v_w - v~) . n) n with slip",
    .on = ON_WALL,
    .needed = is_viscous,
    .needs = NEED_W | NEED_F | NEED_V | NEED_STATE,
    .row = ROW_TABLE(mirrored_velocity_row),
};

const Term mirrored_start = {
    .name = "mirrored velocity",
    .source = "P2 eq. 38-42, schemes/incompressible.md",
    .equation = "v_w' = v without slip; v~ + 2 ((v - v~) . n) n with slip;  v = v_w - dt a_w",
    .on = ON_WALL,
    .needs = NEED_W | NEED_F | NEED_V | NEED_STATE,
    .row = ROW_TABLE(mirrored_start_row),
};
