/* SPDX-License-Identifier: BSD-3-Clause */
/* Continuity and pressure force with corrected gradients, so that a sheared arrangement of particles is not elastic.
 *   d rho_i/dt = rho_i sum_j V_j (1 + t) v_ij . M_i grad_i W
 *                minus, of schemes whose velocities are of dt/2 before, rho_i dt/2 tr E^2, of E = sum_j V_j (1 + t) v_ij (x) M_i grad_i W
 *   m_i dv_i/dt = -sum_j V_i V_j ((1 + t) p_i M_j + (1 - t) p_j M_i) grad_i W,   t of average.h, M of moments.h, 1 of walls
 * What compresses a particle is then exact where velocities are linear, and a uniform pressure does no other work on them, however
 * particles lie. P2 eq. 16 and 24 find a compression in the shear of a lattice: it resists like an elastic body, with a modulus
 * that is a part of the pressure at any resolution (schemes/README.md). The idea is of Bonet and Lok 1999,
 * doi 10.1016/S0045-7825(99)00051-1; M crosswise is of SPHinXsys: forces of a pair are opposite to the last bit, and the gradient
 * of a linear pressure is exact but for what a uniform one leaves. M has what Gamma is for. Repulsion as in pressure_force.c. */
#include "sim/terms/continuity.h"
#include "sim/terms/jump.h"
#include "sim/terms/moments.h"
#include "sim/terms/push.h"
#include "sim/terms/terms.h"
#include "sim/terms/wall_power.h"

static bool corrects(const Model *model)
{
    return model->corrects_gradients;
}

/* Of sum_j V_j v_ij (x) grad_i W, times what the pair counts for. */
INLINE void strain_pair(const double v[3], const Pair *pair, double counts, How how, int l, Lanes sum[3][3])
{
    const double c = counts * pair->V * pair->F;
    for (int d = 0; d < how.dim; d++) {
        const double u = c * (v[d] - pair->v[d]);
        for (int e = 0; e < how.dim; e++) add_product(&sum[d][e], l, u, pair->x[e], how);
    }
}

/* What the divergence has changed by since velocities were these (midway.h): of a gradient that is exact, exactly its square's. */
INLINE double divergence_since(const Correction *M, const Lanes strain[3][3], double lag, How how)
{
    double E[3][3] = {{0}}, square = 0;
    for (int d = 0; d < how.dim; d++) correct(M, strain[d], how, E[d]);
    for (int d = 0; d < how.dim; d++)
        for (int e = 0; e < how.dim; e++) square += E[d][e] * E[e][d];
    return lag * square;
}

INLINE void corrected_continuity_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const Flowing a = flowing_of(s, model, i);
    const Block *const walls = row->block + row->n_fluid, *const end = row->block + row->n;
    Moments moments = {0};
    Lanes strain[3][3] = {0};
    for (const Block *b = row->block; b < walls; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            moments_pair(&moments, &pair, 1, how, l);
            strain_pair(a.v, &pair, 1 + average_tilt(model, a.z, &pair, flowing_inverse(&a, &pair)), how, l, strain);
        }
    for (const Block *b = walls; b < end; b++)
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            moments_pair(&moments, &pair, 1, how, l);
            strain_pair(a.v, &pair, 1, how, l, strain);
        }
    const Correction M = moments_inverse(&moments, how);
    keep_correction(s, i, &M, how);
    s->rate[i] = s->rho[i] * corrected_trace(&M, strain, how);
    if (a.lag > 0) s->rate[i] -= s->rho[i] * divergence_since(&M, strain, a.lag, how);
}
ROW_FUNCTIONS(corrected_continuity_row)

/* M of one particle; two dimensions leave the last three alone. */
typedef struct Symmetric {
    double xx, yy, xy, zz, xz, yz;
} Symmetric;

/* M of eight. */
typedef struct Corrections {
    double xx[LANES], yy[LANES], xy[LANES], zz[LANES], xz[LANES], yz[LANES];
} Corrections;

static const Symmetric PLAIN = {1, 1, 0, 1, 0, 0};

INLINE Symmetric correction_of(const Particles *s, size_t i, How how)
{
    Symmetric M = {s->correction[0][i], s->correction[1][i], s->correction_off[0][i], 1, 0, 0};
    if (how.dim == 3) {
        M.zz = s->correction[2][i];
        M.xz = s->correction_off[1][i];
        M.yz = s->correction_off[2][i];
    }
    return M;
}

/* Before a loop, as compilers do not vectorise what is fetched from here and there. */
INLINE void gather_corrections(const Particles *s, const uint32_t *j, How how, Corrections *ret)
{
    for (int l = 0; l < LANES; l++) {
        const Symmetric M = correction_of(s, j[l], how);
        ret->xx[l] = M.xx;
        ret->yy[l] = M.yy;
        ret->xy[l] = M.xy;
        if (how.dim == 3) {
            ret->zz[l] = M.zz;
            ret->xz[l] = M.xz;
            ret->yz[l] = M.yz;
        }
    }
}

/* As images have them: an element between two directions changes its sign if one of them is turned. */
INLINE void turn_corrections(const Row *row, const Block *b, How how, Corrections *M)
{
    turn_component(row, b, 0, M->xy);
    turn_component(row, b, 1, M->xy);
    if (how.dim == 2) return;
    turn_component(row, b, 0, M->xz);
    turn_component(row, b, 2, M->xz);
    turn_component(row, b, 1, M->yz);
    turn_component(row, b, 2, M->yz);
}

INLINE Symmetric lane_correction(const Corrections *M, int l, How how)
{
    Symmetric ret = {M->xx[l], M->yy[l], M->xy[l], 1, 0, 0};
    if (how.dim == 3) {
        ret.zz = M->zz[l];
        ret.xz = M->xz[l];
        ret.yz = M->yz[l];
    }
    return ret;
}

