/* SPDX-License-Identifier: BSD-3-Clause */
/** sim.h - build a simulation, step it, look at it, copy its state out and in again. No network, no files, no messages;
 *  SI units throughout. One caller at a time; OpenMP inside. The bits of every result are the same for any number of threads.
 *
 *  What the process shares with it: the instruction set of mns_level_force(). Who links libmeniscus.a has its sin, cos, exp, log, pow ...,
 *  which are rounded correctly and take 0.1 to 1 us, in place of the C library's, in all of the program; the shared C library's stay
 *  where the simulation is in a process of its own. The first pressure that multigrid solves for initialises MPI as one process, and with it
 *  changes the environment, if mns_multigrid_environment() has not: then no other thread may call getenv() meanwhile. */
#ifndef MENISCUS_SIM_H
#define MENISCUS_SIM_H

#include <meniscus/case.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct MnsSim MnsSim;

/** Set what multigrid asks of the environment, where it is not set already (OMPI_MCA_...): for programs of several threads, before there are any. */
void mns_multigrid_environment(void);

/** Place the particles of a case and make it ready to step.
 *  @param c  borrowed until mns_sim_free(), or until mns_sim_steer() replaces it.
 *  @return MNS_OK; what mns_case_check() returns; MNS_E_LIMIT if it would take more than 1e9 steps to the end time, or more
 *          than 1e6 snapshots; MNS_E_MEMORY. On failure *ret_sim is untouched. */
MnsStatus mns_sim_new(const MnsCase *c, MnsSim **ret_sim, MnsError *error);

/** Free a simulation; NULL is fine. */
void mns_sim_free(MnsSim *sim);

/** What is allowed and hardly meant, found when the simulation was made, or told once as it goes: sentence k, from 0, with the entry at
 *  its beginning; NULL if there are no more. */
const char *mns_sim_warning(const MnsSim *sim, size_t k);

/** Advance by one time step: the smallest limit of the scheme, cut so that the step does not pass t_max. A step that ends
 *  within a rounding error of t_max ends exactly there.
 *  @param t_max  [s], later than the current time; INFINITY for no cut.
 *  @return MNS_OK; MNS_E_DIVERGED if a field is not finite, dt fell under its floor or a density left its bounds: the
 *          state is kept for inspection and further calls say the same; MNS_E_LIMIT if a particle has too many neighbours
 *          (the same). The sentence names the particle, the place and the term. MNS_E_MEMORY if there is none for lists or the pressure, MNS_E_INTERNAL
 *          if a library that solves for it fails (the same). MNS_E_INVALID if t_max has passed or a formula of the case
 *          would fail in the step, or a probe's has failed before: with its entry, and the simulation unchanged, so that it can go on
 *          after mns_sim_steer() to another gravity. */
MnsStatus mns_sim_step(MnsSim *sim, double t_max, MnsError *error);

/** Have it told that a step, or a steering, gets on: going_on(arg) is called after each pass over the particles, each making of lists and each iteration of a
 *  solve, on the thread that steps. So a step that takes minutes can be told from one that hangs. It must be quick, and must not call the simulation.
 *  @param going_on  NULL: nobody is told, as at first. */
void mns_sim_watch(MnsSim *sim, void (*going_on)(void *arg), void *arg);

/** Adopt the entries of c that proto/case.proto marks as steerable (gravity, end time, output, threads, scheme options);
 *  all others must be as they were. c takes the place of the case the simulation borrowed, which may then be freed.
 *  @return MNS_OK; MNS_E_INVALID, MNS_E_LIMIT as of mns_sim_new(); MNS_E_MEMORY if there is none for lists of other threads or for what
 *          an option needs: the simulation unchanged. */
MnsStatus mns_sim_steer(MnsSim *sim, const MnsCase *c, MnsError *error);

/** Would it be adopted now? As mns_sim_steer(), but for memory, and nothing is changed. */
MnsStatus mns_sim_check_steer(MnsSim *sim, const MnsCase *c, MnsError *error);

const MnsCase *mns_sim_case(const MnsSim *sim);

/** What has happened so far. All of it is part of the state: a restored run counts on. */
/** What a run's fluid had at its start and was given since, and what it has beyond that: the scheme's own. */
typedef struct MnsEnergy {
    bool known;         /* false: there is no account                                             */
    double start, work; /* kinetic, potential, elastic and surface energy at the start; done on the fluid since [J] */
    double excess;      /* the largest of energy - start - work so far [J]; 0: none that could be told from noise   */
    double scale;       /* the largest of kinetic energy and |change of potential energy| so far [J]                */
    double power;       /* of walls, at the end of the last step [W] */
    double potential;   /* potential energy at the start, by the gravity of now [J]                                 */
    double gravity[3];  /* that the potential energy is by [m/s^2]                                                  */
    double misplaced;   /* to which potential energy is known, at most so far, as positions are not exact [J]       */
    double lifted;      /* to which the work of gravity that changes is known, for the same reason [J]              */
    double middle
        [3]; /* sum of the fluids' volumes times positions at the start, in the frame of the first wall [m^(dim + 1)] */
} MnsEnergy;

