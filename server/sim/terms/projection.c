/* SPDX-License-Identifier: BSD-3-Clause */
/* The pressure systems of an incompressible flow of many fluids, and what is done with their solutions.          P4 eq. 20-35
 *   A_ij = (V_i^2 + V_j^2) F,  V = 1 / sum W;  densities are those of reference
 *   c_ij = -A_ij / (rho_i + rho_j),  (L P)_i = sum_j c_ij (P_i - P_j)
 *   velocity   L P = -1/2 sum_j A_ij (v_j - v_i)/2 . x_ij,     v_i -= 1/m_i sum_j A_ij P_ij x_ij,            p = P/dt
 *   density    L P = -1/2 (V_i - V_0),                         x_i -= 1/m_i sum_j A_ij (P_ij - P_i + P_0 + P_ref) x_ij
 *   P_ij = (rho_i P_j + rho_j P_i) / (rho_i + rho_j);  P_0: P_i, but from 0 to 0.2 rho h^2
 * Of the velocity's system and correction P_j is P_j + dt J_ij across an interface with tension (jump.h).
 * A wall particle is an unknown too, of the density of the fluids that are there (wall_density), through which nothing flows:
 *   sum_i c_iw (P_w + dt J_w^i - P_i - (rho_i + rho_w)/2 dt (g - a_w) . (x_w - x_i)) = 0,   J_w^i of the fluid of i (wall.c)
 * so L stays symmetric, and one fluid at rest on a lattice is exact. Pairs of fluid and wall at the rim of the kernel are left out of all sums with
 * pressures. Images in mirrors (mirrors.h) have the pressure of the particle that they are of and, as gravity goes on behind a mirror,
 *   P_j' = P_j + rho_j dt g . (x_j' - x_j)
 * of the velocity's correction. */
#include "sim/mirrors.h"
#include "sim/solve/solve.h"
#include "sim/terms/jump.h"
#include "sim/terms/matrix_row.h"
#include "sim/terms/terms.h"
#include "sim/terms/wall_power.h"
#include <math.h>
#include <string.h>

/* Of a spacing, by which one density correction may move a particle. They are a hundredth of one as a rule; without a bound single
 * particles beside an interface or in a corner are thrown out of their neighbours' reach. */
static const double MOVE_MOST = 0.1;

/* The Laplacian has a narrower stencil than the divergence of a gradient, so that for waves of a few spacings its solution is too small:
 * to go farther saves a quarter of the corrections, and from 3 on they diverge. */
static const double FARTHER = 1.5;

/* How much of a correction's pressure spreads particles, FARTHER included, over rho h^2; of what is beyond, and below 0, the differences
 * alone are used. The pressure of a wave of densities goes with the square of its length: below 0 it draws neighbours together until they
 * meet, and far above it throws them about, more at each correction (a million particles in disorder). */
static const double SPREAD_MOST = 0.2;

/* -A_ij, the same for the two of a pair to the last bit. */
INLINE double facing(double V_i, double V_j, double F)
{
    return -(V_i * V_i + V_j * V_j) * F;
}

/* What a density counts as: 1 of all where positions alone are put right, so that the heavy do not push the light about. */
INLINE double weight_of(const Model *model, unsigned fluid, bool unit)
{
    return unit ? 1 : model->phase[fluid].rho0;
}

/* 1 / (rho_i + rho_j) by the fluid of j. */
INLINE void inverse_sums(const Model *model, unsigned fluid, bool unit, double ret[MNS_MAX_FLUIDS])
{
    for (unsigned a = 0; a < model->n_phases; a++)
        ret[a] = 1 / (weight_of(model, fluid, unit) + weight_of(model, a, unit));
}

/* The same of a fluid and a wall particle. */
INLINE double inverse_at_wall(const Particles *s, const Model *model, unsigned fluid, size_t wall_particle, bool unit)
{
    return unit ? 0.5 : 1 / (model->phase[fluid].rho0 + s->rho[wall_particle]);
}

/* Of a block, whose pairs are all with fluids or all with walls. */
INLINE void inverses(const Particles *s, const Model *model, unsigned mine, const double inverse[MNS_MAX_FLUIDS],
                     const uint32_t j[LANES], bool wall, bool unit, double ret[LANES])
{
    if (wall)
        for (int l = 0; l < LANES; l++) ret[l] = inverse_at_wall(s, model, mine, j[l], unit);
    else
        for (int l = 0; l < LANES; l++) ret[l] = inverse[s->phase[j[l]]];
}

