/* SPDX-License-Identifier: BSD-3-Clause */
/* W(r), F(r) and how F changes, of the kernels, as vector units can compute them. Outside the support they are 0. */
#ifndef SIM_KERNEL_SHAPE_H
#define SIM_KERNEL_SHAPE_H

#include "sim/kernel.h"
#include "sim/level.h"

/* Constants of a kernel, before a loop. */
typedef struct KernelScale {
    double inverse_h, alpha, slope; /* of q = r / h, of W, of F */
    double tiny;                    /* [m] keeps 0/0 away */
} KernelScale;

/* All at once: what is not used costs nothing, and what they have in common is there once. bend: (1/r) dF/dr, so that grad F = bend x. */
typedef struct KernelValue {
    double W, F, bend;
} KernelValue;

/* r2: r squared, for what needs no more and would wait for the root. */
typedef KernelValue (*KernelShape)(const KernelScale *, double r, double r2, bool fused);

INLINE KernelScale kernel_scale(const Kernel *kernel)
{
    const double inverse_h = 1 / kernel->h;
    return (KernelScale){inverse_h, kernel->alpha, kernel->steepness * kernel->beta * inverse_h * inverse_h,
                         1e-12 * kernel->h};
}

/* x where x > 0, else 0; NaN stays NaN, which fmax() would hide, and it is one instruction of every vector unit. */
INLINE double positive(double x)
{
    return x < 0 ? 0 : x;
}

/* W = alpha (1 - q/2)^4 (2q + 1),  F = -5 alpha (1 - q/2)^3 / h^2,  bend = 15/2 alpha (1 - q/2)^2 / (h^3 r) */
INLINE KernelValue wendland_c2(const KernelScale *k, double r, double r2, bool fused)
{
    (void)r2;
    const double q = r * k->inverse_h, t = positive(mul_add(-0.5, q, 1, fused)), t2 = t * t;
    return (KernelValue){k->alpha * (t2 * t2) * mul_add(2, q, 1, fused), k->slope * (t2 * t),
                         -1.5 * k->inverse_h * k->slope * t2 / (r + k->tiny)};
}

/* W = alpha [(3-q)^5 - 6 (2-q)^5 + 15 (1-q)^5],  F = -5 alpha/(h r) [(3-q)^4 - 6 (2-q)^4 + 15 (1-q)^4], each power cut at 0;
 * bend = (-5 alpha/(h r) (-4/h) [(3-q)^3 - 6 (2-q)^3 + 15 (1-q)^3] - F/r) / r */
INLINE KernelValue quintic_spline(const KernelScale *k, double r, double r2, bool fused)
{
    (void)r2;
    const double q = r * k->inverse_h, a = positive(3 - q), b = positive(2 - q), c = positive(1 - q);
    const double a2 = a * a, b2 = b * b, c2 = c * c;
    const double a4 = a2 * a2, b4 = b2 * b2, c4 = c2 * c2;
    const double along = k->slope / (q + k->tiny * k->inverse_h), per_r = 1 / (r + k->tiny);
    const double F = along * mul_add(15, c4, mul_add(-6, b4, a4, fused), fused);
    const double cubes = mul_add(15, c2 * c, mul_add(-6, b2 * b, a2 * a, fused), fused);
    return (KernelValue){k->alpha * mul_add(15, c4 * c, mul_add(-6, b4 * b, a4 * a, fused), fused), F,
                         mul_add(-4 * k->inverse_h * along, cubes, -(F * per_r), fused) * per_r};
}

/* exp(-s), 0 <= s <= 9, to 1e-14 of itself: the polynomial in t = -s/32 that is nearest to exp(t), of those that begin with 1 + t (to 2e-18 of it,
 * by Remez's exchange), squared five times. Its terms are added in pairs, as a chain of sums would be waited for. The C library's has other bits on other machines, and no vectors. */
INLINE double bell(double s, bool fused)
{
    const double t = s * -0.03125;
    const double t2 = t * t, t4 = t2 * t2;
    const double low = mul_add(t2, mul_add(t, 0.16666666666380630, 0.49999999999996236, fused), 1 + t, fused);
    const double middle = mul_add(t2, mul_add(t, 1.9835115753482266e-4, 1.3888774307591296e-3, fused),
                                  mul_add(t, 8.3333320452138061e-3, 4.1666666582539379e-2, fused), fused);
    const double high = mul_add(t, 2.4049331318832298e-6, 2.4604216018658161e-5, fused);
    const double e = mul_add(t4 * t4, high, mul_add(t4, middle, low, fused), fused);
    const double e2 = e * e, e4 = e2 * e2, e8 = e4 * e4, e16 = e8 * e8;
    return e16 * e16;
}

/* W = alpha exp(-q^2) for q < 3, as P1 writes it: not renormalised; F = -2 W / h^2,  bend = -2 F / h^2 */
INLINE KernelValue truncated_gaussian(const KernelScale *k, double r, double r2, bool fused)
{
    const double e = bell(r2 * (k->inverse_h * k->inverse_h), fused), cut = r * k->inverse_h >= 3 ? 0 : e;
    return (KernelValue){k->alpha * cut, k->slope * cut, -2 * (k->inverse_h * k->inverse_h) * (k->slope * cut)};
}

/* DO(type, shape, ...) for each kernel. The one list of them, as a loop is compiled for each. */
#define EACH_KERNEL(DO, ...)                                                                                           \
    DO(MNS_WENDLAND_C2, wendland_c2, __VA_ARGS__)                                                                      \
    DO(MNS_TRUNCATED_GAUSSIAN, truncated_gaussian, __VA_ARGS__)                                                        \
    DO(MNS_QUINTIC_SPLINE, quintic_spline, __VA_ARGS__)

/* The shape of a kernel where it is not known when a loop is compiled: under a sanitizer, which takes minutes for a loop of each. */
#define KERNEL_RETURN(type, shape, nothing)                                                                            \
    case type: return shape;
static inline KernelShape kernel_shape_of(MnsKernel type)
{
    switch (type) {
        EACH_KERNEL(KERNEL_RETURN, )
    }
    return NULL;
}

/* CALL(shape) with that of a kernel. */
#define KERNEL_CASE(type, shape, CALL)                                                                                 \
    case type:                                                                                                         \
        CALL(shape);                                                                                                   \
        break;
#define WITH_KERNEL(type, CALL)                                                                                        \
    switch (type) {                                                                                                    \
        EACH_KERNEL(KERNEL_CASE, CALL)                                                                                 \
    }

#endif
