/* SPDX-License-Identifier: BSD-3-Clause */
/* Correction of kernel gradients, so that gradients of linear fields are exact wherever the neighbours are.       P1 eq. 45, P2 eq. 33
 *   M_i = [sum_j (x_j - x_i) (x) grad_i W V_j]^-1,   symmetric */
#ifndef SIM_TERMS_MOMENTS_H
#define SIM_TERMS_MOMENTS_H

#include "sim/row.h"

/* The sum, of which M is the inverse: xx, yy, xy, zz, xz, yz. */
typedef struct Moments {
    Lanes of[6];
} Moments;

/* c x (x) x */
INLINE void moments_add(Moments *m, const Pair *pair, double c, How how, int l)
{
    const double x = c * pair->x[0], y = c * pair->x[1], z = how.dim == 3 ? c * pair->x[2] : 0;
    add_product(&m->of[0], l, x, pair->x[0], how);
    add_product(&m->of[1], l, y, pair->x[1], how);
    add_product(&m->of[2], l, x, pair->x[1], how);
    if (how.dim == 3) {
        add_product(&m->of[3], l, z, pair->x[2], how);
        add_product(&m->of[4], l, z, pair->x[0], how);
        add_product(&m->of[5], l, z, pair->x[1], how);
    }
}

/* weight: 1 for a pair that counts. */
INLINE void moments_pair(Moments *m, const Pair *pair, double weight, How how, int l)
{
    moments_add(m, pair, -weight * pair->V * pair->F, how, l);
}

/* M as a matrix; the identity for a particle that has no neighbours, or all of them nearly in a line or a plane. How many there are
 * does not count: in the corner of a tank it is an eighth, and what M makes of them is differences over distances. */
typedef struct Correction {
    double of[3][3];
} Correction;

/* scale: of the sums. */
INLINE Correction moments_inverse_of(const Moments *m, double scale, How how)
{
    Correction M = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const double xx = scale * lanes_sum(&m->of[0]), yy = scale * lanes_sum(&m->of[1]),
                 xy = scale * lanes_sum(&m->of[2]);
    const double zz = how.dim == 3 ? scale * lanes_sum(&m->of[3]) : 1,
                 xz = how.dim == 3 ? scale * lanes_sum(&m->of[4]) : 0,
                 yz = how.dim == 3 ? scale * lanes_sum(&m->of[5]) : 0;
    const double a = yy * zz - yz * yz, b = xz * yz - xy * zz, c = xy * yz - xz * yy;
    const double det = xx * a + xy * b + xz * c;
    const double mean = how.dim == 3 ? (xx + yy + zz) / 3 : (xx + yy) / 2;
    if (!(det > 0.02 * mean * mean * (how.dim == 3 ? mean : 1))) return M;
    const double inverse = 1 / det;
    M.of[0][0] = a * inverse;
    M.of[1][1] = (xx * zz - xz * xz) * inverse;
    M.of[2][2] = (xx * yy - xy * xy) * inverse;
    M.of[0][1] = M.of[1][0] = b * inverse;
    M.of[0][2] = M.of[2][0] = c * inverse;
    M.of[1][2] = M.of[2][1] = (xy * xz - xx * yz) * inverse;
    return M;
}

INLINE Correction moments_inverse(const Moments *m, How how)
{
    return moments_inverse_of(m, 1, how);
}

/* As fields, for neighbours and later passes. */
INLINE void keep_correction(Particles *s, size_t i, const Correction *M, How how)
{
    for (int d = 0; d < how.dim; d++) s->correction[d][i] = M->of[d][d];
    s->correction_off[0][i] = M->of[0][1];
    if (how.dim == 3) {
        s->correction_off[1][i] = M->of[0][2];
        s->correction_off[2][i] = M->of[1][2];
    }
}

/* ret = M g */
INLINE void correct(const Correction *M, const Lanes g[3], How how, double ret[3])
{
    double sums[3];
    for (int d = 0; d < how.dim; d++) sums[d] = lanes_sum(&g[d]);
    for (int d = 0; d < how.dim; d++) {
        ret[d] = 0;
        for (int e = 0; e < how.dim; e++) ret[d] += M->of[d][e] * sums[e];
    }
}

/* sum_d (M g_d)_d: of g_d = sum_j (u_j - u_i)_d grad_i W V_j, the divergence of u. */
INLINE double corrected_trace(const Correction *M, const Lanes g[3][3], How how)
{
    double trace = 0, column[3];
    for (int d = 0; d < how.dim; d++) {
        correct(M, g[d], how, column);
        trace += column[d];
    }
    return trace;
}

/* Of sum_j (p_j - p_i) grad_i W V_j, and the gradient it makes. */
INLINE void gradient_pair(double p, const Pair *pair, double counts, How how, int l, Lanes sum[3])
{
    add_along(pair, counts * (pair->V * pair->F) * (pair->p - p), how, l, sum);
}

/* A little less than what is in a corner: a quarter in the plane, an eighth in space. */
INLINE double least_moments(How how)
{
    return how.dim == 3 ? 0.1 : 0.2;
}

/* least: of the mean moment, which is 1 inside a fluid; with less there is no gradient. That of a spray's two or three neighbours is exact
 * whatever their pressures are, so that nothing would be left to be dissipated. */
INLINE void gradient_end(Particles *s, size_t i, const Moments *moments, const Lanes sum[3], double least, How how)
{
    const Correction M = moments_inverse(moments, how);
    double gradient[3], trace = 0;
    for (int k = 0; k < how.dim; k++) trace += lanes_sum(&moments->of[k == 2 ? 3 : k]);
    const double kept = trace < least * how.dim ? 0 : 1;
    correct(&M, sum, how, gradient);
    for (int d = 0; d < how.dim; d++) s->gradient[d][i * s->gradient_step] = kept * gradient[d];
}

#endif
