/* SPDX-License-Identifier: BSD-3-Clause */
/** case.h - description of a run as plain values, in SI units: what the solver starts from.
 *
 *  proto/case.proto says what each entry means, its unit, bounds and default; this is the same without messages. Strings
 *  are never NULL. Vectors have three components; in two dimensions the third is 0 or, for formulas, "0". */
#ifndef MENISCUS_CASE_H
#define MENISCUS_CASE_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { MNS_MAX_FLUIDS = 16, MNS_MAX_WALLS = 64, MNS_MAX_PROBES = 256 };

typedef enum MnsPrimitive { MNS_BOX, MNS_BALL, MNS_CYLINDER, MNS_PLATE, MNS_HALF_SPACE, MNS_FORMULA } MnsPrimitive;
typedef enum MnsOperation { MNS_ADD, MNS_SUBTRACT, MNS_INTERSECT } MnsOperation;

typedef struct MnsPart {
    MnsOperation operation;
    bool outside;
    MnsPrimitive primitive;
    double a[3];   /* box: lower corner; ball, plate: centre; cylinder: from; half space: point  [m]  */
    double b[3];   /* box: upper corner; plate: along; cylinder: to; half space: normal               */
    double c[3];   /* plate: normal                                                                   */
    double radius; /* ball, cylinder                                                             [m]  */
    double length, width, thickness; /* plate                                                    [m]  */
    char *formula;
} MnsPart;

typedef struct MnsShape {
    size_t n;
    MnsPart *parts; /* [n] */
} MnsShape;

typedef struct MnsConstant {
    char *name, *value;
} MnsConstant;

typedef enum MnsDensityMethod { MNS_DENSITY_AUTOMATIC, MNS_DENSITY_CONTINUITY, MNS_DENSITY_SUMMATION } MnsDensityMethod;

typedef struct MnsFluid {
    char *name;
    double density, viscosity; /* [kg/m^3], [Pa s] */
    double sound_speed;        /* [m/s]; of no meaning to an incompressible scheme */
    MnsShape shape;            /* no parts: what the others leave */
    char *velocity[3];         /* formulas of x y z [m/s] */
    char *pressure;            /* formula of x y z [Pa], "hydrostatic" or "laplace" */
    MnsDensityMethod density_method;
    double exponent; /* of Tait's equation; 0: that of its kind */
} MnsFluid;

typedef enum MnsMotionKind { MNS_STILL, MNS_SINE, MNS_ONE_MINUS_COSINE, MNS_TABLE } MnsMotionKind;

typedef struct MnsMotionPoint {
    double t, x[3], v[3]; /* [s], displacement [m], velocity [m/s] */
} MnsMotionPoint;

typedef struct MnsMotion {
    MnsMotionKind kind;
    double amplitude[3], frequency, phase; /* [m], [Hz], [rad] */
    size_t n;
    MnsMotionPoint *points; /* [n] */
} MnsMotion;

typedef struct MnsWall {
    char *name;
    MnsShape shape;
    bool no_slip;
    MnsMotion motion;
    char *surface_velocity[3]; /* formulas of t [m/s] */
} MnsWall;

typedef enum MnsKernel { MNS_WENDLAND_C2, MNS_TRUNCATED_GAUSSIAN, MNS_QUINTIC_SPLINE } MnsKernel;

typedef enum MnsReconstruction {
    MNS_RECONSTRUCTION_NONE,
    MNS_RECONSTRUCTION_VELOCITY,
    MNS_RECONSTRUCTION_BOTH /* pressure too */
} MnsReconstruction;

/* P3 */
typedef struct MnsRiemann {
    double limiter;                                        /* slope in beta = min(slope max(U_L - U_R, 0), c) */
    double background_pressure, heavy_background_pressure; /* of the transport velocity, over rho c^2 */
    double guard;                                          /* distance kept from walls, over dx; 0: none */
    bool transport_stress;                                 /* eq. 12 */
    MnsReconstruction reconstruction;                      /* of what is dissipated */
} MnsRiemann;

