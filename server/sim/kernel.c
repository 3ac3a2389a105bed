/* SPDX-License-Identifier: BSD-3-Clause */
/* Smoothing kernels. Outside the support all are 0, the Gaussian by a choice and the others by their formulas, so that nobody
 * else need ask whether a pair is in reach. */
#include "sim/kernel_shape.h"
#include <math.h>

#define SQRT_PI 1.77245385090551602730

/* The other half of what a kernel is; its shape is in kernel_shape.h. */
static const struct {
    double reach;              /* support over h */
    double steepness;          /* of F */
    double plane[2], space[2]; /* alpha h^dim in two and three dimensions: numerator, denominator */
} KERNELS[] = {
    [MNS_WENDLAND_C2] = {2, -5, {7, 4 * M_PI}, {21, 16 * M_PI}},
    [MNS_TRUNCATED_GAUSSIAN] = {3, -2, {1, M_PI}, {1, M_PI *SQRT_PI}},
    [MNS_QUINTIC_SPLINE] = {3, -5, {7, 478 * M_PI}, {1, 120 * M_PI}},
};

Kernel kernel_make(MnsKernel type, int dim, double h)
{
    const double *fraction = dim == 2 ? KERNELS[type].plane : KERNELS[type].space;
    const double alpha = fraction[0] / (fraction[1] * (dim == 2 ? h * h : h * h * h));
    return (Kernel){.type = type,
                    .h = h,
                    .support = KERNELS[type].reach * h,
                    .alpha = alpha,
                    .beta = alpha,
                    .steepness = KERNELS[type].steepness};
}

INLINE void eval(const Kernel *kernel, size_t n, const double *restrict r, double *restrict W, double *restrict F,
                 KernelShape shape)
{
    const KernelScale k = kernel_scale(kernel);
    for (size_t i = 0; i < n; i++) {
        const KernelValue value = shape(&k, r[i], r[i] * r[i], false);
        W[i] = value.W;
        F[i] = value.F;
    }
}

void kernel_eval(const Kernel *kernel, size_t n, const double *r, double *W, double *F)
{
#define EVAL(shape) eval(kernel, n, r, W, F, shape)
    WITH_KERNEL(kernel->type, EVAL);
}

double kernel_at_zero(const Kernel *kernel)
{
    const double r = 0;
    double W = 0, F = 0;
    kernel_eval(kernel, 1, &r, &W, &F);
    return W;
}

double kernel_lattice_sum(const Kernel *kernel, int dim, const double spacing[3], KernelQuantity quantity)
{
    int reach[3] = {0, 0, 0};
    for (int d = 0; d < dim; d++) reach[d] = (int)ceil(kernel->support / spacing[d]);
    double sum = 0;
    for (int z = -reach[2]; z <= reach[2]; z++)
        for (int y = -reach[1]; y <= reach[1]; y++)
            for (int x = -reach[0]; x <= reach[0]; x++) {
                const double at[3] = {x * spacing[0], y * spacing[1], dim == 3 ? z * spacing[2] : 0};
                const double r = sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
                double W = 0, F = 0;
                kernel_eval(kernel, 1, &r, &W, &F);
                sum += quantity(kernel, dim, at, r, W, F);
            }
    return sum;
}

double kernel_quantity_number(const Kernel *kernel, int dim, const double x[3], double r, double W, double F)
{
    (void)kernel, (void)dim, (void)x, (void)r, (void)F;
    return W;
}

double kernel_quantity_slope(const Kernel *kernel, int dim, const double x[3], double r, double W, double F)
{
    (void)kernel, (void)x, (void)W;
    return -F * r * r / dim;
}

double kernel_quantity_spread(const Kernel *kernel, int dim, const double x[3], double r, double W, double F)
{
    (void)kernel, (void)x, (void)F;
    return W * r * r / dim;
}

void kernel_calibrate(Kernel *kernel, int dim, const double spacing[3])
{
    double volume = 1;
    for (int d = 0; d < dim; d++) volume *= spacing[d];
    const double number = volume * kernel_lattice_sum(kernel, dim, spacing, kernel_quantity_number);
    const double slope = volume * kernel_lattice_sum(kernel, dim, spacing, kernel_quantity_slope);
    kernel->alpha /= number;
    kernel->beta /= slope;
}
