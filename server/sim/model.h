/* SPDX-License-Identifier: BSD-3-Clause */
/* What is the same for all particles during a step: box, kernel, fluids, walls, gravity, options. */
#ifndef SIM_MODEL_H
#define SIM_MODEL_H

#include "sim/kernel.h"
#include "sim/level.h"

/* A fluid. Named phase, as in the papers, since several fluids share one particle set. */
typedef struct Phase {
    double rho0, c, mu; /* reference density [kg/m^3], speed of sound [m/s], dynamic viscosity [Pa s] */
    double p_b;         /* background pressure of the transport velocity [Pa]; 0: it is not spread */
    double exponent;    /* of Tait's equation of state; 1: the linear one */
    double background;  /* in all pressures [Pa] */
    bool summation;     /* density by summation, and the stress of the transport velocity; else continuity */
    bool fills; /* it goes wherever there is room, as a gas does: by shifting, and with pairs that dissipate (gas.c) */
    double resists; /* of a Riemann problem's dissipation, what closing pairs of a fluid that fills have */
} Phase;

/* A wall, moving as a rigid body. */
typedef struct WallState {
    double x[3]; /* displacement [m] */
    double v[3]; /* mean velocity over the step [m/s] */
    double a[3]; /* acceleration of the motion [m/s^2] */
    double belt
        [3]; /* velocity of the surface besides, as the case gives it: what is along the surface acts (belts.h) [m/s] */
    bool no_slip, has_belt;
} WallState;

/* A flat face of a wall, where the case puts it. */
typedef struct Face {
    double point[3], normal[3]; /* in its middle; away from the wall [m], 1 */
    size_t wall;
} Face;

/* Options of schemes that solve for the pressure. */
typedef struct Projection {
    double density_tolerance, offset; /* of number densities, relative; of the correction pressure, over rho h^2 */
    double tolerance, correction_tolerance;     /* of the residuals of the two solves, relative */
    double speed;                               /* that the flow is expected to have at least [m/s] */
    unsigned corrections, patience, iterations; /* at most, in a step; in vain; in a solve */
    bool unit_mobility;                         /* density correction as of fluids of one density */
    bool mean_gauge;                            /* pressure has no mean; else its least in the light fluids is 0 */
    double faint; /* F of a pair of fluid and wall from which on it counts as none, below 0 [m^-(dim+2)] */
    MnsSolver solver;
} Projection;

/* Options of the scheme of differences. */
typedef struct Differences {
    MnsDiffusion diffusion;
    double share;     /* of the divergence at the start of a step, which the step removes; below 1 if it is cut short */
    double threshold; /* of the interface: gradient of the colour, times h */
    double shifting;  /* of particles to where there are fewer */
    double along;     /* 1: beside interfaces only along them; 0: anywhere */
    double buoyancy;  /* density that gravity does not act on [kg/m^3] */
    double scale;     /* dx^2 / volume of a cell: kernel sums are over this */
    bool holds;       /* the pressure is 0 at a point [m], and not in the mean */
    double zero[3];
} Differences;

/* What of the pressures of a pair P3's velocity v* leaves alone (terms/slope.h). */
typedef enum Spared { SPARED_NOTHING, SPARED_WEIGHT, SPARED_SLOPES } Spared;

typedef struct Model {
    Level level; /* of instructions */
    int dim;
    double dx, cell[3], cell_volume; /* nominal and fitted spacing [m]; volume of a lattice cell, V_0 [m^dim] */
    double min[3], max[3];           /* domain [m] */
    unsigned mirrors;                /* planes that mirror the fluid, a bit each (mirrors.h) */
    double mirror_at[6];             /* where they are: sides of the domain, or further in [m] */
    double period[3], frequency[3];  /* length of a periodic direction and its inverse; 0 where not periodic */
    bool periodic;                   /* in any direction */
    Kernel kernel;
    double spread; /* of the kernel on the lattice, the mean of x^2 [m^2] */
    double skin;   /* [m] */
    size_t n_phases, n_walls;
    Phase phase[MNS_MAX_FLUIDS];
    WallState wall[MNS_MAX_WALLS];
    size_t n_faces;
    const Face *face;               /* [n_faces] of all walls, as far as they are flat; borrowed */
    double c_max, rho_max, rho_min; /* of the fluids */
    bool viscous;                   /* any fluid */
    bool radial;                    /* viscosity acts along the line of a pair */
    double viscous_scale;           /* of the viscous sum, so that it is exact on the lattice */
    double radial_scale;            /* of that along the line of a pair [m^-2] */
    bool filled;                    /* at the start, no place was without fluid or wall, and no side open */
    bool closed;                    /* and never will be, as all walls move as one */
    bool transport_stress;          /* option of the scheme */
    bool reconstructs; /* of the velocities of a pair only what is left beside their linear part is dissipated */
    Spared spared;
    double t, dt;                      /* end of the current step [s], its length [s] */
    double lag;                        /* of velocities behind positions, where rates are found [s] */
    double gravity[3], gravity_now[3]; /* mean over the step, by which fluid is pushed; at t [m/s^2] */
    double cfl, limiter, guard;        /* options of the scheme; guard in [m] */
    double density_average;            /* 1: pairs are averaged by density; 0: arithmetically */
    double own_gradients;              /* 1: pressure gradients are found within a fluid; 0: across interfaces too */
    bool any_fills;                    /* a fluid fills */
    double delta, repulsion, shifting; /* of density dissipation, between unlike fluids, of particle shifting */
    bool dissipates_rest,
        keeps_pair_volume;        /* of the dissipation: only what is left beside a linear field; the factor */
    bool shifts_along_interfaces; /* and corrects from the same fluid; else P2's original */
    bool corrects_gradients;      /* in continuity and pressure force */
    Projection projection;
    Differences differences;
    bool tense;                                           /* is there any surface tension? */
    double tension[MNS_MAX_FLUIDS][MNS_MAX_FLUIDS];       /* [N/m] */
    double tension_share[MNS_MAX_FLUIDS][MNS_MAX_FLUIDS]; /* of the first one of the two (terms/jump.h) [N/m] */
    double density_min, density_max, dt_floor; /* limits, over the reference density and the first time step */
} Model;

/* A fluid lighter than a fiftieth of the heaviest is a gas to it. */
static const double GAS_DENSITY = 0.02;

static inline bool model_is_gas(const Model *model, double density)
{
    return density < GAS_DENSITY * model->rho_max;
}

/* How far a coordinate is on the inner side of a side of the domain [m]: sides 2 d and 2 d + 1 are the lower and the upper one in direction d. */
static inline double model_inside(const Model *model, int side, double x)
{
    return side % 2 ? model->max[side / 2] - x : x - model->min[side / 2];
}

/* How far a coordinate is before the plane that may be a mirror there [m]. */
static inline double model_before_mirror(const Model *model, int side, double x)
{
    return side % 2 ? model->mirror_at[side] - x : x - model->mirror_at[side];
}

/* x_i - x_j along direction d, to the nearest image. */
static inline double model_nearest(const Model *model, int d, double difference)
{
    return difference - model->period[d] * __builtin_rint(difference * model->frequency[d]);
}

#endif