typedef enum MnsPairAverage { MNS_AVERAGE_ARITHMETIC, MNS_AVERAGE_DENSITY } MnsPairAverage;

typedef enum MnsDissipationForm {
    MNS_DISSIPATION_GENERALIZED,
    MNS_DISSIPATION_NO_VOLUME_FACTOR,
    MNS_DISSIPATION_PLAIN
} MnsDissipationForm;

/* P1 */
typedef struct MnsDissipation {
    double delta;               /* eq. 49 */
    double repulsion;           /* of unlike fluids, a part of their pressure forces */
    double background_pressure; /* added to all pressures [Pa] */
    double guard;               /* as in MnsRiemann */
    MnsDissipationForm form;
    MnsPairAverage pair_average;
    bool gradient_correction; /* in continuity and pressure force */
} MnsDissipation;

typedef enum MnsShifting { MNS_SHIFTING_OFF, MNS_SHIFTING_INTERFACE, MNS_SHIFTING_ORIGINAL } MnsShifting;

/* P2; what is not said is as in MnsDissipation. */
typedef struct MnsInterfacial {
    double delta;
    double shifting_strength; /* A in A h |v| dt */
    double repulsion, background_pressure, guard;
    MnsShifting shifting;
    MnsPairAverage pair_average;
    bool gradient_correction;
} MnsInterfacial;

typedef enum MnsMobility { MNS_MOBILITY_BY_RATIO, MNS_MOBILITY_DENSITY, MNS_MOBILITY_UNIT } MnsMobility;
typedef enum MnsGauge { MNS_GAUGE_MINIMUM, MNS_GAUGE_MEAN } MnsGauge;
typedef enum MnsSolver { MNS_SOLVER_BY_SIZE, MNS_SOLVER_CG, MNS_SOLVER_BICGSTAB, MNS_SOLVER_AMG } MnsSolver;

/* P4 */
typedef struct MnsIncompressible {
    double density_tolerance;                   /* of a number density, over that of the lattice */
    double density_offset;                      /* reference pressure of the density's correction, over rho h^2 */
    double tolerance, density_solver_tolerance; /* residuals of the two pressures, over those of none */
    double guard;                               /* as in MnsRiemann */
    double reference_speed;                     /* [m/s]; below 0: by gravity and the height of the domain */
    unsigned density_corrections;               /* in a step, at most */
    unsigned density_patience;                  /* of those that hardly help, in a row */
    unsigned iterations;                        /* of a solve, at most */
    MnsMobility mobility;
    MnsGauge gauge;
    MnsSolver solver;
} MnsIncompressible;

typedef enum MnsDiffusion {
    MNS_DIFFUSION_DIVTAU,
    MNS_DIFFUSION_HARMONIC,
    MNS_DIFFUSION_CONSERVATIVE,
    MNS_DIFFUSION_SPH
} MnsDiffusion;

/* P5; what is not said is as in MnsIncompressible. */
typedef struct MnsDifferences {
    MnsDiffusion diffusion;
    double interface_threshold; /* gradient of the colour at an interface, times h */
    double shifting_strength;   /* C in C U dt */
    double tolerance, guard, reference_speed;
    int buoyant_in; /* fluid, or -1 */
    bool shift_across_interfaces;
    bool holds_pressure;     /* 0 at this point, else its mean */
    double zero_pressure[3]; /* [m] */
    unsigned iterations;
    MnsSolver solver; /* not MNS_SOLVER_CG */
} MnsDifferences;

/* Those of the scheme that is named count. */
typedef struct MnsSchemeOptions {
    const char
        *name; /* of the scheme: "riemann", "dissipation", "interfacial", "incompressible", "differences"; a literal */
    MnsKernel kernel;
    double smoothing, skin; /* h and what lists reach farther than the kernel, over dx */
    double cfl;             /* dt <= cfl h / (c + |v|) */
    MnsRiemann riemann;
    MnsDissipation dissipation;
    MnsInterfacial interfacial;
    MnsIncompressible incompressible;
    MnsDifferences differences;
} MnsSchemeOptions;