/* P_j' - P_j of a block of images, in the velocity's correction. */
INLINE void image_rises(const Row *row, const Block *b, const Particles *s, const Model *model, How how,
                        double ret[LANES])
{
    const uint32_t *j = row_j(row, b);
    for (int l = 0; l < LANES; l++) {
        const bool wall = j[l] >= particles_fluid(s);
        double along = 0;
        for (int d = 0; d < how.dim; d++) along += model->gravity[d] * image_moved(row, b, l, s, model, d);
        ret[l] = model->dt * (wall ? s->rho[j[l]] : model->phase[s->phase[j[l]]].rho0) * along;
    }
}

/* Row of a fluid particle. */
INLINE void matrix_row(const Row *row, Particles *s, const Model *model, bool unit)
{
    const size_t i = row->i, first = s->system->matrix.start[i] * LANES;
    Matrix *m = &s->system->matrix;
    const unsigned mine = s->phase[i];
    const double V = particles_volume(s, model, i);
    double inverse[MNS_MAX_FLUIDS];
    inverse_sums(model, mine, unit, inverse);
    uint32_t *column = m->column + first;
    float *c = m->c + first;
    for (size_t b = 0; b < row->n; b++) {
        const Block *block = &row->block[b];
        const uint32_t *j = row_j(row, block);
        const bool wall = b >= row->n_fluid;
        const double faint = wall ? model->projection.faint : 0;
        double by[LANES];
        float of[LANES];
        inverses(s, model, mine, inverse, j, wall, unit, by);
#pragma omp simd
        for (size_t l = 0; l < LANES; l++) {
            const double F = block->F[l] < faint ? block->F[l] : 0;
            of[l] = (float)(facing(V, block->V[l], F) * by[l]);
        }
        if (are_images(row, block)) {
            add_to_sources(row, block, of, c);
            continue;
        }
        const size_t at = entry_of(row, b * LANES);
        memcpy(column + at, j, LANES * sizeof *column);
        memcpy(c + at, of, sizeof of);
    }
    m->diagonal[i] = float_sum(c, entry_blocks(row) * LANES);
    m->blocks[i] = m->diagonal[i] > 0 ? (uint32_t)entry_blocks(row) : 0;
}

INLINE void velocity_matrix_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)how;
    matrix_row(row, s, model, false);
}
ROW_FUNCTIONS(velocity_matrix_row)

INLINE void density_matrix_row(const Row *row, Particles *s, const Model *model, How how)
{
    (void)how;
    matrix_row(row, s, model, model->projection.unit_mobility);
    s->system->b[row->i] = -0.5 * (particles_volume(s, model, row->i) - model->cell_volume);
}
ROW_FUNCTIONS(density_matrix_row)

/* Index of the entry of column j among the first n of a row; n if no entry has it. */
INLINE size_t find_entry(const uint32_t *column, size_t n, uint32_t j)
{
    size_t k = 0;
    while (k < n && column[k] != j) k++;
    return k;
}

/* Row of a wall particle; pull: [dim] dt (g - a_w), or 0; rises: is it of the velocity, whose pressures jump, and are others at images? One that is
 * hidden says nothing. */
