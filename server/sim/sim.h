/* SPDX-License-Identifier: BSD-3-Clause */
/* The inside of a simulation, for the files of this folder. */
#ifndef SIM_SIM_H
#define SIM_SIM_H

#include "sim/constants.h"
#include "sim/pass.h"
#include "sim/shape.h"
#include "sim/solve/solve.h"
#include <math.h>

enum { SIM_TIMERS_MAX = SCHEME_PASSES_MAX + 6, SIM_WARNINGS_MAX = 16, SIM_TOLD_MAX = 8 };
enum { SIM_BLOCK = 4096 }; /* particles that are summed up by one thread */
enum { SIM_SUMS = 20 };    /* at most at once */
enum { TIMER_NEIGHBOURS, TIMER_DRIFT, TIMER_KICK, TIMER_REST, TIMER_PASSES };

/* How the projections of the last step went. */
typedef struct Solved {
    unsigned iterations, corrections, density_iterations; /* of the velocity's solve; of the density, all of the step */
    double residual, density_error;                       /* what is left, relative */
} Solved;

/* Fields that somebody has asked for and that are not stored. */
typedef struct Shown {
    double *of[FIELDS_END][3]; /* [n]; NULL: not asked for yet */
} Shown;

/* What of a velocity is along the surface at each particle of walls that have one: a symmetric matrix, xx, yy, zz, xy, xz, yz. */
typedef struct Belts {
    size_t n;
    uint32_t *id;       /* [n] of the particle, rising */
    double (*along)[6]; /* [n] */
} Belts;

/* Which sides of the domain walls close (sides.h). */
typedef struct Sides {
    size_t leader[MNS_MAX_WALLS];   /* the first wall that moves as this one does */
    unsigned closed[MNS_MAX_WALLS]; /* sides, a bit each, by those that move as a leader does */
} Sides;

/* What the energy account compares the next step with: sums of the fluid's mass, and of what gravity acts on of it, times position and velocity; velocity of the first
 * wall. */
typedef struct Before {
    double moment[3], momentum[3], fall[3], wall[3];
} Before;

/* The drop or bubble that surface tension presses most. */
typedef struct Curved {
    double capillary, across; /* sigma/R [Pa], 2 R [m]; 0: no drop */
    bool bound; /* R is that of a ball of its volume, as it lies against a wall that is not flat: it may be larger */
} Curved;

/* How a fluid lies at the start, for what its equation of state has to carry (sounds.h). */
typedef struct FluidStart {
    double min[3], max[3];           /* that its particles reach [m] */
    bool drops;                      /* all of it is drops or bubbles */
    double across;                   /* the largest of them [m] */
    Curved most, in[MNS_MAX_FLUIDS]; /* of all of them, and of those in each other fluid */
} FluidStart;

/* Gravity's mean over a time, as last found. */
typedef struct PullMean {
    bool known;
    double from, to, of[3];
} PullMean;

struct MnsSim {
    const MnsCase *c; /* borrowed */
    const Scheme *scheme;
    Model model;
    Particles s;
    Neighbours nb;
    int threads;
    MnsMaking making; /* while it is made */
    Watcher watcher;  /* of its steps */
    MnsProgress progress;
    bool resumed; /* made from a saved state, which the initial fields of the case have no part in */
    double v_max; /* of the fluid, at the end of the last step [m/s] */
    double whole; /* length that the present step would have if it were not cut short [s] */
    Formula *gravity[3];
    PullMean pull;
    Formula *surface[MNS_MAX_WALLS][3]; /* velocity of a wall's surface */
    Shape solid[MNS_MAX_WALLS];         /* where the case puts the walls */
    Face *face;                         /* of all of them, as far as they are flat */
    Belts belts;                        /* of walls whose surface has a velocity of its own */
    Sides sides;
    FormulaTeam probe_formula[MNS_MAX_PROBES];
    FluidStart start[MNS_MAX_FLUIDS];
    struct {
        double sound[MNS_MAX_FLUIDS]; /* [m/s]; 0: not yet */
    } advised;                        /* by warnings, which are not given again for little more */
    Shown *shown;
    double *partial; /* [sim_blocks(fluid) * SIM_SUMS] work space of sums over the fluid */
    Before before;
    struct {
        bool energy, escaped, bare, crowded,
            cut; /* too much; too many; places without fluid; more on one side; interfaces by faces that do not mirror */
    } told;      /* by warnings as it goes */
    System system; /* for the pressure, of schemes that project */
    Solved solved;
    const char *solver; /* the method by which the last system was solved; NULL: none was yet */
    MnsLosses losses;
    uint64_t uncorrected; /* steps after which a number density was off by more than its tolerance */
    MnsTimer timers[SIM_TIMERS_MAX];
    size_t n_timers, timer_setup, timer_solve; /* of what methods set up, and of the rest; of schemes that project */
    MnsError fault;                            /* said again by every further step */
    size_t n_warnings, n_told;                 /* all of them; of those, told as it goes */
    char warning[SIM_WARNINGS_MAX + SIM_TOLD_MAX][512]; /* about the case, found when it was loaded or as it goes */
};