typedef enum MnsProbeKind {
    MNS_PROBE_PRESSURE,
    MNS_PROBE_HEIGHT,
    MNS_PROBE_FRONT,
    MNS_PROBE_KINETIC_ENERGY,
    MNS_PROBE_POTENTIAL_ENERGY,
    MNS_PROBE_MASS_CENTRE,
    MNS_PROBE_MOMENTUM,
    MNS_PROBE_MASS,
    MNS_PROBE_EXTREMUM,
    MNS_PROBE_COVERAGE,
    MNS_PROBE_ESCAPED,
    MNS_PROBE_PRESSURE_DEVIATION,
    MNS_PROBE_VELOCITY,
    MNS_PROBE_VOLUME,
    MNS_PROBE_ELEVATION,
    MNS_PROBE_EXTENT,
    MNS_PROBE_ROUNDNESS,
    MNS_PROBE_SURFACE_AREA,
    MNS_PROBE_PRESSURE_JUMP,
    MNS_PROBE_SOLVER
} MnsProbeKind;

typedef enum MnsSolverQuantity {
    MNS_SOLVER_ITERATIONS,
    MNS_SOLVER_RESIDUAL,
    MNS_SOLVER_CORRECTIONS,
    MNS_SOLVER_CORRECTION_ITERATIONS,
    MNS_SOLVER_DENSITY_ERROR
} MnsSolverQuantity;

typedef struct MnsProbe {
    char *name;
    MnsProbeKind kind;
    int fluid;       /* index, or -1 for all fluids */
    unsigned fluids; /* of an elevation, a bit for each instead; 0: all fluids */
    int wall;        /* index of the wall it moves with, or -1 */
    int axis;        /* 0, 1, 2; for a height or an elevation, the vertical one */
    bool least;      /* extremum, extent: smallest; elevation: lowest; front: backwards */
    double at[3];    /* [m]; for a height or an elevation, its coordinate along the axis does not count */
    double radius;   /* [m]; 0: the support of the kernel; of a pressure jump, the margin */
    bool within;     /* whether the box below counts */
    double min[3], max[3];
    char *field;                /* extremum */
    char *formula;              /* pressure deviation */
    MnsSolverQuantity quantity; /* solver */
} MnsProbe;

typedef struct MnsOutput {
    double probe_interval, snapshot_interval, checkpoint_interval, checkpoint_wall_interval; /* [s] */
    unsigned checkpoints_kept;
    size_t n_fields;
    char **fields; /* [n_fields] */
    bool walls;
} MnsOutput;

typedef struct MnsLimits {
    double time_step_floor;          /* over the first step */
    double density_min, density_max; /* over the reference density */
} MnsLimits;

typedef struct MnsCase {
    char *title;
    int dim;                             /* 2 or 3 */
    double reference_length, resolution; /* [m], particles per reference length */
    double min[3], max[3];               /* domain [m] */
    bool periodic[3];
    double disorder; /* of the particles at the start, in spacings */
    unsigned seed;
    char *displacement[3]; /* of the lattice's points, formulas of x, y, z [m] */
    size_t n_constants;
    MnsConstant *constants;
    char *gravity[3]; /* formulas of t [m/s^2] */
    size_t n_fluids;
    MnsFluid *fluids;
    double tension[MNS_MAX_FLUIDS][MNS_MAX_FLUIDS]; /* between two fluids, either way round [N/m] */
    size_t n_walls;
    MnsWall *walls;
    MnsSchemeOptions scheme;
    double end_time; /* [s] */
    unsigned threads;
    size_t n_probes;
    MnsProbe *probes;
    MnsOutput output;
    MnsLimits limits;
} MnsCase;

/** Is the case physical, within limits, and can the scheme do it? Formulas are compiled and shapes measured; nothing is
 *  changed. @return MNS_OK; MNS_E_INVALID or MNS_E_LIMIT with error->path naming the entry, as in "fluids[1].density". */
MnsStatus mns_case_check(const MnsCase *c, MnsError *error);

/** Free a case and all it owns; NULL is fine. All of it must come from malloc, but for scheme.name. */
void mns_case_free(MnsCase *c);

#ifdef __cplusplus
}
#endif
#endif