/* mine: of p_i, times M_j x; its: of p_j, times M_i x. Sums of the two are not fused: forces are opposite to the last bit. */
INLINE double crosswise(double mine, double M_j, double its, double M_i)
{
    return mine * M_j + its * M_i;
}

INLINE void corrected_push(const Symmetric *M_i, const Symmetric *M_j, const Pair *pair, double mine, double its,
                           double V, How how, int l, Lanes sum[3])
{
    const double c = V * pair->V * pair->F, x = pair->x[0], y = pair->x[1];
    const double xx = crosswise(mine, M_j->xx, its, M_i->xx), yy = crosswise(mine, M_j->yy, its, M_i->yy),
                 xy = crosswise(mine, M_j->xy, its, M_i->xy);
    if (how.dim == 2) {
        add_product(&sum[0], l, c, xx * x + xy * y, how);
        add_product(&sum[1], l, c, xy * x + yy * y, how);
    } else {
        const double zz = crosswise(mine, M_j->zz, its, M_i->zz), xz = crosswise(mine, M_j->xz, its, M_i->xz),
                     yz = crosswise(mine, M_j->yz, its, M_i->yz), z = pair->x[2];
        add_product(&sum[0], l, c, xx * x + xy * y + xz * z, how);
        add_product(&sum[1], l, c, xy * x + yy * y + yz * z, how);
        add_product(&sum[2], l, c, xz * x + yz * y + zz * z, how);
    }
}

INLINE void corrected_pressure_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const Block *const walls = row->block + row->n_fluid, *const end = row->block + row->n;
    const Symmetric M_i = correction_of(s, i, how);
    const WallPressure shown = wall_pressure_of(s, i);
    const double p = s->p[i * s->p_step], z = particles_impedance(s, model, i), V = particles_volume(s, model, i),
                 beta = row->mixed ? model->repulsion : 0;
    const bool jumps = row->mixed && model->tense;
    const Jump jump = jumps ? jump_of(s, model, i, 1) : NO_JUMP;
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < walls; b++) {
        Corrections M;
        gather_corrections(s, row_j(row, b), how, &M);
        if (are_images(row, b)) turn_corrections(row, b, how, &M);
        double repulsion[LANES] = {0}, lacks[LANES] = {0};
        if (jumps) jumps_of(&jump, s, row_j(row, b), lacks);
        if (row->mixed)
            for (int l = 0; l < LANES; l++) repulsion[l] = beta * b->other[l];
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            const Symmetric M_j = lane_correction(&M, l, how);
            const double t = average_tilt(model, z, &pair, 1 / (z + pair.z));
            corrected_push(&M_i, &M_j, &pair, (1 + t) * p + repulsion[l] * fabs(p),
                           (1 - t) * (pair.p + lacks[l]) + repulsion[l] * fabs(pair.p), V, how, l, sum);
        }
    }
    for (const Block *b = walls; b < end; b++) {
        const uint32_t *j = row_j(row, b);
        double p_wall[LANES];
        for (int l = 0; l < LANES; l++) p_wall[l] = shown_by(&shown, j[l]);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            corrected_push(&M_i, &PLAIN, &pair, p, p_wall[l], V, how, l, sum);
        }
    }
    pressure_end(s, i, sum, how);
}
ROW_FUNCTIONS(corrected_pressure_row)

INLINE void corrected_power_row(const Row *row, Particles *s, const Model *model, How how)
{
    const size_t i = row->i;
    const Symmetric M_i = correction_of(s, i, how);
    const WallPressure shown = wall_pressure_of(s, i);
    const double p = s->p[i * s->p_step], V = particles_volume(s, model, i);
    Lanes power = {0};
    for (const Block *b = row->block + row->n_fluid; b < row->block + row->n; b++) {
        const uint32_t *j = row_j(row, b);
        Lanes force[3] = {0};
        double p_wall[LANES];
        for (int l = 0; l < LANES; l++) p_wall[l] = shown_by(&shown, j[l]);
#pragma omp simd
        for (int l = 0; l < LANES; l++) {
            const Pair pair = block_pair(b, l, how);
            corrected_push(&M_i, &PLAIN, &pair, p, p_wall[l], V, how, l, force);
        }
        add_wall_power(force, row, b, s, model, how, &power);
    }
    s->power[i] -= lanes_sum(&power);
}
ROW_FUNCTIONS(corrected_power_row)

NORMAL_POWER(corrected_power, "power of walls", "Bonet and Lok 1999",
             "sum_w f_iw . v_w, f of the corrected pressure force", corrects, NEED_F | NEED_STATE);

const Term corrected_continuity = {
    .name = "corrected continuity",
    .source = "Bonet and Lok 1999",
    .equation = "d rho_i/dt = rho_i sum_j V_j (1 + t) v_ij . M_i grad_i W",
    .on = ON_CONTINUITY,
    .needed = corrects,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .writes = FIELD(CORRECTION) | FIELD(CORRECTION_OFF),
    .row = ROW_TABLE(corrected_continuity_row),
};

const Term corrected_pressure_force = {
    .name = "corrected pressure force",
    .source = "Bonet and Lok 1999, crosswise as in SPHinXsys",
    .equation = "m_i dv_i/dt -= sum_j V_i V_j ((1 + t) p_i M_j + (1 - t) p_j M_i) grad_i W, and a repulsion",
    .on = ON_FLUID,
    .needed = corrects,
    .needs = NEED_F | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(A),
    .row = ROW_TABLE(corrected_pressure_row),
};