/* sim.c: a fault that further steps are refused for; returns its status */
MnsStatus sim_remember(MnsSim *sim, MnsStatus status, const MnsError *why, MnsError *error);

/* sim.c: how many threads a case gets */
int sim_threads_for(const MnsCase *c);

/* plan.c: refuse to go on to the end of c with steps as long as the present state allows, or to write its files, if that is
 * without end, one under way only where it would count as diverged soon; the smallest step before it does; find what to warn of in a new
 * simulation */
MnsStatus plan_check(const MnsSim *sim, const MnsCase *c, bool under_way, MnsError *error);
double plan_floor(const MnsSim *sim);
void plan_look(MnsSim *sim);

/* plan.c: warn of what can be set while it runs and does not suit the case */
void plan_look_at_options(MnsSim *sim);

/* plan.c: one more warning of the case, the entry first, unless it is there already; where there are too many, the last says so. And one of what has happened, for which there is room of
 * its own */
void plan_warn(MnsSim *sim, const char *format, ...) __attribute__((format(printf, 2, 3)));
void plan_tell(MnsSim *sim, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* check.c: number of particles along d, and the spacing stretched to fit */
size_t case_fit(const MnsCase *c, int d, double *ret_spacing);

/* build.c: lattice, particles, initial fields */
MnsStatus build_particles(MnsSim *sim, const Constants *constants, MnsError *error);

/* setup.c: from the case to the model; gravity and walls at t, dt after they were last set, with a gravity and velocities that are means from
 * then until `ahead` after t */
MnsStatus setup_model(MnsSim *sim, MnsError *error);
void setup_options(MnsSim *sim, const MnsCase *c);
void setup_at(MnsSim *sim, double t, double dt, double ahead);

/* setup.c: MNS_E_INVALID if a probe of c asks for a field that the scheme does not have with the options of the model */
MnsStatus setup_probes(const MnsSim *sim, const MnsCase *c, MnsError *error);

/* setup.c: MNS_E_INVALID if a formula of gravity fails within a step or at its end t, or one of a wall there or, where it is asked for, half-way,
 * or that of a probe has failed, with its entry; nothing is changed */
MnsStatus setup_check(MnsSim *sim, double t, double dt, MnsError *error);

static inline size_t sim_blocks(size_t n)
{
    return (n + SIM_BLOCK - 1) / SIM_BLOCK;
}

/* Can a run go on from particle i, of squared speed v2? Not from what is no number. */
static inline bool sim_is_well(const Particles *s, const Model *model, size_t i, double v2)
{
    const double ratio = s->rho[i] / model->phase[s->phase[i]].rho0;
    return v2 < INFINITY && ratio > model->density_min && ratio < model->density_max;
}

/* fault.c: say which particle is to blame for a divergence, where it is, and by which term */
MnsStatus fault_particle(MnsSim *sim, MnsError *error);
MnsStatus fault_time_step(MnsSim *sim, double dt, const Limit *limit, MnsError *error);

/* guard.c: keep fluid particles out of walls; returns how often it had to */
uint64_t guard_walls(MnsSim *sim);

#endif