INLINE void wall_row(const Row *row, Particles *s, const Model *model, bool unit, const double pull[3], bool rises,
                     How how)
{
    System *y = s->system;
    Matrix *m = &y->matrix;
    const size_t i = row->i, first = m->start[i] * LANES;
    const double V = particles_volume(s, model, i);
    const bool hidden = mirrors_hide(model, s, i);
    size_t n = 0;
    double flux = 0;
    for (const Block *b = row->block; b < row->block + row->n && !hidden; b++) {
        const uint32_t *j = row_j(row, b);
        const bool images = are_images(row, b);
        double rise[LANES] = {0};
        if (images && rises) image_rises(row, b, s, model, how, rise);
        if (rises && model->tense)
            for (int l = 0; l < LANES; l++) rise[l] -= model->dt * s->p_wall[s->phase[j[l]]][i - particles_fluid(s)];
        for (int l = 0; l < LANES; l++) {
            if (!(b->F[l] < model->projection.faint)) continue;
            const double inverse = inverse_at_wall(s, model, s->phase[j[l]], i, unit);
            const float c = (float)(facing(V, b->V[l], b->F[l]) * inverse);
            double along = 0;
            for (int d = 0; d < how.dim; d++) along += pull[d] * b->x[d][l];
            const size_t at = images ? find_entry(m->column + first, n, j[l]) : n;
            if (at == n) m->c[first + n++] = 0;
            m->column[first + at] = j[l];
            m->c[first + at] += c;
            flux += 0.5 * (double)c / inverse * along + (double)c * rise[l];
        }
    }
    m->diagonal[i] = float_sum(m->c + first, n);
    for (; n % LANES; n++) {
        m->column[first + n] = (uint32_t)i;
        m->c[first + n] = 0;
    }
    m->blocks[i] = m->diagonal[i] > 0 ? (uint32_t)(n / LANES) : 0;
    y->b[i] = flux;
}

INLINE void velocity_wall_row(const Row *row, Particles *s, const Model *model, How how)
{
    const WallState *wall = &model->wall[s->phase[row->i] - model->n_phases];
    double pull[3] = {0};
    for (int d = 0; d < how.dim; d++) pull[d] = model->dt * (model->gravity[d] - wall->a[d]);
    wall_row(row, s, model, false, pull, true, how);
}
ROW_FUNCTIONS(velocity_wall_row)

INLINE void density_wall_row(const Row *row, Particles *s, const Model *model, How how)
{
    const double pull[3] = {0};
    wall_row(row, s, model, model->projection.unit_mobility, pull, false, how);
}
ROW_FUNCTIONS(density_wall_row)

/* sum_j' c_ij' (P_j' - P_j) over images, by the entries that are in the matrix. */
INLINE double risen(const Row *row, const Block *b, const Particles *s, const Model *model, How how)
{
    const unsigned mine = s->phase[row->i];
    const double V = particles_volume(s, model, row->i);
    const bool wall = b >= row->block + row->n_fluid;
    double inverse[MNS_MAX_FLUIDS], by[LANES], rise[LANES], sum = 0;
    inverse_sums(model, mine, false, inverse);
    inverses(s, model, mine, inverse, row_j(row, b), wall, false, by);
    image_rises(row, b, s, model, how, rise);
    for (int l = 0; l < LANES; l++) {
        const double F = b->F[l] < (wall ? model->projection.faint : 0) ? b->F[l] : 0;
        sum += (double)(float)(facing(V, b->V[l], F) * by[l]) * rise[l];
    }
    return sum;
}

/* dt J_ij of a block of any pairs. */
INLINE void lacks_of(const Row *row, const Block *b, const Particles *s, const Model *model, const Jump *jump,
                     double ret[LANES])
{
    const uint32_t *j = row_j(row, b);
    const size_t first_wall = particles_fluid(s);
    if (b < row->block + row->n_fluid) {
        jumps_of(jump, s, j, ret);
        return;
    }
    const double *at_wall = s->p_wall[s->phase[row->i]];
    for (int l = 0; l < LANES; l++) ret[l] = model->dt * at_wall[j[l] - first_wall];
}

/* sum_j c_ij dt J_ij of a block, by the entries that are in the matrix. */
INLINE double raised(const Row *row, const Block *b, const Particles *s, const Model *model, const Jump *jump)
{
    const double V = particles_volume(s, model, row->i);
    const bool wall = b >= row->block + row->n_fluid;
    double inverse[MNS_MAX_FLUIDS], by[LANES], lacks[LANES], sum = 0;
    inverse_sums(model, s->phase[row->i], false, inverse);
    inverses(s, model, s->phase[row->i], inverse, row_j(row, b), wall, false, by);
    lacks_of(row, b, s, model, jump, lacks);
    for (int l = 0; l < LANES; l++) {
        const double F = b->F[l] < (wall ? model->projection.faint : 0) ? b->F[l] : 0;
        sum += (double)(float)(facing(V, b->V[l], F) * by[l]) * lacks[l];
    }
    return sum;
}

