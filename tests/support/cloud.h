/* SPDX-License-Identifier: BSD-3-Clause */
/* A handful of particles without a case, for tests of the solver's inner parts: any positions, any fields. */
#ifndef SUPPORT_CLOUD_H
#define SUPPORT_CLOUD_H

#include "sim/pass.h"
#include "sim/scheme.h"
#include "sim/solve/solve.h"

/* Whose particle may be at a point of the lattice. */
enum { CLOUD_WATER, CLOUD_AIR, CLOUD_WALL, CLOUD_NOTHING };

typedef struct Cloud {
    Model model;
    Particles s;
    Neighbours nb;
    System system;
    int threads;
} Cloud;

typedef struct CloudSetup {
    int dim;
    double dx;
    size_t n[3]; /* lattice points along each direction; the domain is n dx wide, from 0 */
    bool periodic[3];
    double jitter;                   /* random displacement up to this many dx each way */
    double outside;                  /* every seventh particle is put up to this many domain lengths elsewhere */
    int (*owner)(const double x[3]); /* NULL: all water */
    MnsKernel kernel;
    double smoothing; /* h/dx; 0: 1.3 */
    double skin;      /* over dx */
    int threads;      /* 0: 1 */
    bool viscous;
    bool flowing;      /* all fluids by continuity */
    bool calibrated;   /* the kernel, to the lattice */
    bool reconstructs; /* dissipates beside linear flows: strains take the place of gradients and normals in bundles */
} CloudSetup;

/* Water (density 1000, by continuity) and air (density 1, by summation), speed of sound 20, one wall (phase 2). Each
 * particle has the volume and density of its kind at rest, no pressure, no velocity, a sum of W V of 1. All options of all schemes
 * are on: dissipation of 0.5, repulsion of 0.08, shifting of 2 along interfaces, a tension of 0.7, an offset of 0.2 in density
 * corrections. Lists are built. Ends the test if it
 * cannot. */
Cloud *cloud_new(const CloudSetup *setup);
void cloud_free(Cloud *cloud);

/* In disorder, both fluids by continuity, as P3 has them where it reconstructs; the air of this density is a gas to the water if it is that light. */
Cloud *cloud_reconstructing(int dim, double light, int (*owner)(const double x[3]));

/* An owner: water below an inclined plane, air above it. */
int cloud_two_fluids(const double x[3]);

/* Build the lists again from where the particles are now, which may change their order. */
MnsStatus cloud_build(Cloud *cloud);

/* Sums of one term for all its particles, after a and rate were set to zero. */
void cloud_term(Cloud *cloud, const Term *term);

/* Have all masses so that fluid has this density; volumes stay. */
void cloud_weigh(Cloud *cloud, unsigned fluid, double density);

/* Fluid pressures, velocities and densities without any symmetry; p below 10 % of rho c^2 and of either sign, so that
 * the pair p* has both, |v| below a tenth of c. m stays, and V follows rho. */
void cloud_stir(Cloud *cloud, uint64_t seed);

/* In [-1, 1), deterministic. */
double cloud_noise(uint64_t *seed);

/* From j to i, the nearest of its images, and how far that is. */
double cloud_distance(const Cloud *cloud, size_t i, size_t j, double ret_dx[3]);

/* A pair, from nothing but positions: x_i - x_j to the nearest image, its length, W and F. */
typedef struct CloudPair {
    double dx[3], r, W, F;
} CloudPair;
CloudPair cloud_pair(const Cloud *cloud, size_t i, size_t j);

/* What a particle takes up, and its rho c. */
static inline double cloud_volume(const Cloud *cloud, size_t i)
{
    return particles_volume(&cloud->s, &cloud->model, i);
}

static inline double cloud_impedance(const Cloud *cloud, size_t i)
{
    return particles_impedance(&cloud->s, &cloud->model, i);
}

/* Storage index of a particle, by its id. */
size_t cloud_index(const Cloud *cloud, uint32_t id);

/* Sums over all fluid of what terms should leave unchanged: momentum per time, and its size for rounding. */
void cloud_assert_no_force(const Cloud *cloud, double rounding);

/* The inverse of a matrix that needs no pivots, as sums of x (x) x do not; by Gauss and Jordan. */
void cloud_invert(double of[3][3], int dim, double ret[3][3]);

/* Is i so far inside the lattice that its neighbours are on all sides? */
bool cloud_inner(const Cloud *cloud, size_t i);

#endif
