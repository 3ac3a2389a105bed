/* SPDX-License-Identifier: BSD-3-Clause */
/* Smoothing kernels W(r, h) and F = (1/r) dW/dr, so that the gradient of W at i is F (x_i - x_j). See schemes/README.md. */
#ifndef SIM_KERNEL_H
#define SIM_KERNEL_H

#include <meniscus/case.h>

typedef struct Kernel {
    MnsKernel type;
    double h;       /* smoothing length          [m]      */
    double support; /* W = 0 from this distance on [m]    */
    double alpha;   /* normalisation              [m^-dim] */
} Kernel;

Kernel kernel_make(MnsKernel type, int dim, double h);

/* W[k], F[k] for r[k] >= 0, k < n; both 0 beyond the support, up to a rounding error of r. W in m^-dim, F in m^-(dim+2). */
void kernel_eval(const Kernel *kernel, size_t n, const double *r, double *W, double *F);

double kernel_at_zero(const Kernel *kernel);

/* Sum of W over a lattice with this spacing in each direction, the particle itself included: the number density of the
 * initial lattice [m^-dim]. */
double kernel_lattice_sum(const Kernel *kernel, int dim, const double spacing[3]);

#endif