INLINE void divergence_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    double above = 0;
    const double V = particles_volume(s, model, i);
    const Jump jump = row->mixed && model->tense ? jump_of(s, model, i, model->dt) : NO_JUMP;
    double v[3];
    Lanes sum = {0};
    for (int d = 0; d < how.dim; d++) v[d] = s->v[d][i * s->v_step];
    for (const Block *b = row->block + (row->mixed ? 0 : row->n_fluid); b < row->block + row->n && model->tense; b++)
        above += raised(row, b, s, model, &jump);
    for (const Block *b = row->block; b < row->block + row->n; b++) {
        double its[3][LANES];
        gather_velocities(row, b, s, how, its);
        if (are_images(row, b)) above += risen(row, b, s, model, how);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            double along = 0;
            for (int d = 0; d < how.dim; d++) along += (its[d][l] - v[d]) * b->x[d][l];
            sum.of[l] += facing(V, b->V[l], b->F[l]) * along;
        }
    }
    s->system->b[i] = 0.25 * lanes_sum(&sum) + above;
}
ROW_FUNCTIONS(divergence_row)

/* 1/m_i sum_j A_ij (times (P_ij - P_i) + base) x_ij: with times P_i as the base it is opposite for the two of a pair. rises: is it of the velocity, whose pressures
 * jump, and are others at images? */
INLINE void push(const Row *row, const Particles *s, const Model *model, bool unit, bool rises, double times,
                 double base, How how, double ret[3])
{
    const size_t i = row->i;
    const unsigned mine = s->phase[i];
    const double V = particles_volume(s, model, i), rho = weight_of(model, mine, unit), *P = s->system->x,
                 P_i = times * P[i];
    const bool jumps = rises && model->tense;
    const Jump jump = jumps && row->mixed ? jump_of(s, model, i, model->dt) : NO_JUMP;
    double inverse[MNS_MAX_FLUIDS];
    Lanes sum[3] = {0};
    inverse_sums(model, mine, unit, inverse);
    for (const Block *b = row->block; b < row->block + row->n; b++) {
        const uint32_t *j = row_j(row, b);
        const bool wall = b >= row->block + row->n_fluid;
        const double faint = wall ? model->projection.faint : 0;
        double by[LANES], P_ij[LANES], its[LANES];
        inverses(s, model, mine, inverse, j, wall, unit, by);
        for (int l = 0; l < LANES; l++) its[l] = times * P[j[l]];
        if (jumps && (wall || row->mixed)) {
            double lacks[LANES];
            lacks_of(row, b, s, model, &jump, lacks);
            for (int l = 0; l < LANES; l++) its[l] += lacks[l];
        }
        if (rises && are_images(row, b)) {
            double rise[LANES];
            image_rises(row, b, s, model, how, rise);
            for (int l = 0; l < LANES; l++) its[l] += rise[l];
        }
        for (int l = 0; l < LANES; l++) P_ij[l] = rho * by[l] * (its[l] - P_i) + base;
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const double c = facing(V, b->V[l], b->F[l] < faint ? b->F[l] : 0) * P_ij[l];
            for (int d = 0; d < how.dim; d++) add_product(&sum[d], l, c, b->x[d][l], how);
        }
    }
    const double m = unit ? model->cell_volume : s->m[i];
    for (int d = 0; d < how.dim; d++) ret[d] = -lanes_sum(&sum[d]) / m;
}

INLINE void velocity_correction_row(const Row *row, Particles *s, const Model *model, How how)
{
    double change[3];
    push(row, s, model, false, true, 1, s->system->x[row->i], how, change);
    for (int d = 0; d < how.dim; d++) s->v[d][row->i * s->v_step] -= change[d];
}
ROW_FUNCTIONS(velocity_correction_row)

INLINE void density_correction_row(const Row *row, Particles *s, const Model *model, How how)
{
    const double h = model->kernel.h, rho = model->projection.unit_mobility ? 1 : model->rho_min;
    double change[3], keep = 1;
    const double unit = rho * h * h, P = FARTHER * s->system->x[row->i];
    const double base = fmin(fmax(P, 0), SPREAD_MOST * unit) + model->projection.offset * unit;
    push(row, s, model, model->projection.unit_mobility, false, FARTHER, base, how, change);
    const double size = sqrt(DOT(change, change, how)), most = MOVE_MOST * model->dx;
    if (size > most) keep = most / size;
    for (int d = 0; d < how.dim; d++) s->x[d][row->i * s->x_step] -= keep * change[d];
}
ROW_FUNCTIONS(density_correction_row)

