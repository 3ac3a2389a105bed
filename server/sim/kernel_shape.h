/* SPDX-License-Identifier: BSD-3-Clause */
/* W(r) and F(r) of the kernels that vector units can compute. Outside the support their formulas give 0. */
#ifndef SIM_KERNEL_SHAPE_H
#define SIM_KERNEL_SHAPE_H

#include "sim/kernel.h"
#include "sim/level.h"

/* Constants of a kernel, before a loop. */
typedef struct KernelScale {
    double inverse_h, alpha, slope; /* of q = r / h, of W, of F */
    double tiny;                    /* [m] keeps 0/0 away */
} KernelScale;

typedef double (*KernelShape)(const KernelScale *, double r);

INLINE KernelScale kernel_scale(const Kernel *kernel)
{
    const double inverse_h = 1 / kernel->h;
    return (KernelScale){inverse_h, kernel->alpha, -5 * kernel->beta * inverse_h * inverse_h, 1e-12 * kernel->h};
}

/* x where x > 0, else 0; NaN stays NaN, which fmax() would hide, and it is one instruction of every vector unit. */
INLINE double positive(double x)
{
    return x < 0 ? 0 : x;
}

/* W = alpha (1 - q/2)^4 (2q + 1) */
INLINE double wendland_c2_W(const KernelScale *k, double r)
{
    const double q = r * k->inverse_h, t = positive(1 - 0.5 * q), t2 = t * t;
    return k->alpha * (t2 * t2) * (2 * q + 1);
}

/* F = -5 alpha (1 - q/2)^3 / h^2 */
INLINE double wendland_c2_F(const KernelScale *k, double r)
{
    const double t = positive(1 - 0.5 * (r * k->inverse_h));
    return k->slope * (t * t * t);
}

/* W = alpha [(3-q)^5 - 6 (2-q)^5 + 15 (1-q)^5], each power cut at 0 */
INLINE double quintic_spline_W(const KernelScale *k, double r)
{
    const double q = r * k->inverse_h, a = positive(3 - q), b = positive(2 - q), c = positive(1 - q);
    const double a2 = a * a, b2 = b * b, c2 = c * c;
    return k->alpha * (a2 * a2 * a - 6 * (b2 * b2 * b) + 15 * (c2 * c2 * c));
}

/* F = -5 alpha/(h r) [(3-q)^4 - 6 (2-q)^4 + 15 (1-q)^4] */
INLINE double quintic_spline_F(const KernelScale *k, double r)
{
    const double q = r * k->inverse_h, a = positive(3 - q), b = positive(2 - q), c = positive(1 - q);
    const double a2 = a * a, b2 = b * b, c2 = c * c;
    return k->slope / (q + k->tiny * k->inverse_h) * (a2 * a2 - 6 * (b2 * b2) + 15 * (c2 * c2));
}

#endif