typedef struct MnsProgress {
    double t;          /* [s]                                                                        */
    double dt;         /* last time step [s]; 0 before the first                                     */
    double dt_first;   /* first time step that was not cut by t_max [s]; 0 before                    */
    uint64_t step;     /* time steps done                                                            */
    uint64_t rebuilds; /* neighbour lists built                                                      */
    uint64_t guarded;  /* times a particle was kept from entering a wall                             */
    MnsEnergy energy;
} MnsProgress;

MnsProgress mns_sim_progress(const MnsSim *sim);

/** Energy that the scheme has made of nothing, over the largest of kinetic energy and change of potential energy so far; NAN where there
 *  was no memory for its account. Above 0.01, of the scheme differences 0.05, a warning has
 *  told it. */
double mns_sim_energy_excess(const MnsSim *sim);

/** What has been lost since the simulation was made or restored, as far as it was looked at: after 64, 128 and 256 steps, every 300 and at
 *  the end.
 *  escaped_share: of all fluid particles, the most that were outside of the domain or deep in walls. Above 0.01 a warning has told it.
 *  least_coverage: the least sum of W V. Below 0.3 a warning has told it. NAN: no look was due yet, or fluids did not fill the domain at
 *  the start. */
typedef struct MnsLosses {
    double escaped_share, least_coverage;
} MnsLosses;

MnsLosses mns_sim_losses(const MnsSim *sim);

/** Steps since the simulation was made or restored after which a number density was still off by more than the case allows, of schemes that
 *  correct it. The first of them is told by a warning as well. */
uint64_t mns_sim_uncorrected(const MnsSim *sim);

int mns_sim_threads(const MnsSim *sim);            /* of OpenMP's team */
size_t mns_sim_particles(const MnsSim *sim);       /* fluid and wall */
size_t mns_sim_fluid_particles(const MnsSim *sim); /* these come first in every field */
double mns_sim_spacing(const MnsSim *sim);         /* dx [m] */
double mns_sim_mean_neighbours(const MnsSim *sim); /* of a fluid particle, within the kernel's support */
size_t mns_sim_bytes(const MnsSim *sim); /* of particles, lists and pressure system; not what multigrid keeps */

/** Instruction set of the loops over pairs, as compilers name it: the best that the machine has ("x86-64-v4", "aarch64"), or the one
 *  asked for. All with the same arithmetic give the same bits: "fused", where products and the sums they are added to are rounded once, as
 *  machines with AVX2 and FMA can (most since 2013) and all of aarch64, or "separate".
 *  @return mns_level_force(): MNS_OK; MNS_E_INVALID if there is no such level, or not on this machine. For runs made later. */
const char *mns_level(void);
const char *mns_arithmetic(void);
MnsStatus mns_level_force(const char *name, MnsError *error);

/** Hash of the full state (every field of a checkpoint, by particle id, and the progress): independent of storage order and
 *  threads. */
uint64_t mns_sim_hash(const MnsSim *sim);

/* --- fields ------------------------------------------------------------------------------------------------------------ */

typedef enum MnsType { MNS_F64, MNS_U32, MNS_U8 } MnsType;

typedef struct MnsFieldInfo {
    const char *name, *unit, *meaning; /* "velocity", "m/s", "..." */
    int components;                    /* 1; or 3 for a vector, of which the case's dim are kept */
    MnsType type;
} MnsFieldInfo;

/** The table of all fields of all schemes; ends with a NULL name. Positions, identity and phase are fields too: "position" (m), "id" and
 *  "phase" (fluid particles: index of the fluid; wall particles: number of fluids + index of the wall). */
const MnsFieldInfo *mns_fields(void);

/** Index in mns_fields(), or -1. */
int mns_field_find(const char *name);

/** Which fields there are: bit k for field k of mns_fields(). mns_sim_steer() brings and takes those of options. */
uint64_t mns_sim_fields(const MnsSim *sim);

/** Borrow component d of a field: [mns_sim_particles()] values of its type, until the next step, steering or restoring. Both indices are those
 *  of mns_fields(); what lies beyond them is undefined. NULL if there is none,
 *  or if the scheme has no use for it. What can be made of others is not kept, but made at each call, in an array that is then kept; NULL
 *  if there is no memory for that. */
const void *mns_sim_field(const MnsSim *sim, int field, int d);

/* --- captures ---------------------------------------------------------------------------------------------------------- */

enum { MNS_MAX_FIELDS = 40 };

/** A copy of fields at one step boundary. Nobody changes it once it is made, so any thread may read it. */
typedef struct MnsCapture {
    int dim;
    size_t n, n_fluid; /* fluid particles first */
    double spacing;    /* dx [m] */
    MnsProgress progress;
    const char *level, *arithmetic; /* for good: as mns_level() and mns_arithmetic() name them; NULL: not known */
    const char *solver; /* name, for good, of the method by which pressures were solved for last; NULL: none were */
    uint64_t fields;    /* bit k set: field k of mns_fields() is here */
    void *data[MNS_MAX_FIELDS][3]; /* [n] values each */
} MnsCapture;

