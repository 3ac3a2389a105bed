/* SPDX-License-Identifier: BSD-3-Clause */
/* Continuity and pressure force with corrected gradients, so that a sheared arrangement of particles is not elastic.
 *   d rho_i/dt = rho_i sum_j V_j (1 + t) v_ij . M_i grad_i W
 *   m_i dv_i/dt = -sum_j V_i V_j ((1 + t) p_i M_j + (1 - t) p_j M_i) grad_i W,   t of average.h, M of moments.h, 1 of walls
 * What compresses a particle is then exact where velocities are linear, and a uniform pressure does no other work on them, however
 * particles lie. P2 eq. 16 and 24 find a compression in the shear of a lattice: it resists like an elastic body, with a modulus
 * that is a part of the pressure at any resolution (schemes/README.md). The idea is of Bonet and Lok 1999,
 * doi 10.1016/S0045-7825(99)00051-1; M crosswise is of SPHinXsys: forces of a pair are opposite to the last bit, and the gradient
 * of a linear pressure is exact but for what a uniform one leaves. M has what Gamma is for. Repulsion as in pressure_force.c. */
#include "sim/terms/continuity.h"
#include "sim/terms/moments.h"
#include "sim/terms/push.h"
#include "sim/terms/terms.h"

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

INLINE void keep_correction(Particles *s, size_t i, const Correction *M, How how)
{
    for (int d = 0; d < how.dim; d++) s->correction[d][i] = M->of[d][d];
    s->correction_off[0][i] = M->of[0][1];
    if (how.dim == 3) {
        s->correction_off[1][i] = M->of[0][2];
        s->correction_off[2][i] = M->of[1][2];
    }
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
    double rate = 0, column[3];
    for (int d = 0; d < how.dim; d++) {
        correct(&M, strain[d], how, column);
        rate += column[d];
    }
    s->rate[i] = s->rho[i] * rate;
}
ROW_FUNCTIONS(corrected_continuity_row)

/* xx, yy, zz and xy, xz, yz of a particle's M. */
typedef struct Symmetric {
    double on[3], off[3];
} Symmetric;

INLINE Symmetric correction_of(const Particles *s, size_t i, How how)
{
    Symmetric M = {{0}, {0}};
    for (int d = 0; d < how.dim; d++) M.on[d] = s->correction[d][i];
    for (int d = 0; d < (how.dim == 3 ? 3 : 1); d++) M.off[d] = s->correction_off[d][i];
    return M;
}

/* Of eight neighbours; before a loop, as compilers do not vectorise what is fetched from here and there. */
INLINE void gather_corrections(const Particles *s, const uint32_t *j, How how, double ret[6][LANES])
{
    for (int l = 0; l < LANES; l++) {
        for (int d = 0; d < how.dim; d++) ret[d][l] = s->correction[d][j[l]];
        for (int d = 0; d < (how.dim == 3 ? 3 : 1); d++) ret[3 + d][l] = s->correction_off[d][j[l]];
    }
}

/* mine: of p_i, times M_j x; its: of p_j, times M_i x. Sums of the two are not fused: forces are opposite to the last bit. */
INLINE double crosswise(double mine, double M_j, double its, double M_i)
{
    return mine * M_j + its * M_i;
}

INLINE void corrected_push(Symmetric M_i, Symmetric M_j, const Pair *pair, double mine, double its, double V, How how,
                           int l, Lanes sum[3])
{
    const double c = V * pair->V * pair->F, x = pair->x[0], y = pair->x[1], z = how.dim == 3 ? pair->x[2] : 0;
    const double xx = crosswise(mine, M_j.on[0], its, M_i.on[0]), yy = crosswise(mine, M_j.on[1], its, M_i.on[1]),
                 xy = crosswise(mine, M_j.off[0], its, M_i.off[0]);
    if (how.dim == 2) {
        add_product(&sum[0], l, c, xx * x + xy * y, how);
        add_product(&sum[1], l, c, xy * x + yy * y, how);
        return;
    }
    const double zz = crosswise(mine, M_j.on[2], its, M_i.on[2]), xz = crosswise(mine, M_j.off[1], its, M_i.off[1]),
                 yz = crosswise(mine, M_j.off[2], its, M_i.off[2]);
    add_product(&sum[0], l, c, xx * x + xy * y + xz * z, how);
    add_product(&sum[1], l, c, xy * x + yy * y + yz * z, how);
    add_product(&sum[2], l, c, xz * x + yz * y + zz * z, how);
}

/* Not `omp simd`: gcc 12 does not vectorise these two loops. */
INLINE void corrected_pressure_row(const Row *row, Particles *s, const Model *model, How how)
{
    static const Symmetric plain = {{1, 1, 1}, {0}};
    const size_t i = row->i, first_wall = particles_fluid(s);
    const Block *const walls = row->block + row->n_fluid, *const end = row->block + row->n;
    const Symmetric M_i = correction_of(s, i, how);
    const double *const p_wall = s->p_wall[s->phase[i]];
    const double p = s->p[i], z = s->z[i], V = s->vol[i], beta = row->mixed ? model->repulsion : 0;
    Lanes sum[3] = {0};
    for (const Block *b = row->block; b < walls; b++) {
        double M[6][LANES] = {{0}};
        gather_corrections(s, row_j(row, b), how, M);
        for (int l = 0; l < LANES; l++) {
            const Pair near = block_pair(b, l, how);
            const Symmetric M_j = {{M[0][l], M[1][l], M[2][l]}, {M[3][l], M[4][l], M[5][l]}};
            const double t = average_tilt(model, z, &near, 1 / (z + near.z));
            const double repulsion = row->mixed ? beta * near.other : 0;
            corrected_push(M_i, M_j, &near, (1 + t) * p + repulsion * fabs(p),
                           (1 - t) * near.p + repulsion * fabs(near.p), V, how, l, sum);
        }
    }
    for (const Block *b = walls; b < end; b++) {
        const uint32_t *j = row_j(row, b);
        for (int l = 0; l < LANES; l++) {
            const Pair near = block_pair(b, l, how);
            corrected_push(M_i, plain, &near, p, p_wall[j[l] - first_wall], V, how, l, sum);
        }
    }
    pressure_end(s, i, sum, how);
}
ROW_FUNCTIONS(corrected_pressure_row)

const Term corrected_continuity = {
    .name = "corrected continuity",
    .source = "Bonet and Lok 1999",
    .equation = "d rho_i/dt = rho_i sum_j V_j v_ij . M_i grad_i W",
    .on = ON_CONTINUITY,
    .needed = corrects,
    .needs = NEED_F | NEED_V | NEED_STATE,
    .writes = FIELD(CORRECTION) | FIELD(CORRECTION_OFF),
    .row = ROW_TABLE(corrected_continuity_row),
};

const Term corrected_pressure_force = {
    .name = "corrected pressure force",
    .source = "Bonet and Lok 1999, crosswise as in SPHinXsys",
    .equation = "m_i dv_i/dt -= sum_j V_i V_j (p_i M_j + p_j M_i) grad_i W, and a repulsion",
    .on = ON_FLUID,
    .needed = corrects,
    .needs = NEED_F | NEED_STATE | NEED_OTHERS,
    .writes = FIELD(A),
    .row = ROW_TABLE(corrected_pressure_row),
};