/* Of the solution that the last step ended with, and not of the pressures that are shown, which are means over some time: m_i dv_i = sum_j A_ij P_ij
 * x_ij within dt. */
INLINE void projected_power_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const unsigned mine = s->phase[i];
    const double V = particles_volume(s, model, i), *P = s->system->x;
    Lanes power = {0};
    for (const Block *b = row->block + row->n_fluid; b < row->block + row->n && model->dt > 0; b++) {
        const uint32_t *j = row_j(row, b);
        Lanes force[3] = {0};
        double P_ij[LANES], lacks[LANES] = {0};
        if (model->tense) lacks_of(row, b, s, model, &NO_JUMP, lacks);
        for (int l = 0; l < LANES; l++) {
            const double share = model->phase[mine].rho0 * inverse_at_wall(s, model, mine, j[l], false);
            P_ij[l] = share * (P[j[l]] + lacks[l] - P[i]) + P[i];
        }
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const double F = pair.F < model->projection.faint ? pair.F : 0;
            add_along(&pair, facing(V, pair.V, F) * P_ij[l], how, l, force);
        }
        add_wall_power(force, row, b, s, model, how, &power);
    }
    if (model->dt > 0) s->power[i] += lanes_sum(&power) / model->dt;
}
ROW_FUNCTIONS(projected_power_row)

NORMAL_POWER(projected_power, "power of walls", "P4 eq. 24", "sum_w f_iw . v_w, f of the velocity correction", NULL,
             NEED_F | NEED_STATE);

const Term density_matrix = {
    .name = "density system",
    .source = "P4 eq. 20, 30, 31",
    .equation = "sum_j c_ij (P_i - P_j) = (V_0 - V_i)/2,  c_ij = -A_ij/(rho_i + rho_j),  A_ij = (V_i^2 + V_j^2) F",
    .on = ON_FLUID,
    .needs = NEED_F | NEED_STATE,
    .row = ROW_TABLE(density_matrix_row),
};

const Term density_wall_matrix = {
    .name = "density system at walls",
    .source = "schemes/incompressible.md",
    .equation = "sum_i c_iw (P_w - P_i) = 0",
    .on = ON_WALL,
    .needs = NEED_F | NEED_STATE,
    .row = ROW_TABLE(density_wall_row),
};

const Term density_correction = {
    .name = "density correction",
    .source = "P4 eq. 22, 35",
    .equation =
        "x_i -= 1/m_i sum_j A_ij (P_ij - P_i + P_0 + P_ref) x_ij,  P_ij = (rho_i P_j + rho_j P_i)/(rho_i + rho_j)",
    .on = ON_FLUID,
    .needs = NEED_F | NEED_STATE,
    .writes = FIELD(X),
    .row = ROW_TABLE(density_correction_row),
};

const Term velocity_matrix = {
    .name = "velocity system",
    .source = "P4 eq. 30",
    .equation = "sum_j c_ij (P_i - P_j) = -1/2 (div v)_i V_i",
    .on = ON_FLUID,
    .needs = NEED_F | NEED_STATE,
    .row = ROW_TABLE(velocity_matrix_row),
};

const Term velocity_wall_matrix = {
    .name = "velocity system at walls",
    .source = "schemes/incompressible.md",
    .equation = "sum_i c_iw (P_w - P_i - (rho_i + rho_w)/2 dt (g - a_w) . x_wi) = 0",
    .on = ON_WALL,
    .needs = NEED_F | NEED_STATE,
    .row = ROW_TABLE(velocity_wall_row),
};

const Term velocity_divergence = {
    .name = "divergence",
    .source = "P4 eq. 32 as differences",
    .equation = "(div v)_i V_i = sum_j A_ij (v_j - v_i)/2 . x_ij",
    .on = ON_FLUID,
    .needs = NEED_F | NEED_V | NEED_STATE | NEED_OTHERS,
    .row = ROW_TABLE(divergence_row),
};

const Term velocity_correction = {
    .name = "velocity correction",
    .source = "P4 eq. 24, 35",
    .equation = "v_i -= 1/m_i sum_j A_ij P_ij x_ij",
    .on = ON_FLUID,
    .needs = NEED_F | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(V),
    .row = ROW_TABLE(velocity_correction_row),
};