/** Copy fields out. @param fields  bit k for field k of mns_fields(); mns_sim_state_fields() for a checkpoint.
 *  @return MNS_OK; MNS_E_MEMORY. */
MnsStatus mns_sim_capture(const MnsSim *sim, uint64_t fields, MnsCapture **ret_capture, MnsError *error);

/** Copy fields out once more, into a capture that nobody reads any longer and that has as many particles and dimensions: what room it has is used
 *  again, which spares the operating system's handing out of memory. @return MNS_OK; MNS_E_STATE if it is of another size; MNS_E_MEMORY. */
MnsStatus mns_sim_recapture(const MnsSim *sim, uint64_t fields, MnsCapture *capture, MnsError *error);

/** An empty capture with room for its fields, to be filled by a reader. @return NULL if there is no memory. */
MnsCapture *mns_capture_new(int dim, size_t n, size_t n_fluid, uint64_t fields);

void mns_capture_free(MnsCapture *capture);

/** What a capture of these fields takes [bytes], but for a few. */
size_t mns_sim_capture_size(const MnsSim *sim, uint64_t fields);

/** Fields that a run goes on from, as bits: what its scheme keeps from one step to the next. Checkpoints and the hash are of them. */
uint64_t mns_sim_state_fields(const MnsSim *sim);

/** Put a captured state back. The run goes on bit for bit as if it had never stopped.
 *  @param sim  made from the case the captured run had at that time.
 *  @return MNS_OK; MNS_E_INVALID if the capture does not fit the case, MNS_E_VERSION if it has not all fields
 *          that the scheme goes on from: sim unchanged. MNS_E_LIMIT if a particle has too many neighbours, MNS_E_MEMORY: where
 *          the state was put back but its lists could not be made, steps are refused with the same until another one is. */
MnsStatus mns_sim_restore(MnsSim *sim, const MnsCapture *capture, MnsError *error);

/** A simulation that goes on from a captured state, bit for bit. Initial fields are not evaluated: what was steered since
 *  need not make sense for a beginning.
 *  @param c  the case the captured run had at that time; borrowed as by mns_sim_new().
 *  @return as of mns_sim_new() and mns_sim_restore(); on failure *ret_sim is untouched. */
MnsStatus mns_sim_resume(const MnsCase *c, const MnsCapture *capture, MnsSim **ret_sim, MnsError *error);

/** What making a simulation may take, and how to give it up. */
typedef struct MnsMaking {
    size_t memory;               /* bytes it may take; 0: no limit */
    const char *memory_is;       /* how the sentence goes on after "and 2 GB are": "free"; NULL: "allowed" */
    bool (*given_up)(void *arg); /* asked every few milliseconds, by any thread; once true, always; NULL: never */
    void *arg;
} MnsMaking;

/** The same as mns_sim_new(), or with a capture as mns_sim_resume(), within limits.
 *  @param making  NULL: none.
 *  @return besides: MNS_E_MEMORY before more memory is taken than it may be, as far as that can be told from the number of
 *          particles; MNS_E_INTERRUPTED if it was given up. */
MnsStatus mns_sim_make(const MnsCase *c, const MnsCapture *capture, const MnsMaking *making, MnsSim **ret_sim,
                       MnsError *error);

/* --- measuring --------------------------------------------------------------------------------------------------------- */

/** Value of probe k of the case, of its n_probes, now; NAN where there is nothing to measure, or where its formula fails, which the next step
 *  says. Cost: a loop over all fluid particles on all threads; of a height, an elevation or a pressure, of those around. A formula takes a
 *  tenth of a microsecond for each; roundness and surface area, in three dimensions, three for each particle of the box around
 *  the fluid. */
double mns_sim_probe(const MnsSim *sim, size_t k);

/** Unit of a probe, as in "Pa". */
const char *mns_probe_unit(const MnsProbe *probe);

/** A scalar field, or the magnitude of a vector field, at points: kernel average over the fluid (P3 eq. 21).
 *  @param field   index in mns_fields()
 *  @param d       component, or -1 for the magnitude of a vector
 *  @param points  [n][3], m
 *  @param values  [n]; NAN where no fluid is near. */
void mns_sim_sample(const MnsSim *sim, int field, int d, size_t n, const double (*points)[3], double *values);

/* --- the cost of a step ------------------------------------------------------------------------------------------------ */

typedef struct MnsTimer {
    const char *name; /* of the pass */
    double seconds;   /* wall-clock time since the simulation was made */
    uint64_t calls;
} MnsTimer;

/** Wall-clock time by pass, borrowed; *ret_n timers. */
const MnsTimer *mns_sim_timers(const MnsSim *sim, size_t *ret_n);

/* --- schemes ----------------------------------------------------------------------------------------------------------- */

/** Describe scheme number k (from 0): names, sources and equations of its passes and terms, as text for people.
 *  @return its name; NULL if there is no scheme k. */
const char *mns_scheme_describe(size_t k, char *text, size_t size);

#ifdef __cplusplus
}
#endif
#endif
