/* SPDX-License-Identifier: BSD-3-Clause */
/* Smoothing kernels W(r, h) and F = (1/r) dW/dr, so that the gradient of W at i is F (x_i - x_j). See schemes/README.md. */
#ifndef SIM_KERNEL_H
#define SIM_KERNEL_H

#include <meniscus/case.h>

typedef struct Kernel {
    MnsKernel type;
    double h;         /* smoothing length          [m]      */
    double support;   /* W = 0 from this distance on [m]    */
    double alpha;     /* normalisation of W         [m^-dim] */
    double beta;      /* the same of F; alpha unless calibrated */
    double steepness; /* F is steepness beta / h^2 times a function of q (kernel_shape.h) */
} Kernel;

#define NOTHING_NEAR 1e-12 /* a sum of W V up to this is rounding: of points that no particle is in reach of */

Kernel kernel_make(MnsKernel type, int dim, double h);

/* W[k], F[k] for r[k] >= 0, k < n; both 0 beyond the support, up to a rounding error of r. W in m^-dim, F in m^-(dim+2). */
void kernel_eval(const Kernel *kernel, size_t n, const double *r, double *W, double *F);

double kernel_at_zero(const Kernel *kernel);

/* Sum of a quantity of pairs over a lattice with this spacing in each direction, the particle itself included. */
typedef double (*KernelQuantity)(const Kernel *kernel, int dim, const double x[3], double r, double W, double F);
double kernel_lattice_sum(const Kernel *kernel, int dim, const double spacing[3], KernelQuantity quantity);

/* W: the number density of the lattice [m^-dim]. -F r^2/dim: times the volume of a cell, the gradient of u = x; 1 is right. */
double kernel_quantity_number(const Kernel *kernel, int dim, const double x[3], double r, double W, double F);
double kernel_quantity_slope(const Kernel *kernel, int dim, const double x[3], double r, double W, double F);

/* W r^2/dim: times the volume of a cell, the mean of x^2 over the kernel [m^2]. */
double kernel_quantity_spread(const Kernel *kernel, int dim, const double x[3], double r, double W, double F);

/* Scale W and F, each by its own constant, so that the density of this lattice and the gradient of a linear field on it are
 * exact (the mean over the directions). Sums over particles never equal the integrals that the kernel's constant is made
 * for, and no refinement brings them there: 1.2 % and -2.4 % with Wendland C2 at h = 1.3 dx in two dimensions. */
void kernel_calibrate(Kernel *kernel, int dim, const double spacing[3]);

#endif
